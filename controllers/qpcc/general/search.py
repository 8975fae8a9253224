"""The local search over the pieces of a general QPCC (docs/qpcc.md): its memory and its descent."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.qp.certified import CertifiedSolver
from warp_softbody.controllers.qp.problem import QPStatus
from warp_softbody.controllers.qpcc.general.convex_reformulation import reformulate
from warp_softbody.controllers.qpcc.general.piece_qp import Relaxation, ScaledQPCC
from warp_softbody.controllers.qpcc.general.piece_solution import (
    LEFT,
    OPEN,
    RIGHT,
    PieceSolution,
    Sides,
)
from warp_softbody.controllers.qpcc.general.saddles import leave_saddle
from warp_softbody.controllers.qpcc.result import SolverOptions

TOUCHING = 1e-7
"""Scaled value of both sides up to which a pair counts as biactive: both its pieces touch there."""

SLOPE_NOISE = 1e-7
"""Multipliers above minus this count as nonnegative."""

PROGRESS = 1e-9
"""Least relative decrease of the objective that counts as progress."""

MATCHED = 1e-8
"""Distance of a bound that counts as none, relative to the sum of the objective's terms."""

LEAST = 1e-9
"""The same where these are small: the accuracy of a QP's value."""

FIRST_TOLERANCE = 1e-9
"""Of the QPs: asked for more, an interior point method calls some that have a point infeasible."""


@dataclass
class SearchStatus:
    """What is known of the best point.

    Attributes:
        stationary: it is strongly stationary: no multiplier of a biactive pair is negative.
        complete: its descent was not cut off by the budget.
        certified: it is a global minimum, by branch and bound.
        unbounded: on some feasible piece the objective falls without end, along ``ray``.
        infeasible: no piece has a point.
    """

    stationary: bool = False
    complete: bool = True
    certified: bool = False
    unbounded: bool = False
    infeasible: bool = False
    ray: FloatArray | None = None


class GeneralSearch:
    """One solve: the best piece so far, the pieces tried, and what is left of the budget."""

    def __init__(
        self, general: ScaledQPCC, options: SolverOptions, seed: int, started: float
    ) -> None:
        """Begin at a time on ``time.perf_counter``."""
        self.general = general
        self.options = options
        self.started = started
        self.certifier = CertifiedSolver(FIRST_TOLERANCE)
        self.certifier.deadline = started + options.time_limit
        self.random = np.random.default_rng(seed)
        self.best: PieceSolution | None = None
        self.bound = -np.inf
        self.status = SearchStatus()
        self._known: dict[bytes, PieceSolution | None] = {}
        self.relaxation: Relaxation | None = None
        self._relaxed: PieceSolution | None = None
        self._tightest: PieceSolution | None = None

    def spent(self) -> bool:
        """Whether the budget of QPs or time is used up."""
        late = time.perf_counter() - self.started >= self.options.time_limit
        return self.general.qp_count >= self.options.max_qps or late

    def all_open(self) -> Sides:
        """The relaxation of all pairs."""
        return np.full(len(self.general.l0), OPEN, np.int8)

    def relaxed(self) -> PieceSolution:
        """The QP in which all pairs are open, solved once and certified: bound or infeasibility."""
        if self._relaxed is None:
            self._relaxed = self.general.solve(self.all_open(), qp_solver=self.certifier)
            self.status.infeasible = self._relaxed.status is QPStatus.INFEASIBLE
            self.raise_bound(self._relaxed.bound)
        return self._relaxed

    def node(self, sides: Sides) -> PieceSolution:
        """The certified QP of a node; where pairs are open, with the objective of higher bounds."""
        if not np.any(sides == OPEN):
            return self.general.solve(sides, qp_solver=self.certifier)
        if np.all(sides == OPEN):
            return self._tightest or self.relaxed()
        if self.relaxation is None:
            return self.general.solve(sides, qp_solver=self.certifier)
        return self.general.relax(sides, self.relaxation, self.certifier)

    def tighten(self) -> PieceSolution | None:
        """Look for an objective with a higher bound; the minimiser where there is one."""
        relaxed = self.relaxed()
        if relaxed.status is not QPStatus.SOLVED or self.general.concave_part is not None:
            return None
        found = reformulate(self.general, relaxed, self._relax_all)
        if found is not None:
            self.relaxation, self._tightest = found
            self.raise_bound(self._tightest.bound)
        return self._tightest

    def _relax_all(self, relaxation: Relaxation) -> PieceSolution | None:
        if self.spent():
            return None
        return self.general.relax(self.all_open(), relaxation, self.certifier)

    def raise_bound(self, bound: float) -> None:
        """Learn a lower bound of the scaled objective."""
        self.bound = max(self.bound, bound)

    def is_matched(self, bound: float) -> bool:
        """Whether the best point is as low as a bound, to the accuracy of the QPs."""
        best = self.best
        if best is None:
            return False
        size = np.abs(best.x)
        terms = float(size @ (0.5 * (np.abs(self.general.Q) @ size) + np.abs(self.general.c)))
        return bound >= best.value - MATCHED * terms - LEAST

    def visit(self, sides: Sides, center: FloatArray | None = None) -> PieceSolution | None:
        """Solve the QP of a piece once; None if it has no solution or the budget is used up."""
        key = sides.tobytes()
        if key not in self._known:
            if self.spent():
                return None
            piece = self.general.solve(sides, center=center)
            doubtful = piece.status is QPStatus.UNSOLVED and self.general.concave_part is not None
            falls = doubtful or piece.status is QPStatus.UNBOUNDED
            if falls and not self.status.unbounded:
                self.find_descent_ray(sides, center)
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
        if self.general.concave_part is not None:
            found, certain = self._descend_along_curvature(found)
            stationary = stationary and certain
        lower = self.best is None or found.value < self.best.value - self.margin(self.best)
        if lower and not self.status.unbounded:
            self.best, self.status.stationary = found, stationary
            self.status.complete = stationary or not self.spent()
        return found

    def _descend_along_curvature(self, piece: PieceSolution) -> tuple[PieceSolution, bool]:
        """Leave saddles while that lowers the objective; whether the last point is surely none."""
        while not self.spent():
            found = leave_saddle(self.general, piece, self.visit)
            if found.ray is not None and found.base is not None:
                self.status.unbounded, self.status.ray = True, found.ray
                self.best = replace(found.base, value=-np.inf)
            lower = found.lower
            if lower is None or lower.value >= piece.value - self.margin(piece):
                return piece, found.certain
            piece, _ = self.descend(lower)
        return piece, False

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

    def find_descent_ray(self, sides: Sides, center: FloatArray | None = None) -> None:
        """Mark the problem unbounded where a piece has both a point and a ray of descent."""
        left = self.options.time_limit - (time.perf_counter() - self.started)
        ray = self.general.falling_ray(sides, left, center)
        if ray is not None:
            self.fall(sides, ray)

    def fall(self, sides: Sides, ray: FloatArray) -> None:
        """Mark the problem unbounded along a ray of a piece, if that has a point."""
        point = self.general.solve(sides, center=np.zeros_like(self.general.c), proximal=1.0)
        if point.status is QPStatus.SOLVED:
            self.status.unbounded, self.status.ray = True, ray
            self.best = replace(point, value=-np.inf)
