"""Parts that every solver of the contact form shares: begin, fall back, and hand out a result."""

from __future__ import annotations

import time

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.qp.daqp import DAQPSolver
from warp_softbody.controllers.qpcc.contact.complementarity_form import full_point, residual
from warp_softbody.controllers.qpcc.contact.force_elimination import ReducedProblem
from warp_softbody.controllers.qpcc.contact.forward_lcp import forward_contact
from warp_softbody.controllers.qpcc.contact.local_search import LocalMinimum, Search
from warp_softbody.controllers.qpcc.contact.mode_qp import Node
from warp_softbody.controllers.qpcc.contact.mode_table import LIFT
from warp_softbody.controllers.qpcc.contact.problem import ContactQPCC
from warp_softbody.controllers.qpcc.general.solve import UNUSABLE
from warp_softbody.controllers.qpcc.result import (
    ContactMultipliers,
    QPCCResult,
    QPCCStatus,
    SolverOptions,
)
from warp_softbody.inputs import array_checks


def new_search(problem: ContactQPCC, options: SolverOptions) -> Search:
    """A search over the problem, its clock started."""
    qp_solver = DAQPSolver(tolerance=options.qp_tolerance)
    return Search(ReducedProblem(problem, qp_solver), options)


def scaled_controls(reduced: ReducedProblem, controls: FloatArray | None) -> FloatArray:
    """Scaled fallback controls, clipped to the bounds."""
    own = reduced.problem
    given = np.zeros(own.control_count) if controls is None else controls
    given = array_checks.array("fallback_controls", given, own.lower.shape)
    clipped: FloatArray = np.clip(given, own.lower, own.upper) / reduced.control_scale
    return clipped


def verdict(minimum: LocalMinimum) -> QPCCStatus:
    """What a local minimum may claim."""
    if minimum.strongly_stationary:
        return QPCCStatus.STRONGLY_STATIONARY
    return QPCCStatus.NO_IMPROVING_FLIP if minimum.complete else QPCCStatus.BUDGET


def forward_result(
    search: Search, controls: FloatArray, forward: tuple[tuple[int, ...], FloatArray] | None
) -> QPCCResult:
    """The forward contact point itself: consistent, whatever the objective says of it."""
    reduced = search.reduced
    count = reduced.problem.contact_count
    forward = forward or forward_contact(reduced, controls)
    status = QPCCStatus.NO_POINT if forward is None else QPCCStatus.FALLBACK_LCP
    modes, force = forward or ((LIFT,) * count, np.zeros(3 * count))
    node = Node(
        modes=modes,
        controls=controls,
        points=reduced.points_at(controls, force),
        slopes_there=lambda: np.zeros((count, 6)),
        value=np.nan,
        stationarity=np.nan,
    )
    return finish(search, node, status)


def finish(search: Search, node: Node, status: QPCCStatus) -> QPCCResult:
    """Unscale, and compute every residual again from the problem's full form."""
    reduced = search.reduced
    problem, node = reduced.problem, reduced.polish(node)
    controls, forces = reduced.unscale(node.controls, node.points)
    x, velocities = full_point(problem, controls, forces), problem.velocity(controls, forces)
    off = residual(problem, x, velocities)
    if not off <= search.options.tolerance and status not in UNUSABLE:
        status = QPCCStatus.INACCURATE
    outside = np.maximum(problem.lower - controls, controls - problem.upper)
    stationarity, multipliers = np.nan, None
    if np.isfinite(node.stationarity):
        slopes, rest, stationarity = reduced.multipliers(node)
        multipliers = ContactMultipliers(
            force=slopes[:, :3] * (reduced.value_scale / reduced.impulse),
            velocity=slopes[:, 3:] * (reduced.value_scale / reduced.speed),
            controls=rest * (reduced.value_scale / reduced.control_scale),
        )
    return QPCCResult(
        x=x,
        controls=controls,
        forces=forces,
        velocities=velocities,
        modes=node.modes,
        objective=problem.objective(controls, forces),
        complementarity=off,
        feasibility=max(0.0, float(np.max(outside))),
        stationarity=stationarity,
        multipliers=multipliers,
        qp_count=search.qp_count,
        seconds=time.perf_counter() - search.started,
        status=status,
        message=f"{status.value}; {search.qp_count} QPs, complementarity {off:.1e}",
    )
