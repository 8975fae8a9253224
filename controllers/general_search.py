"""Local and global search over the pieces of a general QPCC (docs/qpcc.md)."""

from __future__ import annotations

import itertools
import time
from dataclasses import dataclass, replace

import numpy as np

from warp_softbody.controllers.general_pieces import (
    LEFT,
    OPEN,
    RIGHT,
    GeneralProblem,
    Piece,
    Sides,
)
from warp_softbody.controllers.penalty import (
    KICK,
    SCHEDULES,
    SEEKING,
    PenaltyOptions,
    close_pairs,
    solve_bounded,
)
from warp_softbody.controllers.qp import QPStatus
from warp_softbody.controllers.qpcc import FloatArray
from warp_softbody.controllers.result import SolverOptions

TOUCHING = 1e-7
"""Scaled side below which a pair counts as touching its other piece."""

SLOPE_NOISE = 1e-7
"""Multipliers above minus this offer no descent."""

PROGRESS = 1e-9
"""Relative decrease of the objective that counts."""


@dataclass
class Verdict:
    """What is known of the best piece.

    Attributes:
        stationary: no touching pair offers descent by the multipliers.
        certified: no combination of sides has a lower objective.
        unbounded: a piece with points falls without end.
        infeasible: no combination of sides has a point.
        complete: the best piece's descent was not cut off by the budget.
    """

    stationary: bool = False
    complete: bool = True
    certified: bool = False
    unbounded: bool = False
    infeasible: bool = False


