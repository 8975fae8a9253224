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
from warp_softbody.controllers.qpcc.contact.force_elimination import ForceElimination
from warp_softbody.controllers.qpcc.contact.problem import ContactQPCC

CONTROLS_A_ROW = 4
"""Controls for each row of the low-rank factor from which that form pays: with fewer, DAQP's
equalities for the rows cost more than factorising a full matrix."""

ROUNDING = 1e-9
"""Diagonal, relative to the largest entry, up to which it may be rounding of the factor."""


class ReducedObjective(NamedTuple):
    """``1/2 u'Pu + c'u + constant`` over the controls alone."""

    P: Matrix
    c: FloatArray
    constant: float

    @property
    def unconstrained_minimum(self) -> float | None:
        """The minimum without rows and bounds; None where P is not positive definite."""
        minimum = unconstrained_minimum(self.P, self.c)
        return None if minimum is None else self.constant + minimum


class ScaledObjective(Protocol):
    """``1/2 z'Hz + c'z`` over z = (controls, forces).

    Attributes:
        c: (nu + 3K,).
        outputs: (m, 1 + nu + 3K), maps of (1, z) that ``reduced`` needs with the forces eliminated.
    """

    c: FloatArray
    outputs: FloatArray

    def times(self, z: FloatArray) -> FloatArray:
        """H z."""

    def matrix(self) -> FloatArray:
        """H."""

    def reduced(self, elimination: ForceElimination) -> ReducedObjective:
        """The objective over the controls, with forces that are affine in them."""


def scaled_objective(problem: ContactQPCC, scale: FloatArray) -> tuple[ScaledObjective, float]:
    """The objective over z / scale, and the value by which it is divided, its largest curvature."""
    nu = problem.control_count
    c = problem.gradient * scale
    curvature = float(np.max((problem.hessian.diagonal() * scale * scale)[:nu]))
    size = curvature or float(np.max(np.abs(c))) or 1.0
    if 0 < CONTROLS_A_ROW * len(problem.squares) <= nu and diagonal_is_clear(problem):
        return _LowRankObjective(problem, scale, c / size, size), size
    return _DenseObjective(problem, scale, c / size, size), size


def diagonal_is_clear(problem: ContactQPCC) -> bool:
    """Whether the diagonal exceeds the rounding of the low-rank factor."""
    least = float(problem.diagonal.min())
    return least > ROUNDING * float(problem.hessian.diagonal().max())


class _DenseObjective:
    """H as a matrix."""

    def __init__(self, problem: ContactQPCC, scale: FloatArray, c: FloatArray, size: float) -> None:
        self.c = c
        nu = problem.control_count
        hessian = problem.hessian * scale
        hessian *= (scale / size)[:, None]
        self._hessian = hessian
        self._count = nu
        # The gradient in the forces.
        self.outputs = np.concatenate([c[nu:, None], hessian[nu:]], axis=1)

    def times(self, z: FloatArray) -> FloatArray:
        product: FloatArray = self._hessian @ z
        return product

    def matrix(self) -> FloatArray:
        return self._hessian

    def reduced(self, elimination: ForceElimination) -> ReducedObjective:
        nu = self._count
        start, forces = elimination.forces[:, 0], elimination.forces[:, 1:]
        slope, slopes = elimination.outputs[:, 0], elimination.outputs[:, 1:]
        hessian = forces.T @ (self._hessian[nu:, :nu] + slopes)
        hessian += hessian.T
        hessian *= 0.5
        hessian += self._hessian[:nu, :nu]
        gradient = self.c[:nu] + start @ self._hessian[nu:, :nu] + slope @ forces
        return ReducedObjective(hessian, gradient, 0.5 * float(start @ (self.c[nu:] + slope)))


class _LowRankObjective:
    """H = diag(d, 0) + N'N."""

    def __init__(self, problem: ContactQPCC, scale: FloatArray, c: FloatArray, size: float) -> None:
        self.c = c
        self._count = problem.control_count
        self._diagonal = problem.diagonal * scale[: self._count] ** 2 / size
        self._factor = problem.squares * (scale / np.sqrt(size))
        self.outputs = np.concatenate([np.zeros((len(self._factor), 1)), self._factor], axis=1)

    def times(self, z: FloatArray) -> FloatArray:
        product: FloatArray = (self._factor @ z) @ self._factor
        product[: self._count] += self._diagonal * z[: self._count]
        return product

    def matrix(self) -> FloatArray:
        whole: FloatArray = self._factor.T @ self._factor
        each = np.arange(self._count)
        whole[each, each] += self._diagonal
        return whole

    def reduced(self, elimination: ForceElimination) -> ReducedObjective:
        nu = self._count
        start, forces = elimination.forces[:, 0], elimination.forces[:, 1:]
        first, factor = elimination.outputs[:, 0], elimination.outputs[:, 1:]
        gradient = self.c[:nu] + self.c[nu:] @ forces + first @ factor
        constant = float(self.c[nu:] @ start) + 0.5 * float(first @ first)
        return ReducedObjective(DiagonalPlusLowRank(self._diagonal, factor), gradient, constant)
