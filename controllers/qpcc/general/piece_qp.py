"""Convex QPs over a general QPCC: one piece, a relaxation, or a step of the penalty method.

A piece is one choice, for every pair, of the side that is zero; the other one stays nonnegative. A
relaxation leaves some pairs open: both sides nonnegative. Rows and objective are scaled once, so
that one tolerance serves every row.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.qp.problem import (
    Backend,
    QPMultipliers,
    QPProblem,
    QPSolution,
    QPStatus,
)
from warp_softbody.controllers.qp.sparse_or_dense import dense, held, shifted, split_convex, stacked
from warp_softbody.controllers.qpcc.general.problem import QPCC, sizes

Sides = npt.NDArray[np.int8]
"""(p,): which side of every pair is zero."""

OPEN, LEFT, RIGHT = -1, 0, 1

CONCAVE_STEPS = 30
"""Linearisations of the concave part of an indefinite Q in one piece."""

UNBOUNDED_PULL = 1e-4
"""Curvature, scaled, that holds a step back where the QP alone would be unbounded."""

FAR = 1e6
"""Scaled distance beyond which a ray is looked for."""


@dataclass(frozen=True, kw_only=True)
class Piece:
    """The answer of one QP over a problem whose pairs are closed by ``sides``.

    Attributes:
        sides: which side of every pair is zero, OPEN where neither must be.
        x: the point.
        value: scaled objective, without the constant.
        status: of the QP.
        left: (p,), scaled ``L x + l0``.
        right: (p,), scaled ``R x + r0``.
        left_multiplier: (p,), slope of the objective as the left side is raised.
        right_multiplier: (p,).
        solution: of the QP, whose objective was divided by
        weight.
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
    weight: float


