"""The elimination of the contact forces for one choice of contact modes.

With a mode for every contact the forces are ``f = E y`` with amplitudes y, and the velocities obey
``T w = 0``: the square system ``(T Wf E) y = -T (w0 + Wu u)`` makes the forces affine in the
controls. Blocks that depend on the mode of one contact only are computed once a problem and put
together for every choice of modes.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.linalg import lapack

from warp_softbody.arrays import BoolArray, FloatArray
from warp_softbody.controllers.qp.problem import FAR
from warp_softbody.controllers.qpcc.contact.mode_table import ModeTable

SINGULAR = 1e-10
"""Reciprocal condition number of T Wf E below which the forces are not eliminated."""

GROWTH = 1e8
"""Scaled force per unit of control above which the forces are not eliminated either."""

INCONSISTENT = 1e-7
"""Scaled velocity by which redundant contacts disagree that makes them inconsistent: spread over a
hundred rows it still misses the default tolerance."""

NOISE = 1e-6
"""Relative size of a zero after rounding in single precision."""


@dataclass(frozen=True)
class ModeSystem:
    """The conditions of one choice of modes, with p force amplitudes.

    Attributes:
        velocity_constraints: (p, 1 + nu + 6K), side by side T times the affine map of the velocity
            without forces, T times Wf, and T.
        force_response: (p, 9K + m), what a unit of each amplitude adds to ``ContactMaps.base``.
        inequalities: (K, r, 6), rows on (f, w) of every contact, >= 0, padded.
        inequality_used: (K r,), false for the padding.
    """

    velocity_constraints: FloatArray
    force_response: FloatArray
    inequalities: FloatArray
    inequality_used: BoolArray

    @property
    def force_basis(self) -> FloatArray:
        """E transposed, (p, 3K): the forces are f = E y."""
        return self.force_response[:, : 3 * len(self.inequalities)]

    def inequality_map(self, points: FloatArray) -> FloatArray:
        """The inequalities (r, c) as affine maps, from those of every contact's (f, w), (6K, c)."""
        count, width = len(self.inequalities), points.shape[1]
        blocks = self.inequalities @ points.reshape(count, 6, width)
        rows: FloatArray = blocks.reshape(-1, width)
        return rows[self.inequality_used]

    def inequality_multipliers(self, multipliers: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Multipliers (r,) of the inequalities as those of forces and velocities, (3K,) each."""
        padded = np.zeros(len(self.inequality_used))
        padded[self.inequality_used] = multipliers
        count, width = self.inequalities.shape[:2]
        points = (padded.reshape(count, 1, width) @ self.inequalities).reshape(count, 6)
        return points[:, :3].reshape(-1), points[:, 3:].reshape(-1)


class ContactMaps:
    """The affine maps of one problem, from which ``ModeSystem`` are put together.

    The columns of an affine map are the constant, then one for each control.

    Attributes:
        base: (9K + m, 1 + nu), at zero force: the forces, 3K rows; force and velocity contact by
            contact, six rows each; the outputs, m rows.
    """

    def __init__(
        self, table: ModeTable, free: FloatArray, delassus: FloatArray, outputs: FloatArray
    ) -> None:
        """Take w = free (1, u) + delassus f, and further maps, outputs (1, u, f)."""
        count, width = len(free), free.shape[1]
        self._table = table
        self._velocity = np.concatenate([free, delassus, _constants(count)[:, :count]], axis=1)
        self.base = np.zeros((3 * count + len(outputs), width))
        by_contact = self.base[count : 3 * count].reshape(count // 3, 6, width)
        by_contact[:, 3:] = free.reshape(count // 3, 3, width)
        self.base[3 * count :] = outputs[:, :width]
        self._by_force = np.concatenate([_constants(count), outputs[:, width:].T], axis=1)
        by_contact = self._by_force[:, count : 3 * count].reshape(count, count // 3, 6)
        by_contact[:, :, 3:] = delassus.T.reshape(count, count // 3, 3)
        self._blocks: dict[tuple[int, int], FloatArray] = {}

    def system(self, modes: tuple[int, ...]) -> ModeSystem:
        """The conditions of one mode for every contact."""
        if not modes:
            return ModeSystem(
                self._velocity, self._by_force, self._table.inequalities[:, 0], np.zeros(0, bool)
            )
        self._add_blocks([pair for pair in enumerate(modes) if pair not in self._blocks])
        parts = np.concatenate([self._blocks[pair] for pair in enumerate(modes)])
        each, chosen, width = np.arange(len(modes)), np.array(modes), self._velocity.shape[1]
        return ModeSystem(
            velocity_constraints=parts[:, :width],
            force_response=parts[:, width:],
            inequalities=self._table.inequalities[each, chosen],
            inequality_used=self._table.inequality_used[each, chosen].reshape(-1),
        )

    def _add_blocks(self, pairs: list[tuple[int, int]]) -> None:
        """Compute velocity constraints and force response, side by side, of (contact, mode)."""
        if not pairs:
            return
        contact, mode = np.array(pairs).T
        width = self._velocity.shape[1]
        found = np.empty((len(pairs), 3, width + self._by_force.shape[1]))
        by_contact = self._velocity.reshape(-1, 3, width)
        np.matmul(
            self._table.velocity_constraints[contact, mode],
            by_contact[contact],
            out=found[:, :, :width],
        )
        bases = self._table.force_basis[contact, mode].transpose(0, 2, 1)
        by_contact = self._by_force.reshape(len(by_contact), 3, -1)
        np.matmul(bases, by_contact[contact], out=found[:, :, width:])
        counts = self._table.force_dimensions[contact, mode].tolist()
        for pair, own, count in zip(pairs, found, counts, strict=True):
            self._blocks[pair] = own[:count]


@lru_cache(maxsize=64)
def _constants(count: int) -> FloatArray:
    """(3K, 9K): the forces, and again among (f, w) contact by contact."""
    points = np.zeros((count, count // 3, 6))
    points[np.arange(count), np.arange(count) // 3, np.arange(count) % 3] = 1.0
    return np.concatenate([np.eye(count), points.reshape(count, 2 * count)], axis=1)


@dataclass(frozen=True)
class ForceElimination:
    """The affine maps with the forces eliminated, and the LU factors of T Wf E.

    Attributes:
        maps: (9K + m, 1 + nu), rows as in ``ContactMaps.base``.
        factors: (p, p), L and U.
        pivots: (p,), row interchanges.
        count: 3K.
    """

    maps: FloatArray
    factors: FloatArray
    pivots: FloatArray
    count: int

    @property
    def forces(self) -> FloatArray:
        """(3K, 1 + nu), of the forces."""
        return self.maps[: self.count]

    @property
    def points(self) -> FloatArray:
        """(6K, 1 + nu), of force and velocity contact by contact."""
        return self.maps[self.count : 3 * self.count]

    @property
    def outputs(self) -> FloatArray:
        """(m, 1 + nu), of the outputs."""
        return self.maps[3 * self.count :]

    def constraint_multipliers(self, slopes: FloatArray) -> FloatArray:
        """Multipliers (p,) of T w = 0, from derivatives (p,) of the objective in the amplitudes.

        By the transposed system.
        """
        if not len(slopes):
            return slopes
        solved: FloatArray = lapack.dgetrs(self.factors, self.pivots, slopes, trans=1)[0]
        return solved


def eliminate(system: ModeSystem, maps: ContactMaps, definite: bool) -> ForceElimination | None:
    """Solve T Wf E y = -T (w0 + Wu u) for all u at once; None where T Wf E is singular.

    Args:
        system: of the chosen modes.
        maps: of the problem.
        definite: whether Wf is positive definite, so that only sliding can make the system
            singular, which shows in the size of its inverse; else its condition counts.
    """
    width, count = maps.base.shape[1], 3 * len(system.inequalities)
    matrix = system.velocity_constraints[:, width : width + count] @ system.force_basis.T
    if not len(matrix):
        return ForceElimination(maps.base, matrix, np.zeros(0), count)
    factors, pivots, singular = lapack.dgetrf(matrix)
    if singular:
        return None
    norm = float(np.abs(matrix).sum(axis=0).max())
    condition, _ = lapack.dgecon(factors, norm)
    if condition * norm * GROWTH < 1.0 or (not definite and condition < SINGULAR):
        return None
    rows = system.velocity_constraints[:, :width]
    amplitudes = np.asarray(lapack.dgetrs(factors, pivots, rows)[0], np.float64)
    if np.abs(amplitudes).max() > GROWTH:
        return None
    return ForceElimination(
        maps.base - system.force_response.T @ amplitudes, factors, pivots, count
    )


def is_inconsistent(system: ModeSystem, size: int, lower: FloatArray, upper: FloatArray) -> bool:
    """Whether redundant contacts ask of T w = 0 what no controls within the bounds give.

    Args:
        system: of modes whose T Wf E is singular.
        size: 3K.
        lower: (nu,).
        upper: (nu,).
    """
    width = len(lower) + 1
    constraints = system.velocity_constraints
    vectors, values, _ = np.linalg.svd(constraints[:, width : width + size] @ system.force_basis.T)
    without_force = constraints[:, :width]
    # Forces cannot change these combinations of velocities; controls only above rounding.
    rest = vectors[:, values < SINGULAR * values[:1]].T @ without_force
    negligible = np.abs(rest) < NOISE * np.abs(without_force).max()
    by_controls = np.where(negligible, 0.0, np.abs(rest))[:, 1:]
    reach = by_controls @ np.minimum(np.maximum(np.abs(lower), np.abs(upper)), FAR)
    return bool((np.abs(rest[:, 0]) > reach + INCONSISTENT).any())


def is_definite(matrix: FloatArray) -> bool:
    """Whether the symmetric part has no eigenvalue below 1e-8 of the mean one."""
    size = len(matrix)
    shift = 1e-8 * float(matrix.trace()) / max(size, 1)
    shifted = 0.5 * (matrix + matrix.T)
    shifted.reshape(-1)[:: size + 1] -= shift
    return size == 0 or lapack.dpotrf(shifted)[1] == 0
