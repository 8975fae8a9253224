"""Starts, restarts and perturbations of the local search of a general QPCC."""

from __future__ import annotations

import itertools

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.qp.problem import QPStatus
from warp_softbody.controllers.qpcc.general.penalty import (
    REPAIR,
    SCHEDULES,
    SEEKING,
    PenaltySchedule,
    close_pairs,
    solve_with_proximal_term,
)
from warp_softbody.controllers.qpcc.general.piece_qp import ScaledQPCC
from warp_softbody.controllers.qpcc.general.piece_solution import (
    LEFT,
    OPEN,
    RIGHT,
    PieceSolution,
    Sides,
)
from warp_softbody.controllers.qpcc.general.search import TOUCHING, GeneralSearch


def initialize(search: GeneralSearch, start: FloatArray | None, sides: Sides | None) -> None:
    """Descend from a given point or piece, then from the relaxation's minimiser, rounded.

    The relaxation of all pairs gives a lower bound, and tells of many infeasible problems.
    """
    if start is not None:
        sides = search.general.nearest_sides(start)
    given = None if sides is None else search.visit(sides, center=start)
    if given is not None:
        search.record(given)
    if search.settled or search.spent():
        return
    relaxed = search.relaxed()
    if search.best is not None or search.settled or search.spent():
        return
    if relaxed.status is not QPStatus.SOLVED:
        origin = np.zeros_like(search.general.c)
        relaxed = search.general.solve(search.all_open(), center=origin, proximal=1.0)
    if relaxed.status is QPStatus.SOLVED:
        rounded = search.visit(search.general.nearest_sides(relaxed.x), center=relaxed.x)
        if rounded is not None:
            search.record(rounded)


def tighten(search: GeneralSearch) -> None:
    """Raise the bound of the relaxation, and descend from its new minimiser, rounded."""
    if search.settled or search.spent():
        return
    found = search.tighten()
    if found is not None and not (search.best is not None and search.is_matched(search.bound)):
        rounded = search.visit(search.general.nearest_sides(found.x), center=found.x)
        if rounded is not None:
            search.record(rounded)


def penalise(search: GeneralSearch, start: FloatArray | None) -> None:
    """Descend from the end of a penalty run, which begins at a point if one is given."""
    if not search.settled and not search.spent():
        _from_point(search, start)


def restart(search: GeneralSearch) -> None:
    """Penalty runs by other schedules, then from random weights of the pairs.

    While no feasible point is known they go on until the budget ends, with heavier weights.
    """
    runs = itertools.count(1)
    while not search.spent() and not search.settled:
        run = next(runs)
        if run > search.options.starts and (search.best is not None or not search.options.starts):
            return
        if search.best is None:
            options = SEEKING[run % len(SEEKING)]
        else:
            options = SCHEDULES[run % len(SCHEDULES)]
        start = (
            random_point(search.general, search.random, options) if run >= len(SCHEDULES) else None
        )
        _from_point(search, start, options)


def perturb(search: GeneralSearch) -> None:
    """Force single pairs of the best piece to their other side, and repair the others (kicks)."""
    tried: set[tuple[bytes, int]] = set()
    for _ in range(search.options.kicks):
        if search.best is None or search.spent() or search.settled:
            return
        base = search.best
        key = base.sides.tobytes()
        order = _kick_order(base)
        pair = next((int(i) for i in order if (key, int(i)) not in tried), None)
        if pair is None:
            return
        tried.add((key, pair))
        sides = base.sides.copy()
        sides[pair] = RIGHT if sides[pair] == LEFT else LEFT
        found = search.visit(sides, center=base.x)
        if found is not None:
            search.record(found)
            continue
        forced = np.full(len(sides), OPEN, np.int8)
        forced[pair] = sides[pair]
        repair(search, forced, base.x, REPAIR)


def repair(
    search: GeneralSearch,
    sides: Sides,
    center: FloatArray | None,
    options: PenaltySchedule = SCHEDULES[0],
) -> PieceSolution | None:
    """Close the open pairs by the penalty method from ``center``, then descend."""
    x = close_pairs(search.general, center, sides, options, search.spent)
    if x is None:
        return None
    chosen = search.general.nearest_sides(x)
    piece = search.visit(np.where(sides == OPEN, chosen, sides).astype(np.int8), center=x)
    if piece is None:
        piece = _close_one_by_one(search, x, sides)
    return None if piece is None else search.record(piece)


def _close_one_by_one(search: GeneralSearch, x: FloatArray, sides: Sides) -> PieceSolution | None:
    """The piece of the pairs whose sides are clear at x, the other pairs closed one by one."""
    left, right = search.general.sides_at(x)
    chosen = search.general.nearest_sides(x)
    unclear = np.flatnonzero((np.maximum(left, right) <= 1e-3) & (sides == OPEN))
    trial = np.where(sides == OPEN, chosen, sides).astype(np.int8)
    trial[unclear] = OPEN
    while not search.spent():
        piece = search.general.solve(trial, center=x)
        if piece.status is not QPStatus.SOLVED:
            return None
        x = piece.x
        left, right = piece.left, piece.right
        open_pairs = np.flatnonzero(trial == OPEN)
        if open_pairs.size == 0:
            return piece
        gap = np.minimum(left, right)[open_pairs]
        settled = open_pairs[gap <= TOUCHING]
        chosen = search.general.nearest_sides(x)
        if settled.size == 0:
            settled = open_pairs[[int(np.argmin(gap))]]
        trial[settled] = chosen[settled]
    return None


def _from_point(
    search: GeneralSearch, start: FloatArray | None, options: PenaltySchedule = SCHEDULES[0]
) -> PieceSolution | None:
    return repair(search, search.all_open(), start, options)


def _kick_order(piece: PieceSolution) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
    """Pairs in the order of what freeing their zero side gains at first order."""
    slope = np.where(piece.sides == LEFT, piece.left_multiplier, piece.right_multiplier)
    return np.argsort(slope, kind="stable")


def random_point(
    general: ScaledQPCC, random: np.random.Generator, options: PenaltySchedule
) -> FloatArray | None:
    """The minimiser of the objective plus random multiples of all sides, on the relaxation."""
    count = len(general.l0)
    on_left, on_right = options.first * random.uniform(0.1, 1.0, size=(2, count))
    linear = on_left @ general.L + on_right @ general.R
    piece = solve_with_proximal_term(general, np.full(count, OPEN, np.int8), linear=linear)
    return None if piece is None else piece.x