class GeneralSearch:
    """One solve: the best piece so far, what was tried, and what is left of the budget."""

    def __init__(self, general: GeneralProblem, options: SolverOptions, seed: int) -> None:
        """Start the clock."""
        self.general = general
        self.options = options
        self.started = time.perf_counter()
        self.random = np.random.default_rng(seed)
        self.best: Piece | None = None
        self.verdict = Verdict()
        self._known: dict[bytes, Piece | None] = {}

    def spent(self) -> bool:
        """Whether the budget of QPs or time is used up."""
        late = time.perf_counter() - self.started >= self.options.time_limit
        return self.general.qp_count >= self.options.max_qps or late

    def visit(self, sides: Sides, near: FloatArray | None = None) -> Piece | None:
        """Solve one piece once; None if it has no solution or the budget is used up."""
        key = sides.tobytes()
        if key not in self._known:
            if self.spent():
                return None
            piece = self.general.solve(sides, near=near)
            if piece.status is QPStatus.UNBOUNDED and not self.verdict.unbounded:
                self.look_for_a_ray(sides)
            self._known[key] = piece if piece.status is QPStatus.SOLVED else None
        return self._known[key]

    def begin(self, start: FloatArray | None, sides: Sides | None) -> None:
        """Descend from a point, from a piece, or from the relaxation."""
        if start is not None:
            sides = self.general.nearest_sides(start)
        root = None if sides is None else self.visit(sides, near=start)
        if root is not None:
            self.keep(root)
        else:
            self._from_point(start)
        if self.best is None and not self.verdict.unbounded and not self.spent():
            relaxed = self.general.solve(np.full(len(self.general.l0), OPEN, np.int8))
            self.verdict.infeasible = relaxed.status is QPStatus.INFEASIBLE

    @property
    def settled(self) -> bool:
        """Whether nothing is left to look for."""
        return self.verdict.certified or self.verdict.infeasible or self.verdict.unbounded

    def descend(self, piece: Piece) -> tuple[Piece, bool]:
        """Flip touching pairs while the objective falls; and whether none offers descent."""
        while True:
            willing = self._willing(piece)
            if willing.size == 0:
                return piece, True
            following = self._better(piece, willing)
            if following is None:
                for pair in willing if willing.size > 1 else ():
                    following = self._better(piece, np.array([pair]))
                    if following is not None or self.spent():
                        break
            if following is None:
                return piece, False
            piece = following

    def repair(
        self, sides: Sides, near: FloatArray | None, options: PenaltyOptions = SCHEDULES[0]
    ) -> Piece | None:
        """Close the open pairs by the penalty method from ``near``, then descend."""
        x = close_pairs(self.general, near, sides, options, self.spent)
        if x is None:
            return None
        chosen = self.general.nearest_sides(x)
        piece = self.visit(np.where(sides == OPEN, chosen, sides).astype(np.int8), near=x)
        if piece is None:
            piece = self._resolve(x, sides)
        return None if piece is None else self.keep(piece)

    def _resolve(self, x: FloatArray, sides: Sides) -> Piece | None:
        """Sides of pairs that are clear at x; the unclear ones closed one after another."""
        left, right = self.general.sides_at(x)
        chosen = self.general.nearest_sides(x)
        unclear = np.flatnonzero((np.maximum(left, right) <= 1e-3) & (sides == OPEN))
        trial = np.where(sides == OPEN, chosen, sides).astype(np.int8)
        trial[unclear] = OPEN
        while not self.spent():
            piece = self.general.solve(trial, near=x)
            if piece.status is not QPStatus.SOLVED:
                return None
            x = piece.x
            left, right = piece.left, piece.right
            open_pairs = np.flatnonzero(trial == OPEN)
            if open_pairs.size == 0:
                return piece
            gap = np.minimum(left, right)[open_pairs]
            settled = open_pairs[gap <= TOUCHING]
            chosen = self.general.nearest_sides(x)
            if settled.size == 0:
                settled = open_pairs[[int(np.argmin(gap))]]
            trial[settled] = chosen[settled]
        return None

    def keep(self, piece: Piece) -> Piece:
        """Descend from a piece, and remember where that ended if it is the best."""
        found, stationary = self.descend(piece)
        if self.best is None or found.value < self.best.value - self.margin(self.best):
            self.best, self.verdict.stationary = found, stationary
            self.verdict.complete = stationary or not self.spent()
        return found

    def margin(self, piece: Piece) -> float:
        """Decrease that is progress and not rounding."""
        return PROGRESS * abs(piece.value) + 1e-13

    def _willing(self, piece: Piece) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
        """Pairs whose other piece contains the point and offers descent, the steepest first."""
        zero_left = piece.sides == LEFT
        slope = np.where(zero_left, piece.left_multiplier, piece.right_multiplier)
        other = np.where(zero_left, piece.right, piece.left)
        willing = np.flatnonzero((slope < -SLOPE_NOISE) & (other <= TOUCHING))
        order = np.argsort(slope[willing], kind="stable")
        return willing[order]

    def _better(
        self, piece: Piece, pairs: np.ndarray[tuple[int], np.dtype[np.intp]]
    ) -> Piece | None:
        sides = piece.sides.copy()
        sides[pairs] = np.where(sides[pairs] == LEFT, RIGHT, LEFT)
        found = self.visit(sides, near=piece.x)
        if found is None or found.value >= piece.value - self.margin(piece):
            return None
        return found

    def _from_point(
        self, start: FloatArray | None, options: PenaltyOptions = SCHEDULES[0]
    ) -> Piece | None:
        return self.repair(np.full(len(self.general.l0), OPEN, np.int8), start, options)

    def restart(self) -> None:
        """Penalty runs on other schedules, then from random weights of the pairs.

        While no point is known they go on until the budget ends, and with the heavier weights.
        """
        runs = itertools.count(1)
        while not self.spent():
            run = next(runs)
            if run > self.options.starts and (self.best is not None or not self.options.starts):
                return
            if self.best is None:
                options = SEEKING[run % len(SEEKING)]
            else:
                options = SCHEDULES[run % len(SCHEDULES)]
            start = (
                random_point(self.general, self.random, options) if run >= len(SCHEDULES) else None
            )
            self._from_point(start, options)

    def kick(self) -> None:
        """Force single pairs of the best piece to their other side, and repair the rest."""
        tried: set[tuple[bytes, int]] = set()
        for _ in range(self.options.kicks):
            if self.best is None or self.spent():
                return
            base = self.best
            key = base.sides.tobytes()
            order = self._kick_order(base)
            pair = next((int(i) for i in order if (key, int(i)) not in tried), None)
            if pair is None:
                return
            tried.add((key, pair))
            sides = base.sides.copy()
            sides[pair] = RIGHT if sides[pair] == LEFT else LEFT
            found = self.visit(sides, near=base.x)
            if found is not None:
                self.keep(found)
                continue
            forced = np.full(len(sides), OPEN, np.int8)
            forced[pair] = sides[pair]
            self.repair(forced, base.x, KICK)

    def _kick_order(self, piece: Piece) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
        """Pairs by what freeing their zero side would gain at first order."""
        slope = np.where(piece.sides == LEFT, piece.left_multiplier, piece.right_multiplier)
        return np.argsort(slope, kind="stable")

    def look_for_a_ray(self, sides: Sides) -> None:
        """A piece that has a point and a falling ray makes the problem unbounded."""
        point = self.general.solve(sides, near=np.zeros_like(self.general.c), pull=1.0)
        if point.status is QPStatus.SOLVED and self.general.unbounded_below(sides):
            self.verdict.unbounded = True
            self.best = replace(point, value=-np.inf)


def random_point(
    general: GeneralProblem, random: np.random.Generator, options: PenaltyOptions
) -> FloatArray | None:
    """Where the objective plus random multiples of all sides is least."""
    count = len(general.l0)
    on_left, on_right = options.first * random.uniform(0.1, 1.0, size=(2, count))
    linear = on_left @ general.L + on_right @ general.R
    piece = solve_bounded(general, np.full(count, OPEN, np.int8), linear=linear)
    return None if piece is None else piece.x
