"""The local search over the pieces of a general QPCC (docs/qpcc.md): its memory and its descent."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.qp.problem import QPStatus
from warp_softbody.controllers.qpcc.general.piece_qp import ScaledQPCC
from warp_softbody.controllers.qpcc.general.piece_solution import LEFT, RIGHT, PieceSolution, Sides
from warp_softbody.controllers.qpcc.result import SolverOptions

TOUCHING = 1e-7
"""Scaled value of both sides up to which a pair counts as biactive: both its pieces touch there."""

SLOPE_NOISE = 1e-7
"""Multipliers above minus this count as nonnegative."""

PROGRESS = 1e-9
"""Least relative decrease of the objective that counts as progress."""


@dataclass
class SearchStatus:
    """What is known of the best point.

    Attributes:
        stationary: it is strongly stationary: no multiplier of a biactive pair is negative.
        complete: its descent was not cut off by the budget.
        certified: it is a global minimum, by branch and bound.
        unbounded: on some feasible piece the objective falls without end.
        infeasible: no piece has a point.
    """

    stationary: bool = False
    complete: bool = True
    certified: bool = False
    unbounded: bool = False
    infeasible: bool = False


class GeneralSearch:
    """One solve: the best piece so far, the pieces tried, and what is left of the budget."""

    def __init__(self, general: ScaledQPCC, options: SolverOptions, seed: int) -> None:
        """Start the clock."""
        self.general = general
        self.options = options
        self.started = time.perf_counter()
        self.random = np.random.default_rng(seed)
        self.best: PieceSolution | None = None
        self.status = SearchStatus()
        self._known: dict[bytes, PieceSolution | None] = {}

    def spent(self) -> bool:
        """Whether the budget of QPs or time is used up."""
        late = time.perf_counter() - self.started >= self.options.time_limit
        return self.general.qp_count >= self.options.max_qps or late

    def visit(self, sides: Sides, center: FloatArray | None = None) -> PieceSolution | None:
        """Solve the QP of a piece once; None if it has no solution or the budget is used up."""
        key = sides.tobytes()
        if key not in self._known:
            if self.spent():
                return None
            piece = self.general.solve(sides, center=center)
            if piece.status is QPStatus.UNBOUNDED and not self.status.unbounded:
                self.find_descent_ray(sides)
            self._known[key] = piece if piece.status is QPStatus.SOLVED else None
        return self._known[key]

    @property
    def settled(self) -> bool:
        """Whether nothing is left to look for."""
        return self.status.certified or self.status.infeasible or self.status.unbounded

    def descend(self, piece: PieceSolution) -> tuple[PieceSolution, bool]:
        """Move to adjacent pieces while the objective falls.

        All biactive pairs with a negative multiplier change sides at once; where that gains
        nothing, one after another. Also whether the last point is strongly stationary.
        """
        while True:
            candidates = self._descent_pairs(piece)
            if candidates.size == 0:
                return piece, True
            following = self._visit_adjacent(piece, candidates)
            if following is None:
                for pair in candidates if candidates.size > 1 else ():
                    following = self._visit_adjacent(piece, np.array([pair]))
                    if following is not None or self.spent():
                        break
            if following is None:
                return piece, False
            piece = following

    def record(self, piece: PieceSolution) -> PieceSolution:
        """Descend from a piece, and keep where that ended if it is the best."""
        found, stationary = self.descend(piece)
        if self.best is None or found.value < self.best.value - self.margin(self.best):
            self.best, self.status.stationary = found, stationary
            self.status.complete = stationary or not self.spent()
        return found

    def margin(self, piece: PieceSolution) -> float:
        """The decrease that is progress and not rounding."""
        return PROGRESS * abs(piece.value) + 1e-13

    def _descent_pairs(self, piece: PieceSolution) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
        """The biactive pairs with a negative multiplier, the most negative first."""
        zero_left = piece.sides == LEFT
        slope = np.where(zero_left, piece.left_multiplier, piece.right_multiplier)
        other = np.where(zero_left, piece.right, piece.left)
        candidates = np.flatnonzero((slope < -SLOPE_NOISE) & (other <= TOUCHING))
        order = np.argsort(slope[candidates], kind="stable")
        return candidates[order]

    def _visit_adjacent(
        self, piece: PieceSolution, pairs: np.ndarray[tuple[int], np.dtype[np.intp]]
    ) -> PieceSolution | None:
        sides = piece.sides.copy()
        sides[pairs] = np.where(sides[pairs] == LEFT, RIGHT, LEFT)
        found = self.visit(sides, center=piece.x)
        if found is None or found.value >= piece.value - self.margin(piece):
            return None
        return found

    def find_descent_ray(self, sides: Sides) -> None:
        """Mark the problem unbounded where a piece has both a point and a ray of descent."""
        point = self.general.solve(sides, center=np.zeros_like(self.general.c), proximal=1.0)
        if point.status is QPStatus.SOLVED and self.general.unbounded_below(sides):
            self.status.unbounded = True
            self.best = replace(point, value=-np.inf)
