"""The solvers of the contact form, and what their result claims."""

from __future__ import annotations

import itertools
import time
from collections.abc import Sequence

import numpy as np

from warp_softbody.arrays import BoolArray, FloatArray
from warp_softbody.controllers.qp.daqp import DAQPSolver
from warp_softbody.controllers.qpcc.contact.cold_start import (
    ForwardPoint,
    cold_minima,
    forward_point,
    relaxation_bound,
)
from warp_softbody.controllers.qpcc.contact.complementarity_form import full_point, scaled_residual
from warp_softbody.controllers.qpcc.contact.kkt_residual import kkt_residual
from warp_softbody.controllers.qpcc.contact.local_search import ContactSearch, LocalMinimum
from warp_softbody.controllers.qpcc.contact.mode_minimiser import ModeMinimiser
from warp_softbody.controllers.qpcc.contact.mode_qp import ScaledContactQPCC
from warp_softbody.controllers.qpcc.contact.mode_table import LIFT
from warp_softbody.controllers.qpcc.contact.problem import ContactQPCC
from warp_softbody.controllers.qpcc.contact.warm_start import static_modes, warm_minima
from warp_softbody.controllers.qpcc.next_minima import OTHERS
from warp_softbody.controllers.qpcc.result import (
    ContactMultipliers,
    QPCCResult,
    QPCCStatus,
    SolverOptions,
)
from warp_softbody.errors import InputError
from warp_softbody.inputs import array_checks

ENUMERATION_LIMIT = 4
"""Most contacts of ``enumerate_contact``: 18^4 QPs with 8 directions already take a minute."""


def solve_contact(
    problem: ContactQPCC,
    start: Sequence[int] | FloatArray | None,
    options: SolverOptions,
    seed: int,
    fallback_controls: FloatArray | None,
    touching: BoolArray | None,
    others: Sequence[Sequence[int]] = (),
) -> QPCCResult:
    """Search for the best point (``solve_qpcc``)."""
    search = _search(problem, options)
    controls = _scaled_controls(search.scaled, fallback_controls)
    static, bound = static_modes(search, touching), -np.inf
    if start is None and options.starts:
        cold = cold_minima(search, static, controls, seed)
        if cold.infeasible:
            return _without_point(search, controls)
        minima, bound = cold.minima, cold.bound
    else:
        minima = warm_minima(search, start, static, others)
    if not minima:
        known = forward_point(search, controls)
        root = None if known.forward is None else search.visit(known.forward[0])
        if root is None:
            return _forward_result(search, controls, known)
        minima = [search.descend(root)]
    best = search.lowest(minima)
    held = start is not None and best.minimiser.modes == tuple(start)
    if options.kick_held or not held:
        best = search.perturb(minima)
    if not problem.contact_count:
        # one convex QP: its minimum is its own bound
        bound = np.inf if best.strongly_stationary else bound
    elif options.bound and bound == -np.inf:
        bound = relaxation_bound(search)
    return _finish(search, best.minimiser, _status(best), bound, _next_best(minima, best))


def solve_contact_static(
    problem: ContactQPCC,
    options: SolverOptions,
    fallback_controls: FloatArray | None,
    touching: BoolArray | None,
) -> QPCCResult:
    """The static-contact baseline (``solve_static``)."""
    search = _search(problem, options)
    controls = _scaled_controls(search.scaled, fallback_controls)
    minimiser = search.visit(static_modes(search, touching))
    if minimiser is None:
        return _forward_result(search, controls, forward_point(search, controls))
    return _finish(search, minimiser, QPCCStatus.STATIC)


def enumerate_contact(problem: ContactQPCC, time_limit: float) -> QPCCResult:
    """The global minimum, by one QP for every combination of modes (``enumerate_qpcc``)."""
    if problem.contact_count > ENUMERATION_LIMIT:
        raise InputError(
            f"enumeration takes at most {ENUMERATION_LIMIT} contacts, got {problem.contact_count}"
        )
    search = _search(problem, SolverOptions(max_qps=10**9, time_limit=time_limit))
    valid = [np.flatnonzero(row) for row in search.scaled.table.valid]
    best: ModeMinimiser | None = None
    for modes in itertools.product(*valid):
        if search.spent:
            break
        minimiser = search.scaled.solve(tuple(int(mode) for mode in modes))
        if minimiser is not None and (best is None or minimiser.value < best.value):
            best = minimiser
    if best is None:
        controls = _scaled_controls(search.scaled, None)
        return _forward_result(search, controls, forward_point(search, controls))
    return _finish(search, best, QPCCStatus.BUDGET if search.spent else QPCCStatus.GLOBAL)


