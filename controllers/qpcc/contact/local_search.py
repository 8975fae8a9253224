"""Search over contact modes (docs/method.md section 5): descent by flips, then best-first kicks.

A node is the minimiser over one choice of modes. Its multipliers say, for every contact and every
other piece that contains the point, whether that piece offers descent (``Node.slopes``); if none
does, the point is strongly stationary and, the problem being convex on every piece, a local
minimum.
"""

from __future__ import annotations

import heapq
import itertools
import math
import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.qpcc.contact.force_elimination import ReducedProblem
from warp_softbody.controllers.qpcc.contact.mode_qp import Node
from warp_softbody.controllers.qpcc.result import SolverOptions

TOUCHING = 1e-7
"""Scaled distance within which a point counts as lying in a piece."""

SLOPE_NOISE = 1e-6
"""Slopes above minus this, relative to the largest, offer no descent."""

PROGRESS = 1e-10
"""Relative decrease of the objective that counts."""

ROUNDING = 1e-13
"""Rounding of the objective, relative to its curvature and constant."""


@dataclass(frozen=True)
class LocalMinimum:
    """Where a descent ended.

    Attributes:
        node: the point.
        strongly_stationary: no touching piece offers descent by the multipliers.
        complete: false if the budget ended the descent.
    """

    node: Node
    strongly_stationary: bool
    complete: bool


class Search:
    """One solve's memory: which modes were tried, and what is left of the budget."""

    def __init__(self, reduced: ReducedProblem, options: SolverOptions) -> None:
        """Start the clock."""
        self.reduced = reduced
        self.options = options
        self.started = time.perf_counter()
        self._known: dict[tuple[int, ...], Node | None] = {}
        self._slopes: dict[tuple[int, ...], FloatArray | None] = {}

    @property
    def qp_count(self) -> int:
        """QPs solved."""
        return self.reduced.qp_count

    @property
    def spent(self) -> bool:
        """Whether the budget of QPs or time is used up."""
        late = time.perf_counter() - self.started >= self.options.time_limit
        return self.qp_count >= self.options.max_qps or late

    def visit(self, modes: tuple[int, ...], limit: float = math.inf) -> Node | None:
        """Solve the QP of these modes once; None if infeasible, unsolved or out of budget.

        None too, also for later visits, if it shows early that no value is as low as ``limit``.
        """
        modes = self.reduced.table.canonical(modes)
        if modes not in self._known:
            if self.spent:
                return None
            self._known[modes] = self.reduced.solve(modes, limit)
        return self._known[modes]

    def descend(self, node: Node) -> LocalMinimum:
        """Flip touching contacts while the objective falls: all that offer descent, else one."""
        while True:
            if node.modes not in self._slopes:
                self._slopes[node.modes] = self._touching_slopes(node)
            slopes = self._slopes[node.modes]
            if slopes is None:
                return LocalMinimum(node, True, True)
            willing = slopes.min(axis=1) < 0.0
            batch = np.where(willing, slopes.argmin(axis=1), node.modes)
            following = self._better(node, tuple(batch.tolist()))
            if following is None:
                following = self._single(node, slopes)
            if following is None:
                return LocalMinimum(node, False, not self.spent)
            node = following

    def lowest(self, minima: list[LocalMinimum]) -> LocalMinimum:
        """The best of some minima, the first of those that differ by rounding only."""
        least = min(minimum.node.value for minimum in minima)
        return next(m for m in minima if m.node.value <= least + self._margin(m.node))

    def improve(self, starts: list[LocalMinimum]) -> LocalMinimum:
        """Leave local minima by kicks, the best minimum first, and return the best one found."""
        best = self.lowest(starts)
        if self.options.kicks == 0:
            return best
        order = itertools.count()
        queue = [(m.node.value, next(order), m, self._kicks(m.node)) for m in starts]
        heapq.heapify(queue)
        left, reached = self.options.kicks, {m.node.modes for m in starts}
        fruitless = 0
        while queue and left > 0 and fruitless < self.options.patience and not self.spent:
            value, _, minimum, kicks = heapq.heappop(queue)
            modes = next((m for m in kicks if m not in self._known), None)
            if modes is None:
                continue
            heapq.heappush(queue, (value, next(order), minimum, kicks))
            left -= 1
            fruitless += 1
            node = self.visit(modes, limit=self._within_reach(best.node))
            if node is None:
                continue
            found = self.descend(node)
            if found.node.modes in reached:
                continue
            reached.add(found.node.modes)
            heapq.heappush(queue, (found.node.value, next(order), found, self._kicks(found.node)))
            if found.node.value < best.node.value - self._margin(best.node):
                best, fruitless = found, 0
        return best

    def _within_reach(self, best: Node) -> float:
        """What a kick's first QP may end at."""
        reach = self.options.reach
        return math.inf if reach == math.inf else best.value + reach * abs(best.value)

    def _margin(self, node: Node) -> float:
        """Decrease that is progress and not rounding."""
        noise = self.reduced.value_scale + abs(self.reduced.problem.constant)
        return PROGRESS * abs(node.value) + ROUNDING * noise

    def _better(self, node: Node, modes: tuple[int, ...]) -> Node | None:
        found = self.visit(modes)
        if found is None or found.value >= node.value - self._margin(node):
            return None
        return found

    def _single(self, node: Node, slopes: FloatArray) -> Node | None:
        """The first single flip that improves, the steepest tried first."""
        for flat in np.argsort(slopes, axis=None, kind="stable"):
            contact, mode = divmod(int(flat), slopes.shape[1])
            if slopes[contact, mode] >= 0.0 or self.spent:
                return None
            found = self._better(node, _with(node.modes, contact, mode))
            if found is not None:
                return found
        return None

    def _touching_slopes(self, node: Node) -> FloatArray | None:
        """(K, M): slope of descent into pieces that contain the point; None if there is none."""
        if not node.modes:
            return None
        table = self.reduced.table
        slopes = table.descent(node.slopes)
        largest = float(np.abs(node.slopes).max())
        slopes[np.arange(len(node.modes)), node.modes] = 0.0
        offers = slopes < -SLOPE_NOISE * (1e-3 + largest)
        if not offers.any():
            return None
        offers &= table.violation(node.points) <= TOUCHING
        return np.where(offers, slopes, 0.0) if offers.any() else None

    def _kicks(self, node: Node) -> Iterator[tuple[int, ...]]:
        """Single changes of mode into pieces away from the point, the most promising first.

        The slope along a piece's rays says what the contact would gain by having that freedom at
        all; measured, this order finds four fifths of the best kick's gain in five kicks, the
        order by distance two fifths.
        """
        table = self.reduced.table
        violation, slopes = table.violation(node.points), table.descent(node.slopes)
        away = np.isfinite(violation) & (violation > TOUCHING)
        for flat in np.lexsort((violation.ravel(), np.where(away, slopes, np.inf).ravel())):
            contact, mode = divmod(int(flat), violation.shape[1])
            if not away[contact, mode]:
                return
            yield _with(node.modes, contact, mode)


def _with(modes: tuple[int, ...], contact: int, mode: int) -> tuple[int, ...]:
    return (*modes[:contact], mode, *modes[contact + 1 :])
