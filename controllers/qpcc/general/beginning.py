"""Where a solve of the general form begins: a scaled search, and a point if none is at hand."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np

from warp_softbody.controllers.qp.certified import CertifiedSolver
from warp_softbody.controllers.qp.problem import QPStatus
from warp_softbody.controllers.qpcc.general.branch_and_bound import BranchAndBound
from warp_softbody.controllers.qpcc.general.piece_qp import ScaledQPCC
from warp_softbody.controllers.qpcc.general.problem import QPCC
from warp_softbody.controllers.qpcc.general.restarts import initialize
from warp_softbody.controllers.qpcc.general.search import FIRST_TOLERANCE, GeneralSearch
from warp_softbody.controllers.qpcc.result import SolverOptions

SMALL = 0.25
"""Largest scaled variable of the relaxation's minimiser below which their unit is chosen anew: the
QPs' tolerances are those of variables near one."""

ZERO = 3e-4
"""Largest scaled variable that may be zero but for the QPs' tolerance."""

BRANCH_SHARE = 0.6
"""Share of the budget of QPs that branch and bound may use before the local search goes on."""


def new_search(
    problem: QPCC, options: SolverOptions, seed: int, *, cold: bool = True
) -> GeneralSearch:
    """A search over the scaled problem; a cold one knows how large variables are."""
    started = time.perf_counter()
    tolerance = max(options.qp_tolerance, FIRST_TOLERANCE)
    qp_solver = CertifiedSolver(tolerance, thorough=False)
    qp_solver.deadline = started + options.time_limit
    search = GeneralSearch(ScaledQPCC(problem, qp_solver), options, seed, started)
    if not cold or search.spent():
        return search
    relaxed = search.relaxed()
    largest = float(np.abs(relaxed.x).max())
    if relaxed.status is not QPStatus.SOLVED or not ZERO < largest < SMALL or search.spent():
        return search
    unit = float(np.exp2(np.ceil(np.log2(largest))))
    closer = ScaledQPCC(problem, qp_solver, unit=unit)
    closer.qp_count = search.general.qp_count
    return GeneralSearch(closer, options, seed, started)


def begin_anywhere(search: GeneralSearch) -> None:
    """Descend from the consistent point that is nearest to zero, or prove that there is none.

    Where the objective falls for ever on the relaxation, that has no minimiser to begin at.
    """
    general = search.general
    if search.settled or search.spent():
        return
    nearest = replace(
        general.problem,
        Q=np.diag(general.variable_scale**-2.0),
        c=np.zeros_like(general.c),
        P=None,
        q=None,
    )
    most = int(BRANCH_SHARE * (search.options.max_qps - general.qp_count))
    left = search.options.time_limit - (time.perf_counter() - search.started)
    if most < 1 or left <= 0.0:
        return
    sub = new_search(nearest, replace(search.options, max_qps=most, time_limit=left), 0)
    initialize(sub, None, None)
    BranchAndBound(sub).run(most)
    general.qp_count += sub.general.qp_count
    search.status.infeasible = sub.status.infeasible
    if sub.best is None:
        return
    x = sub.best.x * (sub.general.variable_scale / general.variable_scale)
    piece = search.visit(sub.best.sides, center=x)
    if piece is None and not search.settled:
        piece = general.solve(sub.best.sides, center=x, proximal=1.0)
    if piece is not None and piece.status is QPStatus.SOLVED:
        search.record(piece)
