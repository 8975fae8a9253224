"""The chosen pieces of all contacts as block matrices, and the elimination of the forces.

What depends on the mode of one contact only is computed once a problem and put together for every
choice of modes.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.linalg import lapack

from warp_softbody.arrays import BoolArray, FloatArray
from warp_softbody.controllers.qp.problem import FAR
from warp_softbody.controllers.qpcc.contact.mode_table import PieceTable

SINGULAR = 1e-10
"""Reciprocal condition below which forces are not eliminated."""

GROWTH = 1e8
"""Size of scaled forces per unit of control above which they are not eliminated either."""

CONTRADICTION = 1e-7
"""Scaled velocity of redundant contacts that cannot be held together: spread over a hundred rows
it still misses the default tolerance."""

NOISE = 1e-6
"""Relative size of what rounding in single precision leaves of a zero."""


@dataclass(frozen=True)
class Pieces:
    """The chosen pieces; p is the number of free force amplitudes, which T w = 0 determines.

    Attributes:
        still: (p, 1 + nu + 6K): T times the velocity's affine map, T times Wf, and T.
        spread: (p, 9K + m): what an amplitude adds to ``ContactMaps.base``.
        rows: (K, r, 6): ``rows (f, w) >= 0``, padded.
        kept: (K r,), which of the padded rows are rows.
    """

    still: FloatArray
    spread: FloatArray
    rows: FloatArray
    kept: BoolArray

    @property
    def basis(self) -> FloatArray:
        """E transposed, (p, 3K): forces are f = E y."""
        return self.spread[:, : 3 * len(self.rows)]

    def test(self, both: FloatArray) -> FloatArray:
        """The rows, (r, c), as affine maps of the force and velocity of every contact, (6K, c)."""
        count, width = len(self.rows), both.shape[1]
        tested: FloatArray = (self.rows @ both.reshape(count, 6, width)).reshape(-1, width)
        return tested[self.kept]

    def press(self, multipliers: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The rows' multipliers, (r,), on forces and on velocities, (3K,) each."""
        padded = np.zeros(len(self.kept))
        padded[self.kept] = multipliers
        count, width = self.rows.shape[:2]
        both = (padded.reshape(count, 1, width) @ self.rows).reshape(count, 6)
        return both[:, :3].reshape(-1), both[:, 3:].reshape(-1)


