"""Convex QPs over a general QPCC: on one piece, on a relaxation, or for a step of a penalty method.

The feasible set is a union of polyhedra, its pieces: a piece chooses for every complementarity
pair the side that is zero, and the other side stays nonnegative. A relaxation leaves some pairs
open, with both sides nonnegative. Rows and objective are scaled once, so that one tolerance serves
every row.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.qp.problem import (
    QPProblem,
    QPSolver,
    QPStatus,
)
from warp_softbody.controllers.qp.sparse_or_dense import (
    SPARSE_SIZE,
    add_to_diagonal,
    sparse_where_worthwhile,
    stack_rows,
    to_dense,
)
from warp_softbody.controllers.qpcc.general.convex_concave import convex_concave_split
from warp_softbody.controllers.qpcc.general.piece_solution import (
    LEFT,
    RIGHT,
    PieceSolution,
    Sides,
    pair_multipliers,
)
from warp_softbody.controllers.qpcc.general.problem import QPCC, row_scales

CONCAVE_STEPS = 30
"""Most linearisations of the concave part of an indefinite Q on one piece."""

PROXIMAL_WEIGHT = 1e-4
"""Scaled weight of the proximal term of a QP that is unbounded without one."""


class ScaledQPCC:
    """A general QPCC with scaled rows and objective, which solves and counts the QPs on its pieces.

    Attributes:
        problem: in its own units.
        qp_count: QPs solved.
        value_scale: of the objective, its largest coefficient.
        Q: (n, n), scaled and symmetric.
        c: (n,), scaled.
        L: (p, n), scaled left sides; R, l0 and r0 likewise.
        convex_part: (n, n), positive semidefinite, which is Q where that is.
        concave_part: (n, n), what Q has less than it; None where Q is positive semidefinite.
    """

    def __init__(
        self, problem: QPCC, qp_solver: QPSolver, *, sparse_above: int = SPARSE_SIZE
    ) -> None:
        """Scale rows and objective; split an indefinite Q into a convex and a concave part.

        Matrices of more than ``sparse_above`` columns are sparse where that pays.
        """
        self.problem = problem
        self.qp_solver = qp_solver
        self.qp_count = 0
        over_left, over_right = problem.side_scales
        over = row_scales(problem.A, problem.b)
        used = np.isfinite(problem.h)
        over_row = row_scales(problem.G, problem.h)
        self.l0, self.r0 = problem.l0 / over_left, problem.r0 / over_right
        self._b, self._h = problem.b / over, -(problem.h / over_row)[used]
        self.value_scale = max(float(np.abs(problem.Q).max()), float(np.abs(problem.c).max()))
        self.value_scale = self.value_scale or 1.0
        hessian = 0.5 * (problem.Q + problem.Q.T) / self.value_scale
        self.c = problem.c / self.value_scale
        convex, self.concave_part = convex_concave_split(hessian)
        self.Q = hessian
        self.L, self.R = problem.L / over_left[:, None], problem.R / over_right[:, None]
        # The blocks of the QPs.
        self.convex_part, self._L, self._R, self._A, self._G = sparse_where_worthwhile(
            convex,
            self.L,
            self.R,
            problem.A / over[:, None],
            -(problem.G / over_row[:, None])[used],
            above=sparse_above,
        )

    def value(self, x: FloatArray) -> float:
        """Scaled objective, without the constant."""
        return float(x @ (0.5 * (self.Q @ x) + self.c))

    def sides_at(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Scaled left and right sides."""
        return self.L @ x + self.l0, self.R @ x + self.r0

    def nearest_sides(self, x: FloatArray) -> Sides:
        """The piece nearest to a point: of every pair the smaller side is zero."""
        left, right = self.sides_at(x)
        return np.where(left <= right, LEFT, RIGHT).astype(np.int8)

    def solve(
        self,
        sides: Sides,
        *,
        linear: FloatArray | None = None,
        center: FloatArray | None = None,
        proximal: float = 0.0,
    ) -> PieceSolution:
        """Minimise on the piece ``sides`` with further terms in the objective.

        These are ``linear' x`` and the proximal term ``proximal / 2 |x - center|^2``. The
        concave part of an indefinite Q is linearised at ``center`` first.
        """
        linear = np.zeros_like(self.c) if linear is None else linear
        at = np.zeros_like(self.c) if center is None else center
        piece = self._solve_once(sides, linear, at, proximal)
        if self.concave_part is None:
            return piece
        for _ in range(CONCAVE_STEPS):
            if piece.status is not QPStatus.SOLVED:
                break
            following = self._solve_once(sides, linear, piece.x, proximal)
            settled = np.abs(following.x - piece.x).max() <= 1e-9 * (1.0 + np.abs(piece.x).max())
            piece = following
            if settled:
                break
        return piece

    def unbounded_below(self, sides: Sides) -> bool:
        """Whether a piece has a direction along which a convex objective falls without end.

        The direction minimises the linear term over the recession cone, cut off by a box, on which
        the objective has no curvature.
        """
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
            A=stack_rows([program.A, curved]),
            b=np.zeros(len(program.b) + len(curved)),
            h=np.zeros_like(program.h),
        )
        self.qp_count += 1
        ray = self.qp_solver.solve(program)
        return ray.status is QPStatus.SOLVED and ray.value < -1e-6

    def polish(self, piece: PieceSolution) -> FloatArray:
        """The piece's point projected on the rows that are active there, by least squares."""
        x, lower, upper = piece.x, self.problem.lb, self.problem.ub
        zero_left, zero_right = piece.sides == LEFT, piece.sides == RIGHT
        at = (x <= lower) | (x >= upper)
        rows = [self._A, self._L[zero_left], self._R[zero_right]]
        offsets = [-self._b, self.l0[zero_left], self.r0[zero_right]]
        multipliers = piece.solution.multipliers.rows
        slack = np.concatenate([self._G @ x - self._h, piece.left[zero_right]])
        slack = np.concatenate([slack, piece.right[zero_left]])
        kept = stack_rows([self._G, self._L[zero_right], self._R[zero_left]])
        shift = np.concatenate([-self._h, self.l0[zero_right], self.r0[zero_left]])
        active = (slack < multipliers) | (slack < 0.0)
        matrix = to_dense(stack_rows([*rows, kept[active]]))
        miss = matrix @ x + np.concatenate([*offsets, shift[active]])
        if not len(miss):
            return x
        step = np.linalg.lstsq(matrix[:, ~at], -miss, rcond=1e-10)[0]
        moved = x.copy()
        moved[~at] += step
        clipped: FloatArray = np.clip(moved, lower, upper)
        return clipped

    def _solve_once(
        self, sides: Sides, linear: FloatArray, center: FloatArray, proximal: float
    ) -> PieceSolution:
        self.qp_count += 1
        program = self._program(sides, linear, center, proximal)
        # A heavy linear term would put the residuals that count as solved out of reach.
        size = max(1.0, float(np.abs(program.c).max()))
        solution = self.qp_solver.solve(replace(program, P=program.P / size, c=program.c / size))
        x = solution.x
        left, right = self.sides_at(x)
        multipliers = pair_multipliers(sides, solution.multipliers, len(self._b), len(self._h))
        value = self.value(x) if np.all(np.isfinite(x)) else np.inf
        return PieceSolution(
            sides=sides,
            x=x,
            value=value,
            status=solution.status,
            left=left,
            right=right,
            left_multiplier=size * multipliers[0],
            right_multiplier=size * multipliers[1],
            solution=solution,
            objective_scale=size,
        )

    def _program(
        self, sides: Sides, linear: FloatArray, center: FloatArray, proximal: float
    ) -> QPProblem:
        zero_left, zero_right = sides == LEFT, sides == RIGHT
        hessian, gradient = self.convex_part, self.c + linear
        if self.concave_part is not None:
            gradient = gradient - self.concave_part @ center
        if proximal > 0.0:
            hessian = add_to_diagonal(hessian, proximal)
            gradient = gradient - proximal * center
        return QPProblem(
            P=hessian,
            c=gradient,
            A=stack_rows([self._A, self._L[zero_left], self._R[zero_right]]),
            b=np.concatenate([self._b, -self.l0[zero_left], -self.r0[zero_right]]),
            G=stack_rows([self._G, self._L[~zero_left], self._R[~zero_right]]),
            h=np.concatenate([self._h, -self.l0[~zero_left], -self.r0[~zero_right]]),
            lower=self.problem.lb,
            upper=self.problem.ub,
        )
