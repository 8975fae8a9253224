"""Proofs that a QP has no point, or falls without end, checked on the problem's own numbers."""

from __future__ import annotations

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.qp.problem import QPMultipliers, QPProblem

CLEAR = 1e-9
"""Share of its own terms by which a sum has to differ from zero."""

ZERO = 1e-11
"""Share of its own terms up to which a sum is rounding of zero."""


def proves_infeasible(problem: QPProblem, multipliers: QPMultipliers) -> bool:
    """Whether weights of the rows add up to an inequality that no point obeys (Farkas).

    With z >= 0 every point has (A'y + G'z)'x >= b'y + h'z. That is impossible if the largest value
    of the left side within the bounds is smaller than the right side. A slope that is more than
    rounding in a direction without bound proves nothing: rows that are parallel but for 1e-7 meet,
    if far away.
    """
    y, z = multipliers.equalities, np.maximum(multipliers.rows, 0.0)
    size = max(float(np.abs(y).max(initial=0.0)), float(z.max(initial=0.0)))
    if not 0.0 < size < np.inf:
        return False
    y, z = y / size, z / size
    slope, terms = combined_rows(problem, y, z)
    least = float(y @ problem.b + z @ problem.h)
    noise = float(np.abs(y) @ np.abs(problem.b) + z @ np.abs(problem.h))
    reach = np.where(slope > 0.0, problem.upper, problem.lower)
    endless = ~np.isfinite(reach)
    if np.any(np.abs(slope[endless]) > ZERO * terms[endless]):
        return False
    reach = np.where(endless, 0.0, reach)
    most = float(slope @ reach)
    noise += float(np.abs(slope) @ np.abs(reach))
    return least - most > CLEAR * noise and least > most


def combined_rows(
    problem: QPProblem, y: FloatArray, z: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """``A'y + G'z`` (n,), and the sum of its terms' sizes (n,)."""
    slope, terms = np.zeros(len(problem.c)), np.zeros(len(problem.c))
    for weights, rows in ((y, problem.A), (z, problem.G)):
        if weights.size:
            slope = slope + weights @ rows
            terms = terms + np.abs(weights) @ abs(rows)
    return slope, terms


def proves_unbounded(problem: QPProblem, ray: FloatArray) -> bool:
    """Whether the objective falls for ever along a direction that leaves no row or bound.

    Curvature, equations and rows may be off by rounding of their own terms only: a curvature of
    1e-12 that is written down is a curvature.
    """
    if not np.all(np.isfinite(ray)) or not np.any(ray):
        return False
    if np.any(ray[np.isfinite(problem.lower)] < 0.0):
        return False
    if np.any(ray[np.isfinite(problem.upper)] > 0.0):
        return False
    long = np.abs(ray)
    if np.any(np.abs(problem.P @ ray) > ZERO * (abs(problem.P) @ long)):
        return False
    if problem.b.size and np.any(np.abs(problem.A @ ray) > ZERO * (abs(problem.A) @ long)):
        return False
    if problem.h.size and np.any(problem.G @ ray < -ZERO * (abs(problem.G) @ long)):
        return False
    return float(problem.c @ ray) < -CLEAR * float(np.abs(problem.c) @ long)
