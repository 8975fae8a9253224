"""Branch and bound over the sides of a general QPCC's pairs: certifies, where it ends in time."""

from __future__ import annotations

import numpy as np

from warp_softbody.controllers.qp.problem import QPStatus
from warp_softbody.controllers.qpcc.general.piece_qp import LEFT, OPEN, RIGHT, Piece, Sides
from warp_softbody.controllers.qpcc.general.search import TOUCHING, GeneralSearch

SAME = 1e-7
"""Relative difference at which a closed point counts as its relaxation's minimum."""


def branch_and_bound(search: GeneralSearch, limit: int) -> None:
    """Depth first, the pair that is furthest open next, its nearer side first.

    Sets the search's verdict if every node was closed within ``limit`` QPs; a QP that was not
    solved and cannot be split leaves the problem undecided.
    """
    general = search.general
    if general.concave_part is not None:
        return
    stack: list[Sides] = [np.full(len(general.l0), OPEN, np.int8)]
    end, sure = general.qp_count + limit, True
    while stack:
        if search.spent() or general.qp_count >= end or search.verdict.unbounded:
            return
        piece = general.solve(stack.pop())
        if piece.status is QPStatus.INFEASIBLE or _finished(search, piece):
            continue
        if np.any(piece.sides == OPEN):
            stack.extend(_children(search, piece))
            continue
        sure = False
        if piece.status is QPStatus.UNBOUNDED:
            search.look_for_a_ray(piece.sides)
    search.verdict.certified = sure and search.best is not None
    search.verdict.infeasible = sure and search.best is None


def _finished(search: GeneralSearch, piece: Piece) -> bool:
    """Whether a solved node cannot hold a better point than the best one."""
    if piece.status is not QPStatus.SOLVED:
        return False
    if search.best is not None and piece.value >= search.best.value - search.margin(search.best):
        return True
    if _gap(piece).max(initial=0.0) > TOUCHING:
        return False
    closed = np.where(piece.sides == OPEN, search.general.nearest_sides(piece.x), piece.sides)
    found = search.visit(closed.astype(np.int8))
    if found is None:
        return False
    search.keep(found)
    return found.value <= piece.value + SAME * (1e-3 + abs(piece.value))


def _gap(piece: Piece) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """How far open each pair is; the same for all open ones where there is no point."""
    if piece.status is not QPStatus.SOLVED:
        return np.where(piece.sides == OPEN, 1.0, 0.0)
    return np.where(piece.sides == OPEN, np.minimum(piece.left, piece.right), -np.inf)


def _children(search: GeneralSearch, piece: Piece) -> list[Sides]:
    """Both sides of the pair that is furthest open, the nearer one last."""
    pair, solved = int(np.argmax(_gap(piece))), piece.status is QPStatus.SOLVED
    nearest = int(search.general.nearest_sides(piece.x)[pair]) if solved else LEFT
    children = []
    for side in (RIGHT if nearest == LEFT else LEFT, nearest):
        child = piece.sides.copy()
        child[pair] = side
        children.append(child)
    return children
