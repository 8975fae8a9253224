"""The solvers of the general form, and what their result claims."""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.qp.piqp import PIQPSolver
from warp_softbody.controllers.qpcc.general.branch_and_bound import branch_and_bound
from warp_softbody.controllers.qpcc.general.piece_qp import ScaledQPCC
from warp_softbody.controllers.qpcc.general.piece_solution import LEFT, PieceSolution, Sides
from warp_softbody.controllers.qpcc.general.problem import QPCC, row_scales
from warp_softbody.controllers.qpcc.general.restarts import initialize, perturb, restart
from warp_softbody.controllers.qpcc.general.search import GeneralSearch
from warp_softbody.controllers.qpcc.result import (
    GeneralMultipliers,
    GeneralResult,
    QPCCStatus,
    SolverOptions,
)
from warp_softbody.errors import InputError
from warp_softbody.inputs import checks

BRANCH_PAIRS = 40
"""Most pairs with which branch and bound is tried where no start is given."""

BRANCH_SHARE = 0.5
"""Share of the budget of QPs that branch and bound may use."""


def solve_general(
    problem: QPCC, start: Sequence[int] | FloatArray | None, options: SolverOptions, seed: int
) -> GeneralResult:
    """Search for the best point (``solve_qpcc``)."""
    search = _search(problem, options, seed)
    initialize(search, *_start(problem, start))
    if options.starts and problem.pair_count <= BRANCH_PAIRS and not search.settled:
        branch_and_bound(search, int(BRANCH_SHARE * options.max_qps))
    if not search.settled:
        restart(search)
        perturb(search)
    return _finish(search)


def enumerate_general(problem: QPCC) -> GeneralResult:
    """The global minimum by branch and bound (``enumerate_qpcc``)."""
    search = _search(problem, SolverOptions(max_qps=10**9), 0)
    if search.general.concave_part is not None:
        raise InputError("enumeration needs a positive semidefinite Q")
    branch_and_bound(search, 10**9)
    return _finish(search)


def _search(problem: QPCC, options: SolverOptions, seed: int) -> GeneralSearch:
    # Sizes and scales of general problems vary more than three sweeps of equilibration mend.
    qp_solver = PIQPSolver(tolerance=options.qp_tolerance, settings={"preconditioner_iter": 10})
    return GeneralSearch(ScaledQPCC(problem, qp_solver), options, seed)


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
        x, sides = general.polish(best), best.sides
        if status is not QPCCStatus.UNBOUNDED:
            multipliers = _multipliers(general, best)
            stationarity = _stationarity(general, x, multipliers, sides)
    off, out = problem.complementarity(x), problem.feasibility(x)
    if not max(off, out) <= search.options.tolerance and status.usable:
        status = QPCCStatus.INACCURATE
    return GeneralResult(
        x=x,
        modes=tuple(int(side) for side in sides),
        objective=problem.objective(x),
        complementarity=off,
        feasibility=out,
        stationarity=stationarity,
        multipliers=multipliers,
        qp_count=general.qp_count,
        seconds=time.perf_counter() - search.started,
        status=status,
        message=f"{status.value}; {general.qp_count} QPs, complementarity {off:.1e}",
    )


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
    inequalities = np.zeros(len(problem.h))
    used = np.isfinite(problem.h)
    inequalities[used] = known.rows[: int(used.sum())]
    over_left, over_right = problem.side_scales
    return GeneralMultipliers(
        equalities=scale * known.equalities[: len(problem.b)] / row_scales(problem.A, problem.b),
        inequalities=scale * inequalities / row_scales(problem.G, problem.h),
        lower=scale * known.lower,
        upper=scale * known.upper,
        left=general.value_scale * piece.left_multiplier / over_left,
        right=general.value_scale * piece.right_multiplier / over_right,
    )


def _stationarity(
    general: ScaledQPCC, x: FloatArray, multipliers: GeneralMultipliers, sides: Sides
) -> float:
    """Largest entry of the Lagrangian's gradient or of a wrong sign, relative to the objective."""
    problem = general.problem
    gradient = problem.Q @ x + problem.c - multipliers.equalities @ problem.A
    gradient += multipliers.inequalities @ problem.G - multipliers.lower + multipliers.upper
    gradient -= multipliers.left @ problem.L + multipliers.right @ problem.R
    over_left, over_right = problem.side_scales
    kept = np.where(sides == LEFT, multipliers.right * over_right, multipliers.left * over_left)
    worst = max(float(np.abs(gradient).max()), -float(kept.min(initial=0.0)))
    size = general.value_scale * (1.0 + float(np.abs(x).max()))
    return worst / size
