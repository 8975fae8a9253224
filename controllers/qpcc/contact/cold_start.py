"""Local minima of a contact QPCC from penalty runs on its general form, where no start is given."""

from __future__ import annotations

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.qp.piqp import PIQPSolver
from warp_softbody.controllers.qpcc.contact.complementarity_form import force_map, to_general
from warp_softbody.controllers.qpcc.contact.forward_lcp import forward_contact
from warp_softbody.controllers.qpcc.contact.local_search import LocalMinimum, Search
from warp_softbody.controllers.qpcc.contact.mode_qp import Node
from warp_softbody.controllers.qpcc.general.penalty import SCHEDULES, close_pairs
from warp_softbody.controllers.qpcc.general.piece_qp import OPEN, ScaledQPCC
from warp_softbody.controllers.qpcc.general.restarts import random_point

COLD_SHARE = 0.5
"""Share of the budget after which no further penalty run starts: the kicks need the rest."""


def cold_minima(search: Search, static: tuple[int, ...], seed: int) -> list[LocalMinimum]:
    """Descents from static contacts and from the ends of penalty runs; none without a point."""
    found: dict[tuple[int, ...], LocalMinimum] = {}
    _descend(search, search.visit(static), found)
    if search.reduced.problem.contact_count:
        for controls_there, force in _penalty_points(search, seed):
            _descend(search, _nearest(search, controls_there, force), found)
    return list(found.values())


def _descend(search: Search, node: Node | None, found: dict[tuple[int, ...], LocalMinimum]) -> None:
    if node is not None:
        minimum = search.descend(node)
        found.setdefault(minimum.node.modes, minimum)


def _penalty_points(search: Search, seed: int) -> list[tuple[FloatArray, FloatArray]]:
    """Scaled controls and forces (3K,) at which each penalty run ended."""
    reduced, options = search.reduced, search.options
    problem = reduced.problem
    directions = len(problem.directions)
    block = np.r_[np.full(directions + 1, reduced.impulse), reduced.speed]
    size = np.r_[reduced.control_scale, np.tile(block, problem.contact_count)]
    general = ScaledQPCC(to_general(problem, size), PIQPSolver())
    random = np.random.default_rng(seed)
    sides = np.full(len(general.l0), OPEN, np.int8)
    to_z, nu = force_map(problem), problem.control_count
    points = []

    def spent() -> bool:
        reduced.qp_count += general.qp_count
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
            points.append((z[:nu] / reduced.control_scale, z[nu:] / reduced.impulse))
    spent()
    return points


def _nearest(search: Search, controls: FloatArray, force: FloatArray) -> Node | None:
    """The node of the pieces nearest to a point, else of the forward problem at its controls."""
    reduced = search.reduced
    violation = reduced.table.violation(reduced.points_at(controls, force))
    modes = tuple(int(mode) for mode in violation.argmin(axis=1))
    node = search.visit(modes)
    if node is None:
        forward = forward_contact(reduced, controls)
        node = None if forward is None else search.visit(forward[0])
    return node
