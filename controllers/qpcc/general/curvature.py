"""Second-order conditions on a piece, where the objective is not convex.

The minimiser that the convex-concave steps end in is stationary, which may be a saddle: along a
direction that keeps the active rows the objective may curve down.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.qp.problem import QPProblem, QPSolver, QPStatus, polish
from warp_softbody.controllers.qp.sparse_or_dense import to_dense
from warp_softbody.controllers.qpcc.general.piece_solution import PieceSolution

CURVED = 1e-9
"""Negative curvature, relative to the largest coefficient of Q, below which it is rounding."""

ON = 1e-8
"""Scaled distance from a row or bound up to which the point is on it."""

PULLED = 1e-7
"""Multipliers above this hold the point on their row: no descent leads off it at first order."""


NO_RAY = 1e-3
"""Size of a way's part within the cone of rays, over its own, that is none."""

FAR_OFF = 1e4
"""Scaled distance of a point that seems to be on its way to infinity."""


@dataclass(frozen=True)
class CurvatureFinding:
    """What the second derivative says at a point.

    Attributes:
        step: (n,) to a lower point of the piece, None where none was found.
        ray: (n,), along which the objective falls for ever, None where there is none.
        certain: whether no direction curves down that first order leaves open.
    """

    step: FloatArray | None
    ray: FloatArray | None
    certain: bool


def examine_curvature(
    hessian: FloatArray, gradient: FloatArray, program: QPProblem, piece: PieceSolution
) -> CurvatureFinding:
    """Look for a direction of negative curvature from a stationary point of a piece.

    Args:
        hessian: (n, n) of the objective.
        gradient: (n,) of it at the point.
        program: QP of the piece, for its rows and bounds.
        piece: the point and its multipliers.
    """
    known = piece.solution.multipliers
    rows, slack = to_dense(program.G), program.G @ piece.x - program.h
    low, high = piece.x - program.lower <= ON, program.upper - piece.x <= ON
    held = np.concatenate(
        [
            to_dense(program.A),
            rows[(slack <= ON) & (known.rows > PULLED)],
            np.eye(len(gradient))[(low & (known.lower > PULLED)) | (high & (known.upper > PULLED))],
        ]
    )
    space = _null_space(held)
    if not space.shape[1]:
        return CurvatureFinding(None, None, True)
    values, vectors = np.linalg.eigh(space.T @ hessian @ space)
    least = -CURVED * float(np.abs(hessian).max())
    down = values < least
    for vector in (space @ vectors[:, down]).T:
        size = float(np.abs(vector).max())
        clean = np.where(np.abs(vector) > 1e-12 * size, vector / size, 0.0)
        for way in (clean, -clean):
            length = _longest(program, piece.x, way, rows, slack)
            slope, curve = float(gradient @ way), float(way @ hessian @ way)
            if length == np.inf:
                return CurvatureFinding(None, way, False)
            if length > ON and length * slope + 0.5 * length**2 * curve < -1e-12:
                return CurvatureFinding(length * way, None, False)
    return CurvatureFinding(None, None, not down.any())


def drifts(hessian: FloatArray, program: QPProblem, x: FloatArray) -> FloatArray | None:
    """The direction of a point that has drifted far off, if the objective curves down along it."""
    size = float(np.abs(x).max())
    if not FAR_OFF < size < np.inf:
        return None
    way = np.where(np.abs(x) > 1e-9 * size, x / size, 0.0)
    rows = to_dense(program.G)
    slack = np.zeros(len(rows))
    along = to_dense(program.A) @ way
    if np.any(np.abs(along) > 1e-11 * (np.abs(to_dense(program.A)) @ np.abs(way))):
        return None
    if _longest(program, way, way, rows, slack) < np.inf:
        return None
    curve = float(way @ hessian @ way)
    return way if curve < -CURVED * float(np.abs(way) @ np.abs(hessian) @ np.abs(way)) else None


def recession_ray(
    hessian: FloatArray, program: QPProblem, way: FloatArray, solver: QPSolver
) -> FloatArray | None:
    """The ray of a piece that is nearest to a way, if the objective curves down along it."""
    size = float(np.abs(way).max())
    if not 0.0 < size < np.inf:
        return None
    cone = replace(
        program,
        P=np.eye(len(way)),
        c=-way / size,
        A=to_dense(program.A),
        b=np.zeros_like(program.b),
        G=to_dense(program.G),
        h=np.zeros_like(program.h),
        lower=np.where(np.isfinite(program.lower), 0.0, -np.inf),
        upper=np.where(np.isfinite(program.upper), 0.0, np.inf),
    )
    nearest = polish(cone, solver.solve(cone))
    length = float(np.abs(nearest.x).max())
    if nearest.status is not QPStatus.SOLVED or not length > NO_RAY:
        return None
    return drifts(hessian, program, nearest.x * (2.0 * FAR_OFF / length))


def _null_space(rows: FloatArray) -> FloatArray:
    if not len(rows):
        return np.eye(rows.shape[1])
    _, values, vectors = np.linalg.svd(rows)
    rank = int(np.sum(values > 1e-10 * values.max(initial=0.0)))
    space: FloatArray = vectors[rank:].T
    return space


def _longest(
    program: QPProblem, x: FloatArray, way: FloatArray, rows: FloatArray, slack: FloatArray
) -> float:
    """How far a way stays within rows and bounds."""
    longest = np.inf
    falls = rows @ way
    terms = np.abs(rows) @ np.abs(way)
    leaving = falls < -1e-11 * terms
    if leaving.any():
        longest = float((np.maximum(slack[leaving], 0.0) / -falls[leaving]).min())
    for room, rate in ((x - program.lower, -way), (program.upper - x, way)):
        closing = (rate > 0.0) & np.isfinite(room)
        if closing.any():
            longest = min(longest, float((np.maximum(room[closing], 0.0) / rate[closing]).min()))
    return longest