class ContactMaps:
    """Affine maps of one problem, whose columns are the constant, then the controls.

    Attributes:
        base: (9K + m, 1 + nu), where all forces are zero: the forces, 3K rows; force and velocity
            contact by contact, six rows each; the outputs, m rows.
    """

    def __init__(
        self, table: PieceTable, free: FloatArray, mobility: FloatArray, outputs: FloatArray
    ) -> None:
        """Take w = free (1, u) + mobility f and any other map, outputs (1, u, f)."""
        count, width = len(free), free.shape[1]
        self._table = table
        self._moved = np.concatenate([free, mobility, _constants(count)[:, :count]], axis=1)
        self.base = np.zeros((3 * count + len(outputs), width))
        by_contact = self.base[count : 3 * count].reshape(count // 3, 6, width)
        by_contact[:, 3:] = free.reshape(count // 3, 3, width)
        self.base[3 * count :] = outputs[:, :width]
        self._response = np.concatenate([_constants(count), outputs[:, width:].T], axis=1)
        by_contact = self._response[:, count : 3 * count].reshape(count, count // 3, 6)
        by_contact[:, :, 3:] = mobility.T.reshape(count, count // 3, 3)
        self._known: dict[tuple[int, int], FloatArray] = {}

    def gather(self, modes: tuple[int, ...]) -> Pieces:
        """Put the contacts' own matrices together."""
        if not modes:
            return Pieces(self._moved, self._response, self._table.rows[:, 0], np.zeros(0, bool))
        self._learn([pair for pair in enumerate(modes) if pair not in self._known])
        parts = np.concatenate([self._known[pair] for pair in enumerate(modes)])
        each, chosen, width = np.arange(len(modes)), np.array(modes), self._moved.shape[1]
        return Pieces(
            still=parts[:, :width],
            spread=parts[:, width:],
            rows=self._table.rows[each, chosen],
            kept=self._table.row_used[each, chosen].reshape(-1),
        )

    def _learn(self, pairs: list[tuple[int, int]]) -> None:
        """Rows of ``still`` and ``spread``, side by side, of contacts in modes not seen before."""
        if not pairs:
            return
        contact, mode = np.array(pairs).T
        width = self._moved.shape[1]
        found = np.empty((len(pairs), 3, width + self._response.shape[1]))
        by_contact = self._moved.reshape(-1, 3, width)
        np.matmul(self._table.still[contact, mode], by_contact[contact], out=found[:, :, :width])
        bases = self._table.basis[contact, mode].transpose(0, 2, 1)
        by_contact = self._response.reshape(len(by_contact), 3, -1)
        np.matmul(bases, by_contact[contact], out=found[:, :, width:])
        counts = self._table.count[contact, mode].tolist()
        for pair, own, count in zip(pairs, found, counts, strict=True):
            self._known[pair] = own[:count]


@lru_cache(maxsize=64)
def _constants(count: int) -> FloatArray:
    """(3K, 9K): each force, and again among (f, w) contact by contact."""
    both = np.zeros((count, count // 3, 6))
    both[np.arange(count), np.arange(count) // 3, np.arange(count) % 3] = 1.0
    return np.concatenate([np.eye(count), both.reshape(count, 2 * count)], axis=1)


@dataclass(frozen=True)
class Elimination:
    """The maps of ``ContactMaps`` with the forces eliminated, and the factors of T Wf E.

    ``count`` is 3K.
    """

    maps: FloatArray
    factors: FloatArray
    pivots: FloatArray
    count: int

    @property
    def affine(self) -> FloatArray:
        """(3K, 1 + nu): forces, constant first, then per control."""
        return self.maps[: self.count]

    @property
    def both(self) -> FloatArray:
        """(6K, 1 + nu): force and velocity, contact by contact."""
        return self.maps[self.count : 3 * self.count]

    @property
    def outputs(self) -> FloatArray:
        """(m, 1 + nu)."""
        return self.maps[3 * self.count :]

    def held(self, slopes: FloatArray) -> FloatArray:
        """(p,) multipliers of T w = 0 from slopes (p,) in the amplitudes."""
        if not len(slopes):
            return slopes
        solved: FloatArray = lapack.dgetrs(self.factors, self.pivots, slopes, trans=1)[0]
        return solved


def eliminate(pieces: Pieces, maps: ContactMaps, well_posed: bool) -> Elimination | None:
    """Solve T Wf E y = -T (w0 + Wu u) for all u at once; None where T Wf E is singular.

    Args:
        pieces: the chosen pieces.
        maps: of the problem.
        well_posed: Wf is definite, so that only sliding can make the system singular, which
            shows in the size of its inverse; else its condition counts.
    """
    width, count = maps.base.shape[1], 3 * len(pieces.rows)
    system = pieces.still[:, width : width + count] @ pieces.basis.T
    if not len(system):
        return Elimination(maps.base, system, np.zeros(0), count)
    factors, pivots, singular = lapack.dgetrf(system)
    if singular:
        return None
    norm = float(np.abs(system).sum(axis=0).max())
    condition, _ = lapack.dgecon(factors, norm)
    if condition * norm * GROWTH < 1.0 or (not well_posed and condition < SINGULAR):
        return None
    answer = np.asarray(lapack.dgetrs(factors, pivots, pieces.still[:, :width])[0], np.float64)
    if np.abs(answer).max() > GROWTH:
        return None
    return Elimination(maps.base - pieces.spread.T @ answer, factors, pivots, count)


def contradicts(pieces: Pieces, size: int, lower: FloatArray, upper: FloatArray) -> bool:
    """Whether redundant contacts ask of T w = 0 what no controls within the bounds give.

    Args:
        pieces: the chosen pieces, whose T Wf E is singular.
        size: 3K.
        lower: (nu,).
        upper: (nu,).
    """
    width = len(lower) + 1
    vectors, values, _ = np.linalg.svd(pieces.still[:, width : width + size] @ pieces.basis.T)
    moved = pieces.still[:, :width]
    # Forces cannot change these combinations of velocities; controls only above rounding.
    rest = vectors[:, values < SINGULAR * values[:1]].T @ moved
    pull = np.where(np.abs(rest) < NOISE * np.abs(moved).max(), 0.0, np.abs(rest))[:, 1:]
    reach = pull @ np.minimum(np.maximum(np.abs(lower), np.abs(upper)), FAR)
    return bool((np.abs(rest[:, 0]) > reach + CONTRADICTION).any())


def definite(matrix: FloatArray) -> bool:
    """Whether the symmetric part has no eigenvalue below 1e-8 of the mean one."""
    size = len(matrix)
    shift = 1e-8 * float(matrix.trace()) / max(size, 1)
    shifted = 0.5 * (matrix + matrix.T)
    shifted.reshape(-1)[:: size + 1] -= shift
    return size == 0 or lapack.dpotrf(shifted)[1] == 0
