"""The solvers of the general form, and what their result claims."""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.qp.problem import EXACT
from warp_softbody.controllers.qpcc.general.beginning import (
    BRANCH_SHARE,
    begin_anywhere,
    new_search,
)
from warp_softbody.controllers.qpcc.general.branch_and_bound import LOGGER, BranchAndBound
from warp_softbody.controllers.qpcc.general.piece_qp import ScaledQPCC
from warp_softbody.controllers.qpcc.general.piece_solution import LEFT, PieceSolution, Sides
from warp_softbody.controllers.qpcc.general.problem import QPCC
from warp_softbody.controllers.qpcc.general.restarts import (
    initialize,
    penalise,
    perturb,
    restart,
    tighten,
)
from warp_softbody.controllers.qpcc.general.search import GeneralSearch
from warp_softbody.controllers.qpcc.result import (
    GeneralMultipliers,
    GeneralResult,
    QPCCStatus,
    SolverOptions,
)
from warp_softbody.errors import InputError
from warp_softbody.inputs import checks

STATIONARY = 1e-6
"""Largest residual of a stationary point: steps over an objective that is not convex may end before
they settle."""

NODES, MIDDLE, LEAST_NODES = 1200, 250, 60
"""QPs of branch and bound where variables and pairs are no more than so many; beyond that their
number falls with the square of the size, down to the least."""


def solve_general(
    problem: QPCC, start: Sequence[int] | FloatArray | None, options: SolverOptions, seed: int
) -> GeneralResult:
    """Search for the best point (``solve_qpcc``)."""
    search = new_search(problem, options, seed, cold=start is None)
    point, sides = _start(problem, start)
    point = None if point is None else point / search.general.variable_scale
    initialize(search, point, sides)
    if search.best is None and search.general.concave_part is not None:
        begin_anywhere(search)
    tree = None
    if options.starts:
        tighten(search)
        tree = BranchAndBound(search)
        tree.run(_branch_limit(search))
    if search.best is None or options.starts:
        penalise(search, point)
    if not search.settled:
        restart(search)
        perturb(search)
    if tree is not None:
        # so that what ends below its budget is proved, but for large ones
        left = options.max_qps - search.general.qp_count
        tree.run(min(left, _branch_limit(search)))
    if search.best is not None and search.is_matched(search.bound):
        search.status.certified = True
    return _finish(search)


def _branch_limit(search: GeneralSearch) -> int:
    """QPs that branch and bound may use: a share of the budget, and fewer of large ones."""
    size = len(search.general.c) + len(search.general.l0)
    affordable = max(LEAST_NODES, int(NODES * min(1.0, (MIDDLE / size) ** 2)))
    return int(min(BRANCH_SHARE * search.options.max_qps, affordable))


def enumerate_general(problem: QPCC, time_limit: float) -> GeneralResult:
    """The global minimum by branch and bound (``enumerate_qpcc``)."""
    search = new_search(problem, SolverOptions(max_qps=10**9, time_limit=time_limit), 0)
    if search.general.concave_part is not None:
        raise InputError("enumeration needs a positive semidefinite Q")
    initialize(search, None, None)
    tighten(search)
    BranchAndBound(search).run(10**9)
    return _finish(search)


def _start(
    problem: QPCC, start: Sequence[int] | FloatArray | None
) -> tuple[FloatArray | None, Sides | None]:
    """What a start gives: a point, a piece, or neither."""
    if start is None:
        return None, None
    wanted = f"{problem.pair_count} sides, 0 or 1, or {problem.variable_count} finite numbers"
    try:
        given = np.asarray(start)
    except Exception:
        # rows of unequal length, or an object whose own conversion fails
        checks.refuse("start", wanted, start)
    if given.dtype.kind in "iub" and given.shape == (problem.pair_count,):
        if np.all((given == 0) | (given == 1)):
            return None, given.astype(np.int8)
    elif given.dtype.kind == "f" and given.shape == (problem.variable_count,):
        if np.all(np.isfinite(given)):
            return np.clip(given, problem.lb, problem.ub), None
    checks.refuse("start", wanted, start)


