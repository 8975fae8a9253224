"""Local minima of a contact QPCC from penalty runs on its general form, where no start is given."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.qp.certified import CertifiedSolver
from warp_softbody.controllers.qp.problem import QPStatus
from warp_softbody.controllers.qpcc.contact.complementarity_form import force_map, to_general
from warp_softbody.controllers.qpcc.contact.forward_lcp import (
    block_gauss_seidel,
    by_lemke,
    forward_contact,
)
from warp_softbody.controllers.qpcc.contact.local_search import ContactSearch, LocalMinimum
from warp_softbody.controllers.qpcc.contact.mode_minimiser import ModeMinimiser
from warp_softbody.controllers.qpcc.general.penalty import SCHEDULES, close_pairs
from warp_softbody.controllers.qpcc.general.piece_qp import ScaledQPCC
from warp_softbody.controllers.qpcc.general.piece_solution import OPEN
from warp_softbody.controllers.qpcc.general.restarts import random_point

COLD_QPS = 300
"""QPs after which no penalty run begins: the rest is for kicks."""

FIRST_KICKS, FIRST_PATIENCE = 4, 2
"""Kicks and patience before penalty runs, over those of the options: the QPs of modes take a tenth
to a hundredth of the time of those of the general form."""

MIDDLE = 240
"""Variables of the general form up to which that many QPs are spent; beyond, fewer by the cube."""


@dataclass
class ColdStart:
    """Local minima without a start, and what the relaxation of the general form proves.

    Attributes:
        minima: of the descents, none without any point.
        bound: lower bound of the objective, in the problem's units.
        infeasible: whether there is no consistent point, certified.
    """

    minima: list[LocalMinimum]
    bound: float = -np.inf
    infeasible: bool = False


def cold_minima(
    search: ContactSearch, static: tuple[int, ...], controls: FloatArray, seed: int
) -> ColdStart:
    """Local minima below static contacts, the forward problem, and the ends of penalty runs.

    Descents and kicks come first, so that a short limit of time ends with what they find.
    """
    found: dict[tuple[int, ...], LocalMinimum] = {}
    _descend(search, search.visit(static), found)
    if not search.scaled.problem.contact_count or search.spent:
        return ColdStart(list(found.values()))
    if not found:
        known = forward_point(search, controls)
        if known.infeasible:
            return ColdStart([], np.inf, infeasible=True)
        forward = known.forward
        _descend(search, None if forward is None else search.visit(forward[0]), found)
    minima = list(found.values())
    if minima:
        options = search.options
        search.perturb(minima, FIRST_KICKS * options.kicks, FIRST_PATIENCE * options.patience)
    if search.spent:
        return ColdStart(minima)
    found = {minimum.minimiser.modes: minimum for minimum in minima}
    size = _size(search)
    general = _general(search, size)
    start = ColdStart([])
    _relax(search, general, start)
    if not start.infeasible:
        for controls, force in _penalty_points(search, general, size, seed):
            _descend(search, _nearest(search, controls, force), found)
    start.minima = list(found.values())
    return start


def relaxation_bound(search: ContactSearch) -> float:
    """What no consistent point falls short of, by one QP without complementarity.

    It is not asked for without contacts, where the problem is a convex QP.
    """
    return _relaxation(search).bound


@dataclass(frozen=True)
class ForwardPoint:
    """A solution of the forward contact problem, or why there is none.

    Attributes:
        forward: modes and scaled forces (3K,) at given controls; None where none was found.
        infeasible: whether no controls have a consistent point, certified.
    """

    forward: tuple[tuple[int, ...], FloatArray] | None
    infeasible: bool = False


def forward_point(search: ContactSearch, controls: FloatArray) -> ForwardPoint:
    """Forces that obey the contact law at scaled controls.

    Where Lemke's method finds none the relaxation is asked first whether there can be one: block
    Gauss-Seidel takes long to give up.
    """
    scaled, deadline = search.scaled, search.deadline
    found = by_lemke(scaled, controls)
    if found is None and not search.spent:
        if _relaxation(search).infeasible:
            return ForwardPoint(None, infeasible=True)
        found = block_gauss_seidel(scaled, controls, deadline)
    return ForwardPoint(found)


def _relaxation(search: ContactSearch) -> ColdStart:
    general, start = _general(search, _size(search)), ColdStart([])
    _relax(search, general, start)
    search.scaled.qp_count += general.qp_count
    return start


def _general(search: ContactSearch, size: FloatArray) -> ScaledQPCC:
    """The problem in general form, in units of its own."""
    full = to_general(search.scaled.problem, size)
    return ScaledQPCC(full, CertifiedSolver(thorough=False), scales=full.with_own_units())


def _relax(search: ContactSearch, general: ScaledQPCC, start: ColdStart) -> None:
    """Learn a lower bound, or that there is no point, from the QP without complementarity."""
    if search.spent:
        return
    certifier = CertifiedSolver()
    certifier.deadline = search.deadline
    relaxed = general.solve(np.full(len(general.l0), OPEN, np.int8), qp_solver=certifier)
    start.infeasible = relaxed.status is QPStatus.INFEASIBLE
    start.bound = general.value_scale * relaxed.bound + general.problem.c0


def _descend(
    search: ContactSearch,
    minimiser: ModeMinimiser | None,
    found: dict[tuple[int, ...], LocalMinimum],
) -> None:
    if minimiser is not None:
        minimum = search.descend(minimiser)
        found.setdefault(minimum.minimiser.modes, minimum)


def _size(search: ContactSearch) -> FloatArray:
    """Typical sizes of the variables of the general form."""
    scaled = search.scaled
    problem = scaled.problem
    block = np.r_[np.full(len(problem.directions) + 1, scaled.impulse), scaled.speed]
    size: FloatArray = np.r_[scaled.control_scale, np.tile(block, problem.contact_count)]
    return size


def _penalty_points(
    search: ContactSearch, general: ScaledQPCC, size: FloatArray, seed: int
) -> list[tuple[FloatArray, FloatArray]]:
    """Scaled controls and forces (3K,) at which each penalty run ended."""
    scaled, options = search.scaled, search.options
    problem = scaled.problem
    most = min(COLD_QPS, options.max_qps // 2)
    most = search.qp_count + int(most * min(1.0, (MIDDLE / len(size)) ** 3))
    random = np.random.default_rng(seed)
    sides = np.full(len(general.l0), OPEN, np.int8)
    to_z, nu = force_map(problem), problem.control_count
    points = []

    def spent() -> bool:
        scaled.qp_count += general.qp_count
        general.qp_count = 0
        return search.spent

    def over() -> bool:
        return spent() or search.qp_count >= most

    for run in range(options.starts):
        if spent() or search.qp_count >= most:
            break
        schedule = SCHEDULES[run % len(SCHEDULES)]
        start = random_point(general, random, schedule) if run >= len(SCHEDULES) else None
        x = close_pairs(general, start, sides, schedule, over)
        if x is not None:
            z = to_z @ (size * general.variable_scale * x)
            points.append((z[:nu] / scaled.control_scale, z[nu:] / scaled.impulse))
    spent()
    return points


def _nearest(
    search: ContactSearch, controls: FloatArray, force: FloatArray
) -> ModeMinimiser | None:
    """The minimiser on the modes nearest to a point, or on those of the forward problem there."""
    scaled = search.scaled
    violation = scaled.table.violation(scaled.points_at(controls, force))
    modes = tuple(int(mode) for mode in violation.argmin(axis=1))
    minimiser = search.visit(modes)
    if minimiser is None:
        forward = forward_contact(scaled, controls, deadline=search.deadline)
        minimiser = None if forward is None else search.visit(forward[0])
    return minimiser
