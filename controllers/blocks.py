"""The chosen pieces of all contacts as block matrices, and the elimination of the forces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warp_softbody.controllers.pieces import BoolArray, PieceTable
from warp_softbody.controllers.qpcc import FloatArray

SINGULAR = 1e-10
"""Reciprocal condition below which forces are not eliminated."""

GROWTH = 1e8
"""Size of scaled forces per unit of control above which they are not eliminated either."""


@dataclass(frozen=True)
class Blocks:
    """The chosen pieces as small matrices per contact, padded; products leave the padding out.

    Attributes:
        basis: E, (3K, p): forces are f = E y.
        still: (K, 3, 3): velocities T w vanish.
        rows: (K, r, 6): ``rows (f, w) >= 0``.
        used: (3K,), which of the padded rows of ``still`` are rows.
        kept: (K r,), which of the padded rows of ``rows`` are.
    """

    basis: FloatArray
    still: FloatArray
    rows: FloatArray
    used: BoolArray
    kept: BoolArray

    def hold(self, matrix: FloatArray) -> FloatArray:
        """T times (3K, c): (p, c)."""
        k, width = len(self.still), matrix.shape[1]
        held: FloatArray = (self.still @ matrix.reshape(k, 3, width)).reshape(3 * k, width)
        return held[self.used]

    def pull(self, multipliers: FloatArray) -> FloatArray:
        """T' times (p,): (3K,)."""
        padded = np.zeros(len(self.used))
        padded[self.used] = multipliers
        back = padded.reshape(-1, 1, 3) @ self.still
        return back.reshape(-1)

    def test(self, force: FloatArray, velocity: FloatArray) -> FloatArray:
        """The rows as affine maps, (r, c), of force and velocity, (3K, c)."""
        k, width = len(self.still), force.shape[1]
        both = np.concatenate([force.reshape(k, 3, width), velocity.reshape(k, 3, width)], axis=1)
        tested: FloatArray = (self.rows @ both).reshape(len(self.kept), width)
        return tested[self.kept]

    def press(self, multipliers: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The rows' multipliers, (r,), on forces and on velocities, (3K,) each."""
        padded = np.zeros(len(self.kept))
        padded[self.kept] = multipliers
        k = len(self.still)
        both = (padded.reshape(k, 1, self.rows.shape[1]) @ self.rows).reshape(k, 6)
        return both[:, :3].reshape(-1), both[:, 3:].reshape(-1)


@dataclass(frozen=True)
class AffineForces:
    """Forces as (3K, nu + 1), constant first, then per control; and the inverse of T Wf E."""

    affine: FloatArray
    inverse: FloatArray

    def at(self, controls: FloatArray) -> FloatArray:
        """(3K,) forces at these controls."""
        force: FloatArray = self.affine[:, 0] + self.affine[:, 1:] @ controls
        return force


def gather(table: PieceTable, modes: tuple[int, ...]) -> Blocks:
    """Pick the contacts' own small matrices and drop the padding of the forces."""
    k, which = np.arange(len(modes)), np.array(modes, dtype=np.int64)
    used = (np.arange(3) < table.count[k, which][:, None]).reshape(-1)
    basis = np.zeros((len(k), 3, len(k), 3))
    basis[k, :, k, :] = table.basis[k, which]
    return Blocks(
        basis=basis.reshape(3 * len(k), 3 * len(k))[:, used],
        still=table.still[k, which],
        rows=table.rows[k, which],
        used=used,
        kept=table.row_used[k, which].reshape(-1),
    )


def eliminate(
    blocks: Blocks, free: FloatArray, mobility: FloatArray, well_posed: bool
) -> AffineForces | None:
    """Solve T Wf E y = -T (w0 + Wu u) for all u at once; None where T Wf E is singular.

    Args:
        blocks: the chosen pieces.
        free: (3K, nu + 1), w0 then Wu.
        mobility: Wf.
        well_posed: Wf is definite, so that only sliding can make the system singular, which
            shows in the size of its inverse; else its condition is computed.
    """
    system = blocks.hold(mobility) @ blocks.basis
    size = len(system)
    if not well_posed and size and _reciprocal_condition(system) < SINGULAR:
        return None
    split = free.shape[1]
    sides = np.zeros((size, split + size))
    sides[:, :split] = blocks.hold(free)
    sides.reshape(-1)[split :: split + size + 1] = 1.0
    try:
        answer = np.asarray(np.linalg.solve(system, sides), np.float64)
    except np.linalg.LinAlgError:
        return None
    if np.abs(answer).max(initial=0.0) > GROWTH:
        return None
    return AffineForces(blocks.basis @ -answer[:, :split], answer[:, split:])


def definite(matrix: FloatArray) -> bool:
    """Whether the symmetric part has no eigenvalue below 1e-8 of the mean one."""
    size = len(matrix)
    shift = 1e-8 * float(matrix.trace()) / max(size, 1)
    try:
        np.linalg.cholesky(0.5 * (matrix + matrix.T) - shift * np.eye(size))
    except np.linalg.LinAlgError:
        return False
    return True


def _reciprocal_condition(matrix: FloatArray) -> float:
    values = np.linalg.svd(matrix, compute_uv=False)
    return float(values[-1] / values[0]) if values[0] > 0.0 else 0.0
