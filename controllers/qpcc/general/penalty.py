"""Sequential convex programming on the complementarity product.

The merit is ``f(x) + rho sum_i w_i left_i(x) right_i(x)`` over the relaxation (both sides
nonnegative). Each step minimises f plus the product linearised at the present point, then goes the
exactly best way towards that minimiser (the merit is quadratic along it); rho grows where a step
gains nothing. Forcing some pairs' sides turns the same method into a repair of those choices.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.qp.problem import QPStatus
from warp_softbody.controllers.qpcc.general.piece_qp import (
    UNBOUNDED_PULL,
    GeneralProblem,
    Piece,
    Sides,
)

CLOSED = 1e-7
"""Scaled sum of products below which every pair counts as closed."""


@dataclass(frozen=True, kw_only=True)
class PenaltyOptions:
    """How the weight of the product grows.

    Attributes:
        first: weight of the product in the first step, on the scale of the objective.
        growth: factor where a step gains little.
        patience: relative predicted decrease of the merit below which that is so.
        last: growth in all after which the method gives up.
        most_qps: QPs in one run.
    """

    first: float = 1e-2
    growth: float = 2.0
    patience: float = 0.1
    last: float = 1e5
    most_qps: int = 40


SCHEDULES = (
    PenaltyOptions(),
    PenaltyOptions(growth=4.0),
    PenaltyOptions(first=1e-3, patience=0.03),
    PenaltyOptions(first=1e-1),
)
"""Penalty schedules from the relaxation, one a start; on hard problems each ends elsewhere."""

SEEKING = tuple(PenaltyOptions(first=first, growth=4.0) for first in (1.0, 10.0, 100.0))
"""Schedules while no point is known: the pairs first, the objective later."""

KICK = PenaltyOptions(first=0.1, growth=4.0, most_qps=20)
"""Schedule of the repair after a pair was forced to its other side."""


def close_pairs(
    general: GeneralProblem,
    start: FloatArray | None,
    sides: Sides,
    options: PenaltyOptions,
    spent: Callable[[], bool],
) -> FloatArray | None:
    """A point at which most pairs are closed; None where the relaxation fails.

    Args:
        general: the problem.
        start: first point, which need not be feasible; default the relaxation's minimiser.
        sides: pairs forced from the beginning, the others OPEN.
        options: schedule.
        spent: whether the budget is used up.
    """
    x = start
    if x is None:
        relaxed = solve_bounded(general, sides)
        if relaxed is None:
            return None
        x = relaxed.x
    weight = options.first
    for _ in range(options.most_qps):
        left, right = (np.maximum(side, 0.0) for side in general.sides_at(x))
        product = float(left @ right)
        if product <= CLOSED or spent() or weight > options.last * options.first:
            return x
        slope = weight * (right @ general.L + left @ general.R)
        step = solve_bounded(general, sides, linear=slope, near=x)
        if step is None:
            return None
        way = step.x - x
        falling = float((general.Q @ x + general.c + slope) @ way)
        bend = 0.5 * float(way @ (general.Q @ way))
        bend += weight * float((general.L @ way) @ (general.R @ way))
        length = 1.0 if bend <= 0.0 else min(1.0, -falling / (2.0 * bend))
        if falling > -options.patience * (abs(general.value(x)) + weight * product):
            weight *= options.growth
        if length > 0.0:
            x = x + length * way
    return x


def solve_bounded(
    general: GeneralProblem,
    sides: Sides,
    *,
    linear: FloatArray | None = None,
    near: FloatArray | None = None,
) -> Piece | None:
    """Solve, held back towards ``near`` where the QP alone is unbounded; None where it fails."""
    piece = general.solve(sides, linear=linear, near=near)
    if piece.status in (QPStatus.UNBOUNDED, QPStatus.UNSOLVED):
        at = np.zeros_like(general.c) if near is None else near
        piece = general.solve(sides, linear=linear, near=at, pull=UNBOUNDED_PULL)
    return piece if piece.status is QPStatus.SOLVED else None
