"""A QP solver whose verdicts are proved: points by residuals, the rest by certificates.

PIQP answers nearly all QPs. Where its answer does not hold when it is computed anew, the linear
programs of HiGHS tell whether there is a point or a falling ray, and the proximal point method by
DAQP finds the minimiser. What nobody can prove is UNSOLVED.
"""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.qp.certificates import proves_infeasible, proves_unbounded
from warp_softbody.controllers.qp.daqp import DAQPSolver
from warp_softbody.controllers.qp.linear_program import LPSolution, least_violation, solve_lp
from warp_softbody.controllers.qp.piqp import PIQPSolver
from warp_softbody.controllers.qp.problem import (
    QPMultipliers,
    QPProblem,
    QPSolution,
    QPStatus,
    verified,
)
from warp_softbody.controllers.qp.sparse_or_dense import is_sparse, stack_rows, to_dense

PROOF = 1e-6
"""PIQP's tolerance where it calls a QP infeasible: its weights then nearly are a proof."""

NO_MISS = 1e-8
"""Sum of all rows' misses up to which a point obeys them."""

SMALL_SLOPE = 1e-5
"""A gradient's entry below this may be larger than a residual that counts as solved."""

FIRST_WEIGHT = 1e-6
"""Scaled weight of the first proximal term."""

ACCURATE = 1e-10
"""Dual residual at which the proximal point method ends."""

GAP = 1e-2
"""Tolerance of the duality gap over that of residuals: the accuracy of values."""

PROXIMAL_STEPS = 60
"""Most steps of the proximal point method."""

NEGLIGIBLE = (1e-5, 1e-3)
"""Shares of the largest weight below which those of an interior point method are taken for zero."""

BALANCINGS = 3
"""Corrections of weights: each may open slopes of variables that are bounded on one side."""

LARGEST = 400
"""Variables above which dense second opinions would take too long."""


class CertifiedSolver:
    """A QP solver by PIQP whose INFEASIBLE and UNBOUNDED are certified; ``deadline`` ends doubt."""

    def __init__(self, tolerance: float = 1e-9, *, thorough: bool = True) -> None:
        """Choose the tolerance of residuals and duality gap of the first attempt.

        Without ``thorough`` nobody but PIQP is asked: what it cannot prove is UNSOLVED.
        """
        self._thorough = thorough
        settings = {
            "preconditioner_iter": 10,
            "eps_primal_inf": PROOF,
            "eps_duality_gap_abs": GAP * tolerance,
        }
        self._first = PIQPSolver(tolerance=tolerance, settings=settings)
        self._second = PIQPSolver(tolerance=1e-12, settings=settings | {"max_iter": 200})
        self.deadline = np.inf
        """Time on ``time.perf_counter`` after which no further opinion is asked."""

    def solve(self, problem: QPProblem) -> QPSolution:
        """Solve one QP from scratch."""
        solution = self._first.solve(problem)
        if holds(problem, solution):
            return solution
        if solution.status is QPStatus.INFEASIBLE and _proved(problem, solution.multipliers):
            return solution
        if time.perf_counter() >= self.deadline:
            return replace(solution, status=QPStatus.UNSOLVED)
        second = self._second.solve(problem)
        if holds(problem, second):
            return second
        if not self._thorough:
            return replace(solution, status=QPStatus.UNSOLVED)
        return self._examined(problem, solution)

    def _left(self) -> float:
        return self.deadline - time.perf_counter()

    def _examined(self, problem: QPProblem, doubtful: QPSolution) -> QPSolution:
        """The answer of linear programs and of the proximal point method."""
        unsolved = replace(doubtful, status=QPStatus.UNSOLVED)
        nearest = least_violation(problem, self._left())
        if nearest is None or time.perf_counter() >= self.deadline:
            return unsolved
        if nearest.value > NO_MISS:
            proved = _proved(problem, nearest.multipliers)
            return replace(unsolved, status=QPStatus.INFEASIBLE) if proved else unsolved
        ray = falling_ray(problem, self._left())
        if ray is not None:
            return replace(unsolved, x=ray, status=QPStatus.UNBOUNDED)
        if not np.any(to_dense(problem.P)):
            vertex = solve_lp(problem, self._left())
            return unsolved if vertex is None else _verified_vertex(problem, vertex)
        if len(problem.c) > LARGEST or is_sparse(problem.P):
            return unsolved
        return ActiveSetSolver(nearest.x, self.deadline).solve(problem)


def holds(problem: QPProblem, solution: QPSolution) -> bool:
    """Whether a solution is one, also where the gradient itself is small."""
    if solution.status is not QPStatus.SOLVED or solution.primal_residual > NO_MISS:
        return False
    small = (problem.c != 0.0) & (np.abs(problem.c) < SMALL_SLOPE)
    if not small.any():
        return True
    known = solution.multipliers
    gradient = problem.P @ solution.x + problem.c - known.lower + known.upper
    size = np.abs(problem.c) + abs(problem.P) @ np.abs(solution.x)
    for weights, rows in ((known.rows, problem.G), (known.equalities, problem.A)):
        if weights.size:
            gradient = gradient - weights @ rows
            size = size + np.abs(weights) @ abs(rows)
    return bool(np.all(np.abs(gradient[small]) <= 1e-3 * size[small]))


