"""The scaled objective of a contact problem, and the same with the forces eliminated.

Its Hessian is kept as a matrix or, where it is known to be a diagonal plus one of low rank, in that
form: with many controls a product then costs little, and so does a QP (``controllers.qp.daqp``).
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.qp.diagonal_plus_low_rank import (
    DiagonalPlusLowRank,
    unconstrained_minimum,
)
from warp_softbody.controllers.qp.sparse_or_dense import Matrix
from warp_softbody.controllers.qpcc.contact.mode_blocks import Elimination
from warp_softbody.controllers.qpcc.contact.problem import ContactQPCC

FEW = 4
"""Controls a row of the squares from which on these are worth it: with fewer, DAQP's equations for
them cost more than the factor of a full matrix."""

ROUNDING = 1e-9
"""Diagonal, of the largest entry, up to which it is not told from rounding."""


class Eliminated(NamedTuple):
    """``1/2 u'Pu + c'u + constant`` over the controls alone."""

    P: Matrix
    c: FloatArray
    constant: float

    @property
    def least(self) -> float | None:
        """The least value, without rows and bounds; None where P is not definite."""
        least = unconstrained_minimum(self.P, self.c)
        return None if least is None else self.constant + least


class Quadratic(Protocol):
    """``1/2 z'Hz + c'z`` over z = (controls, forces).

    Attributes:
        c: (nu + 3K,).
        outputs: (m, 1 + nu + 3K), affine in (1, z): what ``eliminated`` asks ``ContactMaps`` for.
    """

    c: FloatArray
    outputs: FloatArray

    def times(self, z: FloatArray) -> FloatArray:
        """H z."""

    def matrix(self) -> FloatArray:
        """H."""

    def eliminated(self, elimination: Elimination) -> Eliminated:
        """The same where the forces are affine in the controls."""


def scaled_quadratic(problem: ContactQPCC, scale: FloatArray) -> tuple[Quadratic, float]:
    """The objective over z / scale, and the value that it is divided by, its largest curvature."""
    nu = problem.control_count
    c = problem.gradient * scale
    curvature = float(np.max((problem.hessian.diagonal() * scale * scale)[:nu]))
    size = curvature or float(np.max(np.abs(c))) or 1.0
    if 0 < FEW * len(problem.squares) <= nu and _clear(problem):
        return _Squares(problem, scale, c / size, size), size
    return _Full(problem, scale, c / size, size), size


def _clear(problem: ContactQPCC) -> bool:
    """Whether the diagonal stands out of the rounding of the squares."""
    least = float(problem.diagonal.min())
    return least > ROUNDING * float(problem.hessian.diagonal().max())


class _Full:
    """H as it is."""

    def __init__(self, problem: ContactQPCC, scale: FloatArray, c: FloatArray, size: float) -> None:
        self.c = c
        nu = problem.control_count
        hessian = problem.hessian * scale
        hessian *= (scale / size)[:, None]
        self._hessian = hessian
        self._count = nu
        # The slopes in the forces.
        self.outputs = np.concatenate([c[nu:, None], hessian[nu:]], axis=1)

    def times(self, z: FloatArray) -> FloatArray:
        product: FloatArray = self._hessian @ z
        return product

    def matrix(self) -> FloatArray:
        return self._hessian

    def eliminated(self, elimination: Elimination) -> Eliminated:
        nu = self._count
        start, forces = elimination.affine[:, 0], elimination.affine[:, 1:]
        slope, slopes = elimination.outputs[:, 0], elimination.outputs[:, 1:]
        half = forces.T @ (self._hessian[nu:, :nu] + slopes)
        half += half.T
        half *= 0.5
        half += self._hessian[:nu, :nu]
        gradient = self.c[:nu] + start @ self._hessian[nu:, :nu] + slope @ forces
        return Eliminated(half, gradient, 0.5 * float(start @ (self.c[nu:] + slope)))


class _Squares:
    """H = diag(d, 0) + S'S."""

    def __init__(self, problem: ContactQPCC, scale: FloatArray, c: FloatArray, size: float) -> None:
        self.c = c
        self._count = problem.control_count
        self._diagonal = problem.diagonal * scale[: self._count] ** 2 / size
        self._rows = problem.squares * (scale / np.sqrt(size))
        self.outputs = np.concatenate([np.zeros((len(self._rows), 1)), self._rows], axis=1)

    def times(self, z: FloatArray) -> FloatArray:
        product: FloatArray = (self._rows @ z) @ self._rows
        product[: self._count] += self._diagonal * z[: self._count]
        return product

    def matrix(self) -> FloatArray:
        whole: FloatArray = self._rows.T @ self._rows
        each = np.arange(self._count)
        whole[each, each] += self._diagonal
        return whole

    def eliminated(self, elimination: Elimination) -> Eliminated:
        nu = self._count
        start, forces = elimination.affine[:, 0], elimination.affine[:, 1:]
        first, rows = elimination.outputs[:, 0], elimination.outputs[:, 1:]
        gradient = self.c[:nu] + self.c[nu:] @ forces + first @ rows
        constant = float(self.c[nu:] @ start) + 0.5 * float(first @ first)
        return Eliminated(DiagonalPlusLowRank(self._diagonal, rows), gradient, constant)
