"""Convex quadratic programs apart from any solver: the problem, a verified answer, polishing.

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
from warp_softbody.controllers.qp.sparse_or_dense import Matrix, to_dense

ACCEPTED_RESIDUAL = 1e-6
"""A problem counts as solved if its recomputed residuals and duality gap are at most this,
whatever the solver says."""

POLISHED_RESIDUAL = 1e-9
"""Largest primal residual of a polished point whose active set was identified correctly."""

EXACT = 1e-10
"""Residuals that polishing would not improve; an active set method mostly reaches them."""

FAR = 1e300
"""Stands for an infinite distance where the product with a zero multiplier must stay zero."""


class QPStatus(Enum):
    """How the solve of one QP ended."""

    SOLVED = "solved"
    INFEASIBLE = "infeasible"
    UNBOUNDED = "unbounded"
    UNSOLVED = "unsolved"


@dataclass(frozen=True, kw_only=True)
class QPProblem:
    """Arrays of one QP; A and b, and G and h, may have no rows; P, A and G may all be sparse.

    ``cutoff`` bounds the objective from above, as in branch and bound, and is measured from the
    unconstrained minimum: where no feasible point is as low, a solver may stop early and answer
    INFEASIBLE.
    """

    P: Matrix
    c: FloatArray
    A: Matrix
    b: FloatArray
    G: Matrix
    h: FloatArray
    lower: FloatArray
    upper: FloatArray
    cutoff: float = math.inf


@dataclass(frozen=True, kw_only=True)
class QPMultipliers:
    """``P x + c = G'rows + A'equalities + lower - upper``; rows, lower and upper are >= 0."""

    rows: FloatArray
    equalities: FloatArray
    lower: FloatArray
    upper: FloatArray


@dataclass(frozen=True, kw_only=True)
class QPSolution:
    """The answer to one QP; multipliers and residuals are meaningful where status is SOLVED.

    Attributes:
        x: the minimiser, exactly inside its bounds.
        value: 1/2 x'Px + c'x.
        status: SOLVED only if the recomputed residuals agree.
        multipliers: of every row and bound.
        primal_residual: largest violation of an inequality or equality row.
        dual_residual: largest entry of the gradient of the Lagrangian.
        iterations: number that the solver took.
        gap: sum of the products of multipliers and slacks: at most so much below ``value`` is the
            minimum, but for the residuals.
    """

    x: FloatArray
    value: float
    status: QPStatus
    multipliers: QPMultipliers
    primal_residual: float
    dual_residual: float
    iterations: int
    gap: float = 0.0


class QPSolver(Protocol):
    """A convex QP solver."""

    def solve(self, problem: QPProblem) -> QPSolution:
        """Solve one QP; SOLVED only where ``verified`` agrees."""


def verified(
    problem: QPProblem,
    point: FloatArray,
    multipliers: QPMultipliers,
    *,
    otherwise: QPStatus,
    iterations: int,
) -> QPSolution:
    """The answer at a point clipped to its bounds, its value and residuals computed anew.

    It is SOLVED only if these residuals are small, and has the status ``otherwise`` if not.
    """
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
        gap=gap,
    )


def polish(problem: QPProblem, solution: QPSolution) -> QPSolution:
    """The same point accurate to rounding, or as it was where its active set is not clear.

    The tolerance of an interior point method bounds the gradient, so that a variable with little
    curvature may be off by a thousandth of its range. One solve of the KKT system with the active
    rows as equalities has no such error. Problems with equalities (redundant contacts) are left
    alone, because that system may be singular.
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
    answer = _solve_kkt(problem, x, free, active)
    if answer is None:
        return solution
    x[free] = answer[: np.count_nonzero(free)]
    rows = np.zeros(len(problem.h))
    rows[active] = np.maximum(answer[np.count_nonzero(free) :], 0.0)
    gradient = problem.P @ x + problem.c - rows @ problem.G
    multipliers = QPMultipliers(
        rows=rows,
        equalities=known.equalities,
        lower=np.maximum(gradient, 0.0) * at_lower,
        upper=np.maximum(-gradient, 0.0) * at_upper,
    )
    polished = verified(
        problem,
        x,
        multipliers,
        otherwise=QPStatus.UNSOLVED,
        iterations=solution.iterations,
    )
    better = polished.dual_residual < solution.dual_residual
    return polished if better and polished.primal_residual <= POLISHED_RESIDUAL else solution


def _solve_kkt(
    problem: QPProblem, fixed: FloatArray, free: BoolArray, active: BoolArray
) -> FloatArray | None:
    """The free variables, then the multipliers of the active rows, by the KKT system."""
    rows = problem.G[active]
    count, size = len(rows), int(np.count_nonzero(free))
    system = np.zeros((size + count, size + count))
    system[:size, :size] = to_dense(problem.P)[np.ix_(free, free)]
    system[size:, :size] = rows[:, free]
    system[:size, size:] = -rows[:, free].T
    gradient = (-problem.c - problem.P @ fixed)[free]
    sides = np.concatenate([gradient, problem.h[active] - rows @ fixed])
    try:
        return np.linalg.solve(system, sides)
    except np.linalg.LinAlgError:
        return None
