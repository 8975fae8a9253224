"""Branch and bound over the sides of the pairs: a certified global minimum where it ends in time.

A node fixes the sides of some pairs; its bound is the minimum of the convex QP in which the other
pairs are relaxed.
"""

from __future__ import annotations

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

SAME = 1e-7
"""Relative difference up to which a feasible point attains the bound of its node."""


def branch_and_bound(search: GeneralSearch, limit: int) -> None:
    """Depth first; branches on the pair that is violated most, its nearer side first.

    Certifies the search's best point, or infeasibility, if every node was fathomed within ``limit``
    QPs. A leaf whose QP was not solved leaves the problem undecided.
    """
    general = search.general
    if general.concave_part is not None:
        return
    stack: list[Sides] = [np.full(len(general.l0), OPEN, np.int8)]
    end, sure = general.qp_count + limit, True
    while stack:
        if search.spent() or general.qp_count >= end or search.status.unbounded:
            return
        piece = general.solve(stack.pop())
        if piece.status is QPStatus.INFEASIBLE or _is_fathomed(search, piece):
            continue
        if np.any(piece.sides == OPEN):
            stack.extend(_branch(search, piece))
            continue
        sure = False
        if piece.status is QPStatus.UNBOUNDED:
            search.find_descent_ray(piece.sides)
    search.status.certified = sure and search.best is not None
    search.status.infeasible = sure and search.best is None


def _is_fathomed(search: GeneralSearch, piece: PieceSolution) -> bool:
    """Whether no point of a solved node is better than the best one known.

    That is so if its bound is no lower, or if a feasible point attains the bound.
    """
    if piece.status is not QPStatus.SOLVED:
        return False
    if search.best is not None and piece.value >= search.best.value - search.margin(search.best):
        return True
    if _violation(piece).max(initial=0.0) > TOUCHING:
        return False
    closed = np.where(piece.sides == OPEN, search.general.nearest_sides(piece.x), piece.sides)
    found = search.visit(closed.astype(np.int8))
    if found is None:
        return False
    search.record(found)
    return found.value <= piece.value + SAME * (1e-3 + abs(piece.value))


def _violation(piece: PieceSolution) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Violation of each open pair; the same for all of them where the QP has no point."""
    if piece.status is not QPStatus.SOLVED:
        return np.where(piece.sides == OPEN, 1.0, 0.0)
    return np.where(piece.sides == OPEN, np.minimum(piece.left, piece.right), -np.inf)


def _branch(search: GeneralSearch, piece: PieceSolution) -> list[Sides]:
    """The two child nodes of the pair that is violated most, the nearer side last."""
    pair, solved = int(np.argmax(_violation(piece))), piece.status is QPStatus.SOLVED
    nearest = int(search.general.nearest_sides(piece.x)[pair]) if solved else LEFT
    children = []
    for side in (RIGHT if nearest == LEFT else LEFT, nearest):
        child = piece.sides.copy()
        child[pair] = side
        children.append(child)
    return children
