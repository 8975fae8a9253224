"""Solvers of the contact QPCC: local search, the static-contact baseline and full enumeration."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace
from typing import overload

import numpy as np

from warp_softbody.arrays import BoolArray, FloatArray
from warp_softbody.controllers.qpcc.contact.cold_start import cold_minima
from warp_softbody.controllers.qpcc.contact.forward_lcp import forward_contact
from warp_softbody.controllers.qpcc.contact.mode_qp import Node
from warp_softbody.controllers.qpcc.contact.problem import ContactQPCC
from warp_softbody.controllers.qpcc.contact.verdict import (
    finish,
    forward_result,
    new_search,
    scaled_controls,
    verdict,
)
from warp_softbody.controllers.qpcc.contact.warm_start import static_modes, warm_minima
from warp_softbody.controllers.qpcc.general.problem import QPCC
from warp_softbody.controllers.qpcc.general.solve import enumerate_general, solve_general
from warp_softbody.controllers.qpcc.result import (
    COLD_OPTIONS,
    WARM_OPTIONS,
    GeneralResult,
    QPCCResult,
    QPCCStatus,
    SolverOptions,
)
from warp_softbody.errors import InputError
from warp_softbody.inputs import checks

ENUMERATION_LIMIT = 4
"""Contacts that ``enumerate_qpcc`` accepts: 18^4 QPs with 8 directions already take a minute."""


@overload
def solve_qpcc(
    problem: ContactQPCC,
    *,
    start: Sequence[int] | FloatArray | None = None,
    budget: int | None = None,
    tolerance: float | None = None,
    time_limit: float | None = None,
    seed: int = 0,
    fallback_controls: FloatArray | None = None,
    touching: BoolArray | None = None,
    options: SolverOptions | None = None,
) -> QPCCResult: ...


@overload
def solve_qpcc(
    problem: QPCC,
    *,
    start: Sequence[int] | FloatArray | None = None,
    budget: int | None = None,
    tolerance: float | None = None,
    time_limit: float | None = None,
    seed: int = 0,
    fallback_controls: None = None,
    touching: None = None,
    options: SolverOptions | None = None,
) -> GeneralResult: ...


def solve_qpcc(
    problem: ContactQPCC | QPCC,
    *,
    start: Sequence[int] | FloatArray | None = None,
    budget: int | None = None,
    tolerance: float | None = None,
    time_limit: float | None = None,
    seed: int = 0,
    fallback_controls: FloatArray | None = None,
    touching: BoolArray | None = None,
    options: SolverOptions | None = None,
) -> GeneralResult:
    """Look for the best point and modes (docs/qpcc.md). Deterministic for a seed.

    With ``start`` the search begins there; without, penalty runs find it (``options.starts``). From
    there flips descend to a local minimum, which kicks then try to leave. A contact problem is also
    begun with touching contacts sticking: with two QPs or more the result is never worse than that
    of ``solve_static``, where this has a point. If neither is feasible the search begins with the
    modes of the forward contact problem at the fallback controls.

    Args:
        problem: in contact or in general form.
        start: modes of an earlier result (contact: the same contacts); for the general form also
            a point.
        budget: QPs; default that of ``options``.
        tolerance: largest scaled residual that counts as consistent; default of ``options``.
        time_limit: s; default of ``options``.
        seed: of random starts.
        fallback_controls: contact form only: (nu,), the controls in use now; clipped to the
            bounds; default zero.
        touching: contact form only: (K,), which contacts to begin with as sticking; default all.
        options: all of the budget; default ``COLD_OPTIONS`` without a start, else
            ``WARM_OPTIONS``.
    """
    _check_problem(problem)
    if options is None:
        options = COLD_OPTIONS if start is None else WARM_OPTIONS
    checks.instance("options of solve_qpcc", options, SolverOptions)
    seed = checks.whole("seed of solve_qpcc", seed)
    options = replace(
        options,
        max_qps=options.max_qps if budget is None else budget,
        tolerance=options.tolerance if tolerance is None else tolerance,
        time_limit=options.time_limit if time_limit is None else time_limit,
    )
    if isinstance(problem, QPCC):
        if fallback_controls is not None:
            raise InputError("fallback_controls belong to the contact form")
        if touching is not None:
            raise InputError("touching contacts belong to the contact form")
        return solve_general(problem, start, options, seed)
    search = new_search(problem, options)
    controls = scaled_controls(search.reduced, fallback_controls)
    static = static_modes(search, touching)
    if start is None and options.starts:
        minima = cold_minima(search, static, seed)
    else:
        minima = warm_minima(search, start, static)
    if not minima:
        forward = forward_contact(search.reduced, controls)
        root = None if forward is None else search.visit(forward[0])
        if root is None:
            return forward_result(search, controls, forward)
        minima = [search.descend(root)]
    best = search.lowest(minima)
    held = start is not None and best.node.modes == tuple(start)
    if options.kick_held or not held:
        best = search.improve(minima)
    return finish(search, best.node, verdict(best))


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
    checks.instance("problem of solve_static", problem, ContactQPCC)
    search = new_search(problem, checks.optional("options", options, SolverOptions))
    controls = scaled_controls(search.reduced, fallback_controls)
    node = search.visit(static_modes(search, touching))
    if node is None:
        return forward_result(search, controls, forward_contact(search.reduced, controls))
    return finish(search, node, QPCCStatus.STATIC)


def _check_problem(problem: object) -> None:
    if not isinstance(problem, ContactQPCC | QPCC):
        checks.refuse("problem", "a ContactQPCC or a QPCC", problem)


@overload
def enumerate_qpcc(problem: ContactQPCC) -> QPCCResult: ...


@overload
def enumerate_qpcc(problem: QPCC) -> GeneralResult: ...


def enumerate_qpcc(problem: ContactQPCC | QPCC) -> GeneralResult:
    """The global minimum, for tests and references.

    Contact form: one QP for every combination of modes. General form: branch and bound over the
    pairs, which leaves out only what a relaxation shows to be worse. As certain as the QP solver's
    verdicts of infeasibility, which neither can check.
    """
    _check_problem(problem)
    if isinstance(problem, QPCC):
        return enumerate_general(problem)
    if problem.contact_count > ENUMERATION_LIMIT:
        raise InputError(
            f"enumeration takes at most {ENUMERATION_LIMIT} contacts, got {problem.contact_count}"
        )
    options = SolverOptions(max_qps=10**9)
    search = new_search(problem, options)
    valid = [np.flatnonzero(row) for row in search.reduced.table.valid]
    best: Node | None = None
    for modes in itertools.product(*valid):
        node = search.reduced.solve(tuple(int(mode) for mode in modes))
        if node is not None and (best is None or node.value < best.value):
            best = node
    if best is None:
        return forward_result(search, scaled_controls(search.reduced, None), None)
    return finish(search, best, QPCCStatus.GLOBAL)
