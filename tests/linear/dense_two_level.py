"""The two-level preconditioner as matrices, for tests."""

from __future__ import annotations

from typing import Any

import numpy as np

from tests.support.bodies import Rig, box
from warp_softbody.arrays import FloatArray
from warp_softbody.linear.system import CoarseLevel

MESH = box((3, 3, 4), (0.3, 0.3, 0.4), jitter=0.2)
TWO_LEVEL: dict[str, Any] = {"preconditioner": "two_level"}


def level_of(body: Rig) -> CoarseLevel:
    level = body.model.system.coarse
    assert level is not None
    return level


def rigid_motions(body: Rig) -> FloatArray:
    """Columns of P at rest, (3n, 6 aggregates)."""
    aggregation = level_of(body).aggregation
    n = body.model.node_count
    motions = np.zeros((n, 3, aggregation.count, 6))
    for node in range(n):
        owner = aggregation.aggregate_of[node]
        if owner >= 0:
            motions[node, :, owner, :3] = np.eye(3)
            motions[node, :, owner, 3:] = np.cross(np.eye(3), aggregation.offsets[node]).T
    return motions.reshape(3 * n, -1)


def dense_two_level(
    body: Rig, matrix: FloatArray, resisted: Any = 0.0, free: Any = None
) -> FloatArray:
    """Forward sweep from zero, coarse correction, backward sweep, as matrices.

    ``resisted`` is added to the coarse matrix, ``free`` projects onto the velocities left free.
    """
    n = body.model.node_count
    nodes = np.arange(3 * n) // 3
    lower = np.where(nodes[:, None] >= nodes[None], matrix, 0.0)
    turns = np.zeros((n, 3, n, 3))
    turns[np.arange(n), :, np.arange(n), :] = body.stepper.assembly.node_rotations.numpy()
    motions = turns.reshape(3 * n, 3 * n) @ rigid_motions(body)
    if free is not None:
        motions = free @ motions
    level = level_of(body)
    coarse = level.aggregation
    rest = np.zeros((2 * coarse.count, 3, 2 * coarse.count, 3))
    rows = np.repeat(np.arange(2 * coarse.count), np.diff(coarse.pattern.row_start))
    rest[rows, :, coarse.pattern.column, :] = level.values
    own = np.arange(2 * coarse.count)
    traces = np.einsum("iaia->i", rest)[:, None] / 3.0
    rounding = body.model.system.pivot_margin
    for axis in range(3):
        rest[own, axis, own, axis] += rounding * traces[:, 0]
    identity = np.eye(3 * n)
    z = np.linalg.inv(lower)
    inverse = np.linalg.inv(rest.reshape(6 * coarse.count, -1) + resisted)
    correction = motions @ inverse @ motions.T
    z = z + correction @ (identity - matrix @ z)
    return np.asarray(z + np.linalg.inv(lower.T) @ (identity - matrix @ z))
