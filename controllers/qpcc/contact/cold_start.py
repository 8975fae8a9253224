"""Local minima of a contact QPCC from penalty runs on its general form, where no start is given."""

from __future__ import annotations

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.qp.piqp import PIQPSolver
from warp_softbody.controllers.qpcc.contact.complementarity_form import force_map, to_general
from warp_softbody.controllers.qpcc.contact.forward_lcp import forward_contact
from warp_softbody.controllers.qpcc.contact.local_search import ContactSearch, LocalMinimum
from warp_softbody.controllers.qpcc.contact.mode_minimiser import ModeMinimiser
from warp_softbody.controllers.qpcc.general.penalty import SCHEDULES, close_pairs
from warp_softbody.controllers.qpcc.general.piece_qp import ScaledQPCC
from warp_softbody.controllers.qpcc.general.piece_solution import OPEN
from warp_softbody.controllers.qpcc.general.restarts import random_point

COLD_SHARE = 0.5
"""Share of the budget of QPs after which no penalty run begins: the rest is for kicks."""


def cold_minima(search: ContactSearch, static: tuple[int, ...], seed: int) -> list[LocalMinimum]:
    """Local minima below static contacts and the ends of penalty runs; none without any point."""
    found: dict[tuple[int, ...], LocalMinimum] = {}
    _descend(search, search.visit(static), found)
    if search.scaled.problem.contact_count:
        for controls, force in _penalty_points(search, seed):
            _descend(search, _nearest(search, controls, force), found)
    return list(found.values())


def _descend(
    search: ContactSearch,
    minimiser: ModeMinimiser | None,
    found: dict[tuple[int, ...], LocalMinimum],
) -> None:
    if minimiser is not None:
        minimum = search.descend(minimiser)
        found.setdefault(minimum.minimiser.modes, minimum)


def _penalty_points(search: ContactSearch, seed: int) -> list[tuple[FloatArray, FloatArray]]:
    """Scaled controls and forces (3K,) at which each penalty run ended."""
    scaled, options = search.scaled, search.options
    problem = scaled.problem
    directions = len(problem.directions)
    block = np.r_[np.full(directions + 1, scaled.impulse), scaled.speed]
    size = np.r_[scaled.control_scale, np.tile(block, problem.contact_count)]
    general = ScaledQPCC(to_general(problem, size), PIQPSolver())
    random = np.random.default_rng(seed)
    sides = np.full(len(general.l0), OPEN, np.int8)
    to_z, nu = force_map(problem), problem.control_count
    points = []

    def spent() -> bool:
        scaled.qp_count += general.qp_count
        general.qp_count = 0
        return search.spent

    for run in range(options.starts):
        if spent() or search.qp_count > COLD_SHARE * options.max_qps:
            break
        schedule = SCHEDULES[run % len(SCHEDULES)]
        start = random_point(general, random, schedule) if run >= len(SCHEDULES) else None
        x = close_pairs(general, start, sides, schedule, spent)
        if x is not None:
            z = to_z @ (size * x)
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
        forward = forward_contact(scaled, controls)
        minimiser = None if forward is None else search.visit(forward[0])
    return minimiser