class ActiveSetSolver:
    """The proximal point method: strictly convex QPs around the point before, solved by DAQP.

    Their active sets are exact, and so is a point that it accepts.
    """

    def __init__(self, start: FloatArray, deadline: float = np.inf) -> None:
        """Choose the first point, and the time on ``time.perf_counter`` to end at."""
        self._start = start
        self._deadline = deadline
        self._active_set = DAQPSolver(tolerance=1e-12)

    def solve(self, problem: QPProblem) -> QPSolution:
        """SOLVED or UNSOLVED; P becomes dense."""
        dense, unit = to_dense(problem.P), np.eye(len(problem.c))
        x, weight = self._start, FIRST_WEIGHT
        found = verified(
            problem, x, no_multipliers(problem), otherwise=QPStatus.UNSOLVED, iterations=0
        )
        for _ in range(PROXIMAL_STEPS):
            if time.perf_counter() >= self._deadline or weight > 1.0:
                break
            near = replace(problem, P=dense + weight * unit, c=problem.c - weight * x)
            step = self._active_set.strictly_convex(near)
            if step is None:
                weight *= 100.0
                continue
            found = verified(
                problem, step.x, step.multipliers, otherwise=QPStatus.UNSOLVED, iterations=0
            )
            if holds(problem, found) and found.dual_residual <= ACCURATE:
                return found
            if np.abs(step.x - x).max() <= 1e-14 * (1.0 + np.abs(x).max()):
                break
            x = step.x
        return found if holds(problem, found) else replace(found, status=QPStatus.UNSOLVED)


def no_multipliers(problem: QPProblem) -> QPMultipliers:
    """Zeros."""
    none = np.zeros_like(problem.c)
    rows, equations = np.zeros_like(problem.h), np.zeros_like(problem.b)
    return QPMultipliers(rows=rows, equalities=equations, lower=none, upper=none)


def falling_ray(problem: QPProblem, time_limit: float = np.inf) -> FloatArray | None:
    """A direction along which the objective falls for ever, certified; None where none is.

    It has no curvature: it minimises the linear term over the recession cone, cut off by a box.
    """
    curved = problem.P[np.flatnonzero(abs(problem.P).sum(axis=1) > 0.0)]
    cone = replace(
        problem,
        A=stack_rows([problem.A, curved]),
        b=np.zeros(len(problem.b) + curved.shape[0]),
        h=np.zeros_like(problem.h),
        lower=np.where(np.isfinite(problem.lower), 0.0, -1.0),
        upper=np.where(np.isfinite(problem.upper), 0.0, 1.0),
    )
    found = solve_lp(cone, time_limit)
    if found is None:
        return None
    for ray in (found.x, _on_active_rows(cone, found.x)):
        if proves_unbounded(problem, ray):
            return ray
    return None


def _proved(problem: QPProblem, weights: QPMultipliers) -> bool:
    """Whether weights prove that there is no point, as they are or less their rounding."""
    if proves_infeasible(problem, weights):
        return True
    for share in NEGLIGIBLE:
        balanced = _balanced(problem, weights, share)
        if balanced is not None and proves_infeasible(problem, balanced):
            return True
    return False


def _balanced(problem: QPProblem, weights: QPMultipliers, share: float) -> QPMultipliers | None:
    """The same weights without slope towards where variables have no bound.

    Those of rows below a share of the largest are zero; None where too little is left.
    """
    equations = len(problem.b)
    both = np.concatenate([weights.equalities, weights.rows])
    size = float(np.abs(both).max(initial=0.0))
    if not 0.0 < size < np.inf:
        return None
    kept = np.abs(both) > share * size
    both = np.where(kept, both / size, 0.0)
    matrix = to_dense(stack_rows([problem.A, problem.G]))[kept]
    for _ in range(BALANCINGS):
        slope = both[kept] @ matrix
        endless = np.isinf(np.where(slope > 0.0, problem.upper, problem.lower))
        endless &= slope != 0.0
        if endless.any():
            columns = matrix[:, endless]
            both[kept] -= columns @ np.linalg.lstsq(columns, both[kept], rcond=1e-12)[0]
        both[equations:] = np.maximum(both[equations:], 0.0)
    return replace(weights, equalities=both[:equations], rows=both[equations:])


def _verified_vertex(problem: QPProblem, vertex: LPSolution) -> QPSolution:
    return verified(
        problem, vertex.x, vertex.multipliers, otherwise=QPStatus.UNSOLVED, iterations=0
    )


def _on_active_rows(cone: QPProblem, ray: FloatArray) -> FloatArray:
    """A ray projected on the rows and bounds that it keeps as equations, less its rounding."""
    size = float(np.abs(ray).max(initial=0.0))
    fixed = np.abs(ray) <= 1e-9 * size
    rows = [to_dense(cone.A)]
    if cone.h.size:
        inward = cone.G @ ray
        rows.append(to_dense(cone.G[np.flatnonzero(inward <= 1e-9 * size)]))
    matrix = np.vstack(rows)[:, ~fixed]
    moved = np.where(fixed, 0.0, ray)
    if matrix.size:
        moved[~fixed] -= np.linalg.lstsq(matrix, matrix @ moved[~fixed], rcond=1e-12)[0]
    return moved