def _next_best(minima: list[LocalMinimum], best: LocalMinimum) -> tuple[tuple[int, ...], ...]:
    """Modes of the minima that come after the best one, whose number is bounded."""
    rest = [minimum.minimiser for minimum in minima if minimum.minimiser is not best.minimiser]
    return tuple(minimiser.modes for minimiser in sorted(rest, key=lambda m: m.value)[:OTHERS])


def _search(problem: ContactQPCC, options: SolverOptions) -> ContactSearch:
    """A search over the problem, with its clock started."""
    qp_solver = DAQPSolver(tolerance=options.qp_tolerance)
    return ContactSearch(ScaledContactQPCC(problem, qp_solver), options)


def _scaled_controls(scaled: ScaledContactQPCC, controls: FloatArray | None) -> FloatArray:
    """The fallback controls, clipped to their bounds and scaled."""
    own = scaled.problem
    given = np.zeros(own.control_count) if controls is None else controls
    given = array_checks.array("fallback_controls", given, own.lower.shape)
    clipped: FloatArray = np.clip(given, own.lower, own.upper) / scaled.control_scale
    return clipped


def _status(minimum: LocalMinimum) -> QPCCStatus:
    """What is known of a local minimum."""
    if minimum.strongly_stationary:
        return QPCCStatus.STRONGLY_STATIONARY
    return QPCCStatus.NO_IMPROVING_FLIP if minimum.complete else QPCCStatus.BUDGET


def _forward_result(search: ContactSearch, controls: FloatArray, known: ForwardPoint) -> QPCCResult:
    """The solution of the forward contact problem, which ignores the objective."""
    if known.infeasible:
        return _without_point(search, controls)
    count = search.scaled.problem.contact_count
    status = QPCCStatus.NO_POINT if known.forward is None else QPCCStatus.FALLBACK_LCP
    modes, force = known.forward or ((LIFT,) * count, np.zeros(3 * count))
    minimiser = _pointless(search, modes, controls, force)
    return _finish(search, minimiser, status)


def _without_point(search: ContactSearch, controls: FloatArray) -> QPCCResult:
    """The result where the relaxation, and so every choice of modes, is proved to have no point."""
    count = search.scaled.problem.contact_count
    force = np.zeros(3 * count)
    minimiser = _pointless(search, (LIFT,) * count, controls, force)
    return _finish(search, minimiser, QPCCStatus.INFEASIBLE, np.inf)


def _pointless(
    search: ContactSearch, modes: tuple[int, ...], controls: FloatArray, force: FloatArray
) -> ModeMinimiser:
    """Controls and forces that no QP gave."""
    return ModeMinimiser(
        modes=modes,
        controls=controls,
        points=search.scaled.points_at(controls, force),
        compute_multipliers=lambda: np.zeros((len(modes), 6)),
        value=np.nan,
        stationarity=np.nan,
    )


def _finish(
    search: ContactSearch,
    minimiser: ModeMinimiser,
    status: QPCCStatus,
    bound: float = -np.inf,
    others: tuple[tuple[int, ...], ...] = (),
) -> QPCCResult:
    """The result in the problem's own units, with residuals computed anew from all pairs."""
    scaled = search.scaled
    problem, minimiser = scaled.problem, scaled.polish(minimiser)
    controls, forces = scaled.unscale(minimiser.controls, minimiser.points)
    x, velocities = full_point(problem, controls, forces), problem.velocity(controls, forces)
    off = scaled_residual(problem, x, velocities)
    if not off <= search.options.tolerance and status.usable:
        status = QPCCStatus.INACCURATE
    objective = problem.objective(controls, forces)
    if status is QPCCStatus.GLOBAL:
        bound = objective
    outside = np.maximum(problem.lower - controls, controls - problem.upper)
    stationarity, multipliers = np.nan, None
    if np.isfinite(minimiser.stationarity):
        slopes, rest, stationarity = kkt_residual(scaled, minimiser)
        multipliers = ContactMultipliers(
            force=slopes[:, :3] * (scaled.value_scale / scaled.impulse),
            velocity=slopes[:, 3:] * (scaled.value_scale / scaled.speed),
            controls=rest * (scaled.value_scale / scaled.control_scale),
        )
    return QPCCResult(
        x=x,
        controls=controls,
        forces=forces,
        velocities=velocities,
        modes=minimiser.modes,
        others=others,
        objective=objective,
        lower_bound=min(bound, objective) if status.usable else bound,
        complementarity=off,
        feasibility=max(0.0, float(np.max(outside))),
        stationarity=stationarity,
        multipliers=multipliers,
        qp_count=search.qp_count,
        seconds=time.perf_counter() - search.started,
        status=status,
        message=f"{status.value}; {search.qp_count} QPs, complementarity {off:.1e}",
    )
