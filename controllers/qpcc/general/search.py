"""One search over the pieces of a general QPCC (docs/qpcc.md): its memory and its descent."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.qp.problem import QPStatus
from warp_softbody.controllers.qpcc.general.piece_qp import (
    LEFT,
    RIGHT,
    GeneralProblem,
    Piece,
    Sides,
)
from warp_softbody.controllers.qpcc.result import SolverOptions

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

    def look_for_a_ray(self, sides: Sides) -> None:
        """A piece that has a point and a falling ray makes the problem unbounded."""
        point = self.general.solve(sides, near=np.zeros_like(self.general.c), pull=1.0)
        if point.status is QPStatus.SOLVED and self.general.unbounded_below(sides):
            self.verdict.unbounded = True
            self.best = replace(point, value=-np.inf)
