"""The way down from stationary points of an objective that is not convex."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.qp.problem import QPStatus
from warp_softbody.controllers.qpcc.general.curvature import PULLED, examine_curvature
from warp_softbody.controllers.qpcc.general.piece_qp import ScaledQPCC
from warp_softbody.controllers.qpcc.general.piece_solution import (
    LEFT,
    RIGHT,
    PieceSolution,
    Sides,
)

BIACTIVE = 1e-4
"""Scaled value of both sides up to which the piece beside is tried: generous, as it is solved."""


@dataclass
class SaddleFinding:
    """What is found below a point.

    Attributes:
        lower: a lower point, None without one.
        ray: along which the objective falls for ever, and ``base`` the point where it begins.
        certain: whether no direction of negative curvature is left open.
    """

    lower: PieceSolution | None = None
    ray: FloatArray | None = None
    base: PieceSolution | None = None
    certain: bool = field(default=True)


def leave_saddle(
    general: ScaledQPCC,
    piece: PieceSolution,
    visit: Callable[[Sides, FloatArray], PieceSolution | None],
) -> SaddleFinding:
    """Look along directions that curve down, on a piece and on those that touch it there.

    ``visit`` solves the QP of a piece, from a point on.
    """
    found = _on_one_piece(general, piece)
    certain = found.certain
    for pair in _weak_pairs(piece):
        if found.lower is not None or found.ray is not None:
            break
        sides = piece.sides.copy()
        sides[pair] = RIGHT if sides[pair] == LEFT else LEFT
        beside = visit(sides, piece.x)
        if beside is None:
            continue
        found = _on_one_piece(general, beside)
        certain = certain and found.certain
    found.certain = certain
    return found


def _on_one_piece(general: ScaledQPCC, piece: PieceSolution) -> SaddleFinding:
    free = np.zeros_like(general.c)
    program = general.program(piece.sides, free, free, 0.0)
    known = examine_curvature(general.Q, general.Q @ piece.x + general.c, program, piece)
    if known.ray is not None:
        return SaddleFinding(ray=known.ray, base=piece, certain=False)
    if known.step is None:
        return SaddleFinding(certain=known.certain)
    following = general.solve(piece.sides, center=piece.x + known.step)
    solved = following.status is QPStatus.SOLVED
    return SaddleFinding(lower=following if solved else None, certain=False)


def _weak_pairs(piece: PieceSolution) -> list[int]:
    """Biactive pairs whose other piece offers nothing at first order, but loses nothing."""
    zero_left = piece.sides == LEFT
    slope = np.where(zero_left, piece.left_multiplier, piece.right_multiplier)
    other = np.where(zero_left, piece.right, piece.left)
    weak = (np.abs(slope) <= PULLED) & (other <= BIACTIVE)
    return [int(pair) for pair in np.flatnonzero(weak)]
