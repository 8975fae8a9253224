"""Convex QPs with rows and bounds, apart from any solver: problem, checked answer, polishing.

    minimise 1/2 x'Px + c'x   subject to   A x = b,  G x >= h,  lower <= x <= upper

Infinite bounds are infinite; solvers return noise for "infinity" written as 1e9.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from typing import Protocol

import numpy as np

from warp_softbody.arrays import BoolArray, FloatArray
from warp_softbody.controllers.qp.sparse_or_dense import Matrix, dense

ACCEPTED_RESIDUAL = 1e-6
"""Recomputed residuals and gap below this mean solved, whatever a solver says; above it, never."""

POLISHED_RESIDUAL = 1e-9
"""A polished point that misses a row by more has guessed its active set wrongly."""

EXACT = 1e-10
"""Residuals that polishing would not improve: what an active set method leaves, mostly."""

FAR = 1e300
"""Stands for an infinite distance where the product with a zero multiplier must stay zero."""


class QPStatus(Enum):
    """What one QP solve ended with."""

    SOLVED = "solved"
    INFEASIBLE = "infeasible"
    UNBOUNDED = "unbounded"
    UNSOLVED = "unsolved"


@dataclass(frozen=True, kw_only=True)
class QPProblem:
    """Arrays of one QP; A and b, and G and h, may have no rows; P, A and G may all be sparse.

    Where every value lies more than ``headroom`` above the least one without rows and bounds, a
    backend may end early and say INFEASIBLE.
    """

    P: Matrix
    c: FloatArray
    A: Matrix
    b: FloatArray
    G: Matrix
    h: FloatArray
    lower: FloatArray
    upper: FloatArray
    headroom: float = math.inf


@dataclass(frozen=True, kw_only=True)
class QPMultipliers:
    """``P x + c = G'rows + A'equalities + lower - upper``; rows, lower and upper are >= 0."""

    rows: FloatArray
    equalities: FloatArray
    lower: FloatArray
    upper: FloatArray


@dataclass(frozen=True, kw_only=True)
class QPSolution:
    """One answer; multipliers and residuals are meaningful where status is SOLVED.

    Attributes:
        x: the minimiser, inside its bounds exactly.
        value: 1/2 x'Px + c'x.
        status: SOLVED only if the recomputed residuals agree.
        multipliers: of every row and bound.
        primal_residual: largest violation of a row or an equation.
        dual_residual: largest entry of the gradient of the Lagrangian.
        iterations: of the solver.
    """

    x: FloatArray
    value: float
    status: QPStatus
    multipliers: QPMultipliers
    primal_residual: float
    dual_residual: float
    iterations: int


class Backend(Protocol):
    """A convex QP solver."""

    def solve(self, problem: QPProblem) -> QPSolution:
        """Solve one QP; SOLVED only where ``checked`` agrees."""


def checked(
    problem: QPProblem,
    point: FloatArray,
    multipliers: QPMultipliers,
    *,
    otherwise: QPStatus,
    iterations: int,
) -> QPSolution:
    """Clip to the bounds, compute value and residuals anew; SOLVED only if they agree."""
    x = np.minimum(np.maximum(point, problem.lower), problem.upper)
    slope = problem.P @ x
    gradient = slope + problem.c
    value = 0.5 * float(x @ (slope + 2.0 * problem.c))
    gradient -= multipliers.lower
    gradient += multipliers.upper
    gap = float(multipliers.lower @ np.minimum(x - problem.lower, FAR))
    gap += float(multipliers.upper @ np.minimum(problem.upper - x, FAR))
    primal = 0.0
    if problem.h.size:
        gradient -= multipliers.rows @ problem.G
        slack = problem.G @ x
        slack -= problem.h
        primal = max(0.0, -float(slack.min()))
        gap += float(multipliers.rows @ slack)
    if problem.b.size:
        gradient -= multipliers.equalities @ problem.A
        primal = max(primal, float(np.abs(problem.A @ x - problem.b).max()))
    dual = max(float(gradient.max()), -float(gradient.min()))
    # nan compares false, so a point that is not finite is never accepted.
    accepted = max(primal, dual, abs(gap) / (1.0 + abs(value))) <= ACCEPTED_RESIDUAL
    return QPSolution(
        x=x,
        value=value,
        status=QPStatus.SOLVED if accepted else otherwise,
        multipliers=multipliers,
        primal_residual=primal,
        dual_residual=dual,
        iterations=iterations,
    )


def polish(problem: QPProblem, solution: QPSolution) -> QPSolution:
    """The same point to rounding where its active set can be read off, else the point as it was.

    Interior point tolerances bound the gradient, so that a variable with little curvature may be
    off by a thousandth of its range; one linear solve with the active rows as equations is not.
    Problems with equations (redundant contacts) are left alone: that system may be singular.
    """
    before = max(solution.dual_residual, solution.primal_residual)
    if problem.b.size or before <= EXACT:
        return solution
    known = solution.multipliers
    at_lower = solution.x - problem.lower < known.lower
    at_upper = problem.upper - solution.x < known.upper
    active = problem.G @ solution.x - problem.h < known.rows
    free = ~(at_lower | at_upper)
    x = np.where(at_lower, problem.lower, np.where(at_upper, problem.upper, 0.0))
    answer = _equality_solve(problem, x, free, active)
    if answer is None:
        return solution
    x[free] = answer[: np.count_nonzero(free)]
    rows = np.zeros(len(problem.h))
    rows[active] = np.maximum(answer[np.count_nonzero(free) :], 0.0)
    push = problem.P @ x + problem.c - rows @ problem.G
    multipliers = QPMultipliers(
        rows=rows,
        equalities=known.equalities,
        lower=np.maximum(push, 0.0) * at_lower,
        upper=np.maximum(-push, 0.0) * at_upper,
    )
    polished = checked(
        problem,
        x,
        multipliers,
        otherwise=QPStatus.UNSOLVED,
        iterations=solution.iterations,
    )
    better = polished.dual_residual < solution.dual_residual
    return polished if better and polished.primal_residual <= POLISHED_RESIDUAL else solution


def _equality_solve(
    problem: QPProblem, fixed: FloatArray, free: BoolArray, active: BoolArray
) -> FloatArray | None:
    """Free variables, then multipliers of the active rows, for ``fixed`` values of the others."""
    rows = problem.G[active]
    count, size = len(rows), int(np.count_nonzero(free))
    system = np.zeros((size + count, size + count))
    system[:size, :size] = dense(problem.P)[np.ix_(free, free)]
    system[size:, :size] = rows[:, free]
    system[:size, size:] = -rows[:, free].T
    gradient = (-problem.c - problem.P @ fixed)[free]
    sides = np.concatenate([gradient, problem.h[active] - rows @ fixed])
    try:
        return np.linalg.solve(system, sides)
    except np.linalg.LinAlgError:
        return None
