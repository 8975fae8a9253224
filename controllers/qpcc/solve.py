"""The solvers of a QPCC in either form: local search, static contacts, exhaustive search."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import overload

from warp_softbody.arrays import BoolArray, FloatArray
from warp_softbody.controllers.qpcc.contact.problem import ContactQPCC
from warp_softbody.controllers.qpcc.contact.solve import (
    enumerate_contact,
    solve_contact,
    solve_contact_static,
)
from warp_softbody.controllers.qpcc.general.problem import QPCC
from warp_softbody.controllers.qpcc.general.solve import enumerate_general, solve_general
from warp_softbody.controllers.qpcc.result import (
    COLD_OPTIONS,
    WARM_OPTIONS,
    GeneralResult,
    QPCCResult,
    SolverOptions,
)
from warp_softbody.errors import InputError
from warp_softbody.inputs import checks


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
    others: Sequence[Sequence[int]] = (),
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
    others: tuple[()] = (),
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
    others: Sequence[Sequence[int]] = (),
    options: SolverOptions | None = None,
) -> GeneralResult:
    """Search for the best point of a QPCC (docs/qpcc.md); deterministic for a seed.

    A local search descends from one or more points to local minima, which kicks then try to leave.
    With ``start`` it begins there; without, the penalty method finds where to begin
    (``options.starts``). A contact problem is also begun with touching contacts sticking: with two
    QPs or more the result is never worse than that of ``solve_static``, where this has a point. If
    neither has one the search begins with the modes of the forward contact problem at the fallback
    controls.

    Args:
        problem: in contact or in general form.
        start: modes of an earlier result, with the same contacts; for the general form also a
            point.
        budget: most QPs; default ``options.max_qps``.
        tolerance: largest scaled residual of a consistent point; default ``options.tolerance``.
        time_limit: s; default ``options.time_limit``.
        seed: of random starts.
        fallback_controls: contact form only: (nu,), the controls in use now, which are clipped to
            the bounds; default zero.
        touching: contact form only: (K,), which contacts stick at first; default all.
        others: contact form only, beside ``start``: further modes to begin from, as
            ``QPCCResult.others`` has them.
        options: of the solve; default ``COLD_OPTIONS`` without a start, else ``WARM_OPTIONS``.

    Raises:
        InputError: an argument is not what it has to be; the sentence names it.
    """
    _check_problem(problem)
    if options is None:
        options = COLD_OPTIONS if start is None else WARM_OPTIONS
    checks.instance("options of solve_qpcc", options, SolverOptions)
    seed = checks.whole("seed of solve_qpcc", seed)
    given = {"max_qps": budget, "tolerance": tolerance, "time_limit": time_limit}
    changed = {name: value for name, value in given.items() if value is not None}
    if changed:
        options = replace(options, **changed)  # type: ignore[arg-type]
    if isinstance(problem, QPCC):
        if fallback_controls is not None:
            raise InputError("fallback_controls belong to the contact form")
        if touching is not None:
            raise InputError("touching contacts belong to the contact form")
        if not isinstance(others, tuple) or others:
            raise InputError("others belong to the contact form")
        return solve_general(problem, start, options, seed)
    return solve_contact(problem, start, options, seed, fallback_controls, touching, others)


def solve_static(
    problem: ContactQPCC,
    *,
    touching: BoolArray | None = None,
    fallback_controls: FloatArray | None = None,
    options: SolverOptions | None = None,
) -> QPCCResult:
    """The static-contact baseline with which the paper compares: contacts hold, no search.

    It is one QP in which every touching contact sticks (w = 0, force in its cone) and all others
    are absent; ``touching`` (K,) defaults to all. Where it is infeasible the result has the
    fallback controls and the forward contact solution that belongs to them.
    """
    checks.instance("problem of solve_static", problem, ContactQPCC)
    options = checks.optional("options", options, SolverOptions)
    return solve_contact_static(problem, options, fallback_controls, touching)


def _check_problem(problem: object) -> None:
    if not isinstance(problem, ContactQPCC | QPCC):
        checks.refuse("problem", "a ContactQPCC or a QPCC", problem)


@overload
def enumerate_qpcc(problem: ContactQPCC, *, time_limit: float | None = None) -> QPCCResult: ...


@overload
def enumerate_qpcc(problem: QPCC, *, time_limit: float | None = None) -> GeneralResult: ...


def enumerate_qpcc(
    problem: ContactQPCC | QPCC, *, time_limit: float | None = None
) -> GeneralResult:
    """The global minimum of a small QPCC, for tests and references.

    The contact form takes one QP for every combination of modes, the general form branch and bound
    over the pairs. After ``time_limit`` seconds (default none) the best point so far comes back,
    with a lower bound and a status that claims no more.
    """
    _check_problem(problem)
    if time_limit is not None:
        checks.number("time_limit of enumerate_qpcc", time_limit, above=0.0, infinite=True)
    time_limit = math.inf if time_limit is None else float(time_limit)
    if isinstance(problem, QPCC):
        return enumerate_general(problem, time_limit)
    return enumerate_contact(problem, time_limit)