class GeneralProblem:
    """A problem scaled once; counts the QPs that are asked of it."""

    def __init__(self, problem: QPCC, backend: Backend) -> None:
        """Scale rows and objective; split an indefinite Q into a convex and a concave part."""
        self.problem = problem
        self.backend = backend
        self.qp_count = 0
        over_left, over_right = problem.side_scales
        over = sizes(problem.A, problem.b)
        used = np.isfinite(problem.h)
        over_row = sizes(problem.G, problem.h)
        self.l0, self.r0 = problem.l0 / over_left, problem.r0 / over_right
        self._b, self._h = problem.b / over, -(problem.h / over_row)[used]
        self.value_scale = max(float(np.abs(problem.Q).max()), float(np.abs(problem.c).max()))
        self.value_scale = self.value_scale or 1.0
        hessian = 0.5 * (problem.Q + problem.Q.T) / self.value_scale
        self.c = problem.c / self.value_scale
        convex, self.concave_part = split_convex(hessian)
        self.Q = hessian
        self.L, self.R = problem.L / over_left[:, None], problem.R / over_right[:, None]
        # What the QPs are put together from.
        self.convex_part, self._L, self._R, self._A, self._G = held(
            convex,
            self.L,
            self.R,
            problem.A / over[:, None],
            -(problem.G / over_row[:, None])[used],
        )

    def value(self, x: FloatArray) -> float:
        """Scaled objective, without the constant."""
        return float(x @ (0.5 * (self.Q @ x) + self.c))

    def sides_at(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Scaled left and right sides."""
        return self.L @ x + self.l0, self.R @ x + self.r0

    def nearest_sides(self, x: FloatArray) -> Sides:
        """The smaller side of every pair as the one that is zero."""
        left, right = self.sides_at(x)
        return np.where(left <= right, LEFT, RIGHT).astype(np.int8)

    def solve(
        self,
        sides: Sides,
        *,
        linear: FloatArray | None = None,
        near: FloatArray | None = None,
        pull: float = 0.0,
    ) -> Piece:
        """Minimise over the pieces ``sides``, plus ``linear``' x and ``pull``/2 |x - near|^2.

        ``near`` is also where the concave part of an indefinite Q is linearised first.
        """
        linear = np.zeros_like(self.c) if linear is None else linear
        at = np.zeros_like(self.c) if near is None else near
        piece = self._solve_once(sides, linear, at, pull)
        if self.concave_part is None:
            return piece
        for _ in range(CONCAVE_STEPS):
            if piece.status is not QPStatus.SOLVED:
                break
            following = self._solve_once(sides, linear, piece.x, pull)
            settled = np.abs(following.x - piece.x).max() <= 1e-9 * (1.0 + np.abs(piece.x).max())
            piece = following
            if settled:
                break
        return piece

    def unbounded_below(self, sides: Sides) -> bool:
        """Whether a direction exists along which a convex objective falls without end."""
        if self.concave_part is not None:
            return False
        free = np.zeros_like(self.c)
        lower = np.where(np.isfinite(self.problem.lb), 0.0, -1.0)
        upper = np.where(np.isfinite(self.problem.ub), 0.0, 1.0)
        program = replace(
            self._program(sides, free, free, 0.0),
            lower=lower,
            upper=upper,
            P=0.0 * self.convex_part,
        )
        curved = self.Q[np.linalg.norm(self.Q, axis=1) > 0.0]
        program = replace(
            program,
            A=stacked([program.A, curved]),
            b=np.zeros(len(program.b) + len(curved)),
            h=np.zeros_like(program.h),
        )
        self.qp_count += 1
        ray = self.backend.solve(program)
        return ray.status is QPStatus.SOLVED and ray.value < -1e-6

    def exact(self, piece: Piece) -> FloatArray:
        """The piece's point moved onto the rows that are active there, as far as they agree."""
        x, lower, upper = piece.x, self.problem.lb, self.problem.ub
        zero_left, zero_right = piece.sides == LEFT, piece.sides == RIGHT
        at = (x <= lower) | (x >= upper)
        rows = [self._A, self._L[zero_left], self._R[zero_right]]
        offsets = [-self._b, self.l0[zero_left], self.r0[zero_right]]
        multipliers = piece.solution.multipliers.rows
        slack = np.concatenate([self._G @ x - self._h, piece.left[zero_right]])
        slack = np.concatenate([slack, piece.right[zero_left]])
        kept = stacked([self._G, self._L[zero_right], self._R[zero_left]])
        shift = np.concatenate([-self._h, self.l0[zero_right], self.r0[zero_left]])
        active = (slack < multipliers) | (slack < 0.0)
        matrix = dense(stacked([*rows, kept[active]]))
        miss = matrix @ x + np.concatenate([*offsets, shift[active]])
        if not len(miss):
            return x
        step = np.linalg.lstsq(matrix[:, ~at], -miss, rcond=1e-10)[0]
        moved = x.copy()
        moved[~at] += step
        clipped: FloatArray = np.clip(moved, lower, upper)
        return clipped

    def _solve_once(self, sides: Sides, linear: FloatArray, near: FloatArray, pull: float) -> Piece:
        self.qp_count += 1
        program = self._program(sides, linear, near, pull)
        # A heavy linear term would put the residuals that count as solved out of reach.
        size = max(1.0, float(np.abs(program.c).max()))
        solution = self.backend.solve(replace(program, P=program.P / size, c=program.c / size))
        x = solution.x
        left, right = self.sides_at(x)
        multipliers = _pair_multipliers(sides, solution.multipliers, len(self._b), len(self._h))
        value = self.value(x) if np.all(np.isfinite(x)) else np.inf
        return Piece(
            sides=sides,
            x=x,
            value=value,
            status=solution.status,
            left=left,
            right=right,
            left_multiplier=size * multipliers[0],
            right_multiplier=size * multipliers[1],
            solution=solution,
            weight=size,
        )

    def _program(
        self, sides: Sides, linear: FloatArray, near: FloatArray, pull: float
    ) -> QPProblem:
        zero_left, zero_right = sides == LEFT, sides == RIGHT
        hessian, gradient = self.convex_part, self.c + linear
        if self.concave_part is not None:
            gradient = gradient - self.concave_part @ near
        if pull > 0.0:
            hessian = shifted(hessian, pull)
            gradient = gradient - pull * near
        return QPProblem(
            P=hessian,
            c=gradient,
            A=stacked([self._A, self._L[zero_left], self._R[zero_right]]),
            b=np.concatenate([self._b, -self.l0[zero_left], -self.r0[zero_right]]),
            G=stacked([self._G, self._L[~zero_left], self._R[~zero_right]]),
            h=np.concatenate([self._h, -self.l0[~zero_left], -self.r0[~zero_right]]),
            lower=self.problem.lb,
            upper=self.problem.ub,
        )


def _pair_multipliers(
    sides: Sides, multipliers: QPMultipliers, equations: int, rows: int
) -> tuple[FloatArray, FloatArray]:
    """Multipliers of both sides of every pair, in the order of the pairs."""
    zero_left, zero_right = sides == LEFT, sides == RIGHT
    left, right = np.zeros(len(sides)), np.zeros(len(sides))
    split = equations + int(zero_left.sum())
    left[zero_left] = multipliers.equalities[equations:split]
    right[zero_right] = multipliers.equalities[split:]
    split = rows + int((~zero_left).sum())
    left[~zero_left] = multipliers.rows[rows:split]
    right[~zero_right] = multipliers.rows[split:]
    return left, right
