"""The chosen pieces of all contacts as block matrices, and the elimination of the forces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warp_softbody.controllers.pieces import PieceTable
from warp_softbody.controllers.qpcc import FloatArray

SINGULAR = 1e-10
"""Reciprocal condition below which forces are not eliminated."""

GROWTH = 1e8
"""Size of scaled forces per unit of control above which they are not eliminated either."""


@dataclass(frozen=True)
class Blocks:
    """Block matrices of the chosen pieces.

    Attributes:
        basis: E, (3K, p): forces are f = E y.
        still: T, (p, 3K): the velocities T w vanish.
        on_force: (r, 3K), and
        on_velocity: (r, 3K): the rows ``on_force f + on_velocity w >= 0``.
    """

    basis: FloatArray
    still: FloatArray
    on_force: FloatArray
    on_velocity: FloatArray


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
    """Put the contacts' own small matrices on the diagonal and drop the padding."""
    k, which = np.arange(len(modes)), np.array(modes, dtype=np.int64)
    size = 3 * len(k)
    used = (np.arange(3) < table.count[k, which][:, None]).reshape(-1)
    basis, still = np.zeros((len(k), 3, len(k), 3)), np.zeros((len(k), 3, len(k), 3))
    basis[k, :, k, :] = table.basis[k, which]
    still[k, :, k, :] = table.still[k, which]
    chosen = table.rows[k, which]
    rows = np.zeros((2, len(k), chosen.shape[1], len(k), 3))
    rows[0, k, :, k, :] = chosen[..., :3]
    rows[1, k, :, k, :] = chosen[..., 3:]
    on_force, on_velocity = rows.reshape(2, len(k) * chosen.shape[1], size)
    kept = table.row_used[k, which].reshape(-1)
    return Blocks(
        basis=basis.reshape(size, size)[:, used],
        still=still.reshape(size, size)[used],
        on_force=on_force[kept],
        on_velocity=on_velocity[kept],
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
    system = blocks.still @ mobility @ blocks.basis
    size = len(system)
    if not well_posed and size and _reciprocal_condition(system) < SINGULAR:
        return None
    sides = np.concatenate([blocks.still @ free, np.eye(size)], axis=1)
    try:
        answer = np.linalg.solve(system, sides)
    except np.linalg.LinAlgError:
        return None
    if np.abs(answer).max(initial=0.0) > GROWTH:
        return None
    split = free.shape[1]
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
