"""Solvers of the contact QPCC: local search, the static-contact baseline and full enumeration."""

from __future__ import annotations

import itertools
import time

import numpy as np
import numpy.typing as npt

from warp_softbody.controllers.full_form import complementarity
from warp_softbody.controllers.lemke import forward_contact
from warp_softbody.controllers.pieces import LIFT, STICK
from warp_softbody.controllers.piqp_backend import PIQPBackend
from warp_softbody.controllers.qpcc import ContactQPCC, FloatArray
from warp_softbody.controllers.reduced import Node, ReducedProblem
from warp_softbody.controllers.result import QPCCResult, QPCCStatus, SolverOptions
from warp_softbody.controllers.search import LocalMinimum, Search
from warp_softbody.errors import InputError

BoolArray = npt.NDArray[np.bool_]

ENUMERATION_LIMIT = 4
"""Contacts that ``enumerate_qpcc`` accepts: 18^4 QPs with 8 directions already take a minute."""


def solve_qpcc(
    problem: ContactQPCC,
    *,
    start: tuple[int, ...] | None = None,
    fallback_controls: FloatArray | None = None,
    options: SolverOptions | None = None,
) -> QPCCResult:
    """Look for the best controls and contact modes (docs/method.md section 5).

    The root is ``start`` if its QP is feasible, else all contacts sticking, else the modes of the
    forward contact problem at the fallback controls. From there flips descend to a local minimum,
    which kicks then try to leave. Deterministic.

    Args:
        problem: the step's QPCC.
        start: modes of the last step's result, if the contacts are the same.
        fallback_controls: (nu,), the controls in use now; clipped to the bounds; default zero.
        options: budget and tolerances.
    """
    options = options or SolverOptions()
    search = _search(problem, options)
    controls = _fallback(search.reduced, fallback_controls)
    root = _root(search, start)
    forward = None
    if root is None:
        forward = forward_contact(search.reduced, controls)
        if forward is not None:
            root = search.visit(forward[0])
    if root is None:
        return _fall_back(search, controls, forward)
    minimum = search.improve(search.descend(root))
    return _finish(search, minimum.node, _verdict(minimum))


def solve_static(
    problem: ContactQPCC,
    *,
    touching: BoolArray | None = None,
    fallback_controls: FloatArray | None = None,
    options: SolverOptions | None = None,
) -> QPCCResult:
    """The baseline that the paper compares with: contacts hold still, nothing is searched.

    One QP in which every touching contact sticks (w = 0, force in the cone) and every other one is
    absent; ``touching`` (K,) defaults to all. Where that is infeasible the controls in use stay,
    with the forward contact solution that belongs to them.
    """
    search = _search(problem, options or SolverOptions())
    controls = _fallback(search.reduced, fallback_controls)
    if touching is None:
        touching = np.ones(problem.contact_count, dtype=bool)
    node = search.visit(tuple(STICK if holds else LIFT for holds in touching))
    if node is None:
        return _fall_back(search, controls, forward_contact(search.reduced, controls))
    return _finish(search, node, QPCCStatus.STATIC)


def enumerate_qpcc(problem: ContactQPCC) -> QPCCResult:
    """The global minimum, by one QP for every combination of modes; for tests and references.

    As certain as the QP solver's verdicts of infeasibility, which it cannot check.
    """
    if problem.contact_count > ENUMERATION_LIMIT:
        raise InputError(
            f"enumeration takes at most {ENUMERATION_LIMIT} contacts, got {problem.contact_count}"
        )
    options = SolverOptions(max_qps=10**9)
    search = _search(problem, options)
    valid = [np.flatnonzero(row) for row in search.reduced.table.valid]
    best: Node | None = None
    for modes in itertools.product(*valid):
        search.qp_count += 1
        node = search.reduced.solve(tuple(int(mode) for mode in modes))
        if node is not None and (best is None or node.value < best.value):
            best = node
    if best is None:
        return _fall_back(search, _fallback(search.reduced, None), None)
    return _finish(search, best, QPCCStatus.GLOBAL)


def _search(problem: ContactQPCC, options: SolverOptions) -> Search:
    backend = PIQPBackend(tolerance=options.qp_tolerance)
    return Search(ReducedProblem(problem, backend), options)


def _fallback(reduced: ReducedProblem, controls: FloatArray | None) -> FloatArray:
    """Scaled fallback controls, clipped to the bounds."""
    own = reduced.problem
    given = np.zeros(own.control_count) if controls is None else np.asarray(controls, dtype=float)
    if given.shape != own.lower.shape or not np.all(np.isfinite(given)):
        raise InputError(
            f"fallback_controls must be {own.control_count} finite numbers, got {given!r}"
        )
    clipped: FloatArray = np.clip(given, own.lower, own.upper) / reduced.control_scale
    return clipped


def _root(search: Search, start: tuple[int, ...] | None) -> Node | None:
    count = search.reduced.problem.contact_count
    if start is not None:
        highest = search.reduced.table.valid.shape[1]
        if len(start) != count or not all(0 <= mode < highest for mode in start):
            raise InputError(
                f"start must be {count} modes from 0 to {highest - 1}, got {tuple(start)!r}"
            )
        node = search.visit(tuple(int(mode) for mode in start))
        if node is not None:
            return node
    return search.visit((STICK,) * count)


def _verdict(minimum: LocalMinimum) -> QPCCStatus:
    if minimum.strongly_stationary:
        return QPCCStatus.STRONGLY_STATIONARY
    return QPCCStatus.NO_IMPROVING_FLIP if minimum.complete else QPCCStatus.BUDGET


def _fall_back(
    search: Search, controls: FloatArray, forward: tuple[tuple[int, ...], FloatArray] | None
) -> QPCCResult:
    """The forward contact point itself: consistent, whatever the objective says of it."""
    reduced = search.reduced
    count = reduced.problem.contact_count
    forward = forward or forward_contact(reduced, controls)
    status = QPCCStatus.INFEASIBLE if forward is None else QPCCStatus.FALLBACK_LCP
    modes, force = forward or ((LIFT,) * count, np.zeros(3 * count))
    node = Node(
        modes=modes,
        controls=controls,
        points=reduced.points_at(controls, force),
        slopes=np.zeros((count, 6)),
        value=np.nan,
        violation=np.nan,
        stationarity=np.nan,
    )
    return _finish(search, node, status)


def _finish(search: Search, node: Node, status: QPCCStatus) -> QPCCResult:
    """Unscale, and compute every residual again from the problem's full form."""
    problem, node = search.reduced.problem, search.reduced.polish(node)
    controls, forces = search.reduced.unscale(node.controls, node.points)
    residual = complementarity(problem, controls, forces)
    if not residual <= search.options.tolerance and status is not QPCCStatus.INFEASIBLE:
        status = QPCCStatus.INACCURATE
    outside = np.maximum(problem.lower - controls, controls - problem.upper)
    return QPCCResult(
        controls=controls,
        forces=forces,
        velocities=problem.velocity(controls, forces),
        modes=node.modes,
        objective=problem.objective(controls, forces),
        complementarity=residual,
        feasibility=max(0.0, float(np.max(outside))),
        stationarity=node.stationarity,
        qp_count=search.qp_count,
        seconds=time.perf_counter() - search.started,
        status=status,
        message=f"{status.value}; {search.qp_count} QPs, complementarity {residual:.1e}",
    )
