"""The pieces of a general QPCC by the zero sides of its pairs, and the answer of the QP on one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.qp.problem import QPMultipliers, QPSolution, QPStatus

Sides = npt.NDArray[np.int8]
"""(p,): which side of every pair is zero, LEFT or RIGHT, or OPEN where neither has to be."""

OPEN, LEFT, RIGHT = -1, 0, 1


@dataclass(frozen=True, kw_only=True)
class PieceSolution:
    """The answer of the QP on one piece or relaxation.

    Attributes:
        sides: the piece, or relaxation where some are OPEN.
        x: the minimiser.
        value: scaled objective, without the constant.
        status: of the QP.
        left: (p,), scaled ``L x + l0``.
        right: (p,), scaled ``R x + r0``.
        left_multiplier: (p,), derivative of the objective as the left side is raised.
        right_multiplier: (p,), the same of the right side.
        solution: of the QP.
        objective_scale: by which the objective of that QP was divided.
        bound: at most the minimum on the piece: the value, less the QP's duality gap and what its
            residuals may hide; minus infinity where the QP was not solved.
    """

    sides: Sides
    x: FloatArray
    value: float
    status: QPStatus
    left: FloatArray
    right: FloatArray
    left_multiplier: FloatArray
    right_multiplier: FloatArray
    solution: QPSolution
    objective_scale: float
    bound: float


def pair_multipliers(
    sides: Sides, multipliers: QPMultipliers, equations: int, rows: int
) -> tuple[FloatArray, FloatArray]:
    """The multipliers of both sides of every pair, in the order of the pairs."""
    zero_left, zero_right = sides == LEFT, sides == RIGHT
    left, right = np.zeros(len(sides)), np.zeros(len(sides))
    split = equations + int(zero_left.sum())
    left[zero_left] = multipliers.equalities[equations:split]
    right[zero_right] = multipliers.equalities[split:]
    split = rows + int((~zero_left).sum())
    left[~zero_left] = multipliers.rows[rows:split]
    right[~zero_right] = multipliers.rows[split:]
    return left, right