def _finish(search: GeneralSearch) -> GeneralResult:
    general, best = search.general, search.best
    problem = general.problem
    status = _status(search)
    x = np.clip(np.zeros(problem.variable_count), problem.lb, problem.ub)
    multipliers, stationarity = None, np.nan
    sides = np.zeros(problem.pair_count, np.int8)
    if best is not None:
        x, best = _refined(general, best)
        sides = best.sides
        if status is not QPCCStatus.UNBOUNDED:
            multipliers = _multipliers(general, best)
            stationarity = _stationarity(general, x, multipliers, sides)
    off, out = problem.complementarity(x), problem.feasibility(x)
    if status is QPCCStatus.STRONGLY_STATIONARY and not stationarity <= STATIONARY:
        status = QPCCStatus.NO_IMPROVING_FLIP
    if not max(off, out) <= search.options.tolerance and status.usable:
        status = QPCCStatus.INACCURATE
    objective = problem.objective(x)
    ray = search.status.ray
    result = GeneralResult(
        x=x,
        modes=tuple(int(side) for side in sides),
        objective=objective,
        lower_bound=_lower_bound(search, objective, status),
        complementarity=off,
        feasibility=out,
        stationarity=stationarity,
        multipliers=multipliers,
        qp_count=general.qp_count,
        seconds=time.perf_counter() - search.started,
        status=status,
        message=f"{status.value}; {general.qp_count} QPs, complementarity {off:.1e}",
        ray=None if ray is None else ray * general.variable_scale,
    )
    LOGGER.info("%s, objective %g, lower bound %g", result.message, objective, result.lower_bound)
    return result


def _refined(general: ScaledQPCC, best: PieceSolution) -> tuple[FloatArray, PieceSolution]:
    """The best point projected on its active rows, from a more exact QP where that misses them."""
    x, problem = general.polish(best), general.problem
    miss = max(problem.complementarity(x), problem.feasibility(x))
    if miss <= EXACT or not np.isfinite(best.value):
        return x, best
    exact = general.solve_exactly(best)
    if exact is None:
        return x, best
    other = general.polish(exact)
    better = max(problem.complementarity(other), problem.feasibility(other)) < miss
    return (other, exact) if better else (x, best)


def _lower_bound(search: GeneralSearch, objective: float, status: QPCCStatus) -> float:
    """In the problem's units; plus infinity where there is no point."""
    if status is QPCCStatus.INFEASIBLE:
        return np.inf
    if status is QPCCStatus.UNBOUNDED:
        return -np.inf
    bound = search.general.value_scale * search.bound + search.general.problem.c0
    return min(bound, objective) if status.usable else bound


def _status(search: GeneralSearch) -> QPCCStatus:
    known = search.status
    if known.unbounded:
        return QPCCStatus.UNBOUNDED
    if search.best is None:
        return QPCCStatus.INFEASIBLE if known.infeasible else QPCCStatus.NO_POINT
    if known.certified:
        return QPCCStatus.GLOBAL
    if known.stationary:
        return QPCCStatus.STRONGLY_STATIONARY
    return QPCCStatus.NO_IMPROVING_FLIP if known.complete else QPCCStatus.BUDGET


def _multipliers(general: ScaledQPCC, piece: PieceSolution) -> GeneralMultipliers:
    """The multipliers of the piece's QP in the problem's own units."""
    problem, scale = general.problem, general.value_scale * piece.objective_scale
    known = piece.solution.multipliers
    over, over_row, over_left, over_right = general.side_scales
    inequalities = np.zeros(len(problem.h))
    above, below = np.isfinite(problem.h), np.isfinite(problem.h_lower)
    split, end = int(above.sum()), int(above.sum() + below.sum())
    inequalities[above] += known.rows[:split]
    inequalities[below] -= known.rows[split:end]
    return GeneralMultipliers(
        equalities=scale * known.equalities[: len(problem.b)] / over,
        inequalities=scale * inequalities / over_row,
        lower=scale * known.lower / general.variable_scale,
        upper=scale * known.upper / general.variable_scale,
        left=general.value_scale * piece.left_multiplier / over_left,
        right=general.value_scale * piece.right_multiplier / over_right,
    )


def _stationarity(
    general: ScaledQPCC, x: FloatArray, multipliers: GeneralMultipliers, sides: Sides
) -> float:
    """Largest entry of the Lagrangian's gradient or of a wrong sign, in scaled units."""
    problem = general.problem
    gradient = problem.Q @ x + problem.c - multipliers.equalities @ problem.A
    gradient += multipliers.inequalities @ problem.G - multipliers.lower + multipliers.upper
    gradient -= multipliers.left @ problem.L + multipliers.right @ problem.R
    gradient *= general.variable_scale
    _, _, over_left, over_right = general.side_scales
    kept = np.where(sides == LEFT, multipliers.right * over_right, multipliers.left * over_left)
    worst = max(float(np.abs(gradient).max()), -float(kept.min(initial=0.0)))
    size = general.value_scale * (1.0 + float(np.abs(x / general.variable_scale).max()))
    return worst / size
