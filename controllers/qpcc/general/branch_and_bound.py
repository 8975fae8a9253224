"""Branch and bound over the sides of the pairs: a lower bound, and a certificate where it ends.

A node fixes the sides of some pairs; its bound is that of the convex QP in which the other pairs
are relaxed. The search dives to the nearer side of the pair that is violated most; where a dive
ends it goes on at the open node with the lowest bound, which is a lower bound of the problem.
"""

from __future__ import annotations

import heapq
import itertools
import logging

import numpy as np

from warp_softbody.controllers.qp.problem import QPStatus
from warp_softbody.controllers.qpcc.general.piece_solution import (
    LEFT,
    OPEN,
    RIGHT,
    PieceSolution,
    Sides,
)
from warp_softbody.controllers.qpcc.general.search import TOUCHING, GeneralSearch

LOGGER = logging.getLogger("warp_softbody.qpcc")

REPORT = 100
"""Nodes from one line of the log to the next."""

Node = tuple[float, int, Sides]
"""Bound, order of its making, sides."""


class BranchAndBound:
    """The tree of one search, which can be left and taken up again."""

    def __init__(self, search: GeneralSearch) -> None:
        """One node: all pairs open."""
        self._search = search
        self._order = itertools.count()
        self._open: list[Node] = [self._node(-np.inf, search.all_open())]
        self._dive: Node | None = None
        self._undecided = np.inf
        self._nodes = 0

    @property
    def bound(self) -> float:
        """Lower bound of the scaled objective over all that is left and all that was found."""
        left = self._dive[0] if self._dive is not None else np.inf
        least = min(left, self._undecided, self._open[0][0] if self._open else np.inf)
        best = self._search.best
        return least if best is None else min(least, best.value)

    def run(self, limit: int) -> None:
        """Go on for at most ``limit`` QPs; certify the best point, or that there is none."""
        search = self._search
        if search.general.concave_part is not None:
            return
        end = search.general.qp_count + limit
        while not search.settled:
            node = self._next()
            if node is None:
                self._conclude()
                break
            if search.spent() or search.general.qp_count >= end:
                self._dive = node
                break
            self._examine(node)
            if self._nodes % REPORT == 0:
                self._report()
        search.raise_bound(self.bound)

    def _node(self, bound: float, sides: Sides) -> Node:
        return bound, next(self._order), sides

    def _next(self) -> Node | None:
        """The node of the dive, or the open one with the lowest bound."""
        node, self._dive = self._dive, None
        while node is None and self._open:
            candidate = heapq.heappop(self._open)
            if not self._search.is_matched(candidate[0]):
                node = candidate
            else:
                # every other open node is no better
                self._undecided = min(self._undecided, candidate[0])
                self._open.clear()
        return node

    def _examine(self, node: Node) -> None:
        """Solve a node's QP; leave it, or branch and dive on."""
        search = self._search
        self._nodes += 1
        piece = search.node(node[2])
        if piece.status is QPStatus.INFEASIBLE:
            return
        bound = max(node[0], piece.bound)
        if piece.status is QPStatus.SOLVED:
            if search.is_matched(bound):
                self._undecided = min(self._undecided, bound)
                return
            if self._attained(piece, bound):
                return
        if np.any(node[2] == OPEN):
            self._branch(piece, bound)
        elif piece.status is QPStatus.UNBOUNDED:
            search.find_descent_ray(node[2])
            self._undecided = -np.inf
        elif piece.status is not QPStatus.SOLVED:
            self._undecided = min(self._undecided, bound)
        else:
            # a leaf: its own point is as good as its bound but for the QP's accuracy
            search.record(piece)
            self._undecided = min(self._undecided, bound)

    def _attained(self, piece: PieceSolution, bound: float) -> bool:
        """Whether a feasible point attains the node's bound."""
        search = self._search
        if _violation(piece).max(initial=0.0) > TOUCHING or not np.any(piece.sides == OPEN):
            return False
        closed = np.where(piece.sides == OPEN, search.general.nearest_sides(piece.x), piece.sides)
        found = search.visit(closed.astype(np.int8))
        if found is None:
            return False
        search.record(found)
        if not search.is_matched(bound):
            return False
        self._undecided = min(self._undecided, bound)
        return True

    def _branch(self, piece: PieceSolution, bound: float) -> None:
        """Dive to the nearer side of the pair that is violated most; keep the other for later."""
        pair, solved = int(np.argmax(_violation(piece))), piece.status is QPStatus.SOLVED
        nearest = int(self._search.general.nearest_sides(piece.x)[pair]) if solved else LEFT
        for side in (RIGHT if nearest == LEFT else LEFT, nearest):
            child = piece.sides.copy()
            child[pair] = side
            node = self._node(bound, child)
            if side == nearest:
                self._dive = node
            else:
                heapq.heappush(self._open, node)

    def _conclude(self) -> None:
        """All nodes are done: what that proves."""
        search = self._search
        if search.best is None:
            search.status.infeasible = self._undecided == np.inf
        else:
            search.status.certified = search.is_matched(self._undecided)
        self._report()

    def _report(self) -> None:
        best = self._search.best
        LOGGER.info(
            "branch and bound: %d nodes, %d open, best %s, bound %s (scaled)",
            *(self._nodes, len(self._open), None if best is None else best.value, self.bound),
        )


def _violation(piece: PieceSolution) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Violation of each open pair; the same for all of them where the QP has no point."""
    if piece.status is not QPStatus.SOLVED:
        return np.where(piece.sides == OPEN, 1.0, 0.0)
    return np.where(piece.sides == OPEN, np.minimum(piece.left, piece.right), -np.inf)
