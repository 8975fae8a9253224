"""The penalty method: sequential convex programming on the complementarity product.

The merit function is ``f(x) + rho sum_i left_i(x) right_i(x)`` on the relaxation, where both sides
are nonnegative. Each step minimises f plus the product linearised at the iterate, then makes an
exact line search towards that minimiser (the merit is quadratic along it); the penalty weight rho
grows where a step gains nothing. With the sides of some pairs fixed the same method repairs a
choice of sides that has no point.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.qp.problem import QPStatus
from warp_softbody.controllers.qpcc.general.piece_qp import PROXIMAL_WEIGHT, ScaledQPCC
from warp_softbody.controllers.qpcc.general.piece_solution import PieceSolution, Sides

CLOSED = 1e-7
"""Scaled complementarity product up to which every pair counts as closed."""


@dataclass(frozen=True, kw_only=True)
class PenaltySchedule:
    """How the penalty weight grows.

    Attributes:
        first: weight in the first step, on the scale of the objective.
        growth: factor by which it grows after a step that gains little.
        patience: relative predicted decrease of the merit below which a step gains little.
        last: total growth after which the method gives up.
        most_qps: most QPs in one run.
    """

    first: float = 1e-2
    growth: float = 2.0
    patience: float = 0.1
    last: float = 1e5
    most_qps: int = 40


SCHEDULES = (
    PenaltySchedule(),
    PenaltySchedule(growth=4.0),
    PenaltySchedule(first=1e-3, patience=0.03),
    PenaltySchedule(first=1e-1),
)
"""Schedules of runs from the relaxation's minimiser; on hard problems each ends elsewhere."""

SEEKING = tuple(PenaltySchedule(first=first, growth=4.0) for first in (1.0, 10.0, 100.0))
"""Schedules while no feasible point is known: pairs are closed first, the objective comes later."""

REPAIR = PenaltySchedule(first=0.1, growth=4.0, most_qps=20)
"""Schedule of the repair after a pair was forced to its other side (a kick)."""


def close_pairs(
    general: ScaledQPCC,
    start: FloatArray | None,
    sides: Sides,
    options: PenaltySchedule,
    spent: Callable[[], bool],
) -> FloatArray | None:
    """A point at which most pairs are closed, by the penalty method; None where a QP fails.

    Args:
        general: the problem.
        start: first iterate, which need not be feasible; default the relaxation's minimiser.
        sides: fixed sides of some pairs, the others OPEN.
        options: schedule of the penalty weight.
        spent: whether the budget is used up.
    """
    x = start
    if x is None:
        relaxed = solve_with_proximal_term(general, sides)
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
        step = solve_with_proximal_term(general, sides, linear=slope, center=x)
        if step is None:
            return None
        direction = step.x - x
        falling = float((general.Q @ x + general.c + slope) @ direction)
        length = _exact_step(general, direction, falling, weight)
        if falling > -options.patience * (abs(general.value(x)) + weight * product):
            weight *= options.growth
        if length > 0.0:
            x = x + length * direction
    return x


def _exact_step(general: ScaledQPCC, direction: FloatArray, falling: float, weight: float) -> float:
    """The share of a direction, at most 1, that minimises the merit, from its derivative."""
    curvature = 0.5 * float(direction @ (general.Q @ direction))
    curvature += weight * float((general.L @ direction) @ (general.R @ direction))
    return 1.0 if curvature <= 0.0 else min(1.0, -falling / (2.0 * curvature))


def solve_with_proximal_term(
    general: ScaledQPCC,
    sides: Sides,
    *,
    linear: FloatArray | None = None,
    center: FloatArray | None = None,
) -> PieceSolution | None:
    """Solve, with a proximal term at ``center`` where the QP is unbounded; None where it fails."""
    piece = general.solve(sides, linear=linear, center=center)
    if piece.status in (QPStatus.UNBOUNDED, QPStatus.UNSOLVED):
        at = np.zeros_like(general.c) if center is None else center
        piece = general.solve(sides, linear=linear, center=at, proximal=PROXIMAL_WEIGHT)
    return piece if piece.status is QPStatus.SOLVED else None
