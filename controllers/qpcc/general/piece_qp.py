"""Convex QPs over a general QPCC: on one piece, on a relaxation, or for a step of a penalty method.

The feasible set is a union of polyhedra, its pieces: a piece chooses for every complementarity
pair the side that is zero, and the other side stays nonnegative. A relaxation leaves some pairs
open, with both sides nonnegative. Variables, rows and objective are scaled once
(``equilibration``), so that one tolerance serves every row.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.qp.certified import ActiveSetSolver, falling_ray
from warp_softbody.controllers.qp.problem import (
    QPProblem,
    QPSolution,
    QPSolver,
    QPStatus,
)
from warp_softbody.controllers.qp.sparse_or_dense import (
    SPARSE_SIZE,
    Matrix,
    add_to_diagonal,
    sparse_where_worthwhile,
    stack_rows,
    to_dense,
)
from warp_softbody.controllers.qpcc.general.convex_concave import convex_concave_split
from warp_softbody.controllers.qpcc.general.curvature import FAR_OFF, drifts, recession_ray
from warp_softbody.controllers.qpcc.general.equilibration import Equilibration
from warp_softbody.controllers.qpcc.general.piece_solution import (
    LEFT,
    RIGHT,
    PieceSolution,
    Sides,
    pair_multipliers,
)
from warp_softbody.controllers.qpcc.general.problem import QPCC

CONCAVE_STEPS = 30
"""Most linearisations of the concave part of an indefinite Q on one piece."""

PROXIMAL_WEIGHT = 1e-4
"""Scaled weight of the proximal term of a QP that is unbounded without one."""

FADING = 0.1
"""Factor from one proximal weight to the next where the QP without one falls for ever."""

LEAST_WEIGHT = 1e-8
"""Proximal weight at which such steps end."""

POLISH_RANKS = (1e-10, 1e-6, 1e-3)
"""Singular values of the active rows, relative to the largest, that count when projecting on them;
the next one where the step is too long."""

POLISH_STEP = 1e-5
"""Longest step of that projection: it shall remove residuals and not choose another point."""


@dataclass(frozen=True)
class Relaxation:
    """Another convex objective, 1/2 x'Hx + g'x + constant, that bounds the problem's from below.

    It does so at consistent points, but for ``shift / 2 |x|^2``.
    """

    hessian: FloatArray
    gradient: FloatArray
    constant: float
    shift: float


class ScaledQPCC:
    """A general QPCC in scaled units, which solves and counts the QPs on its pieces.

    Attributes:
        problem: in its own units.
        qp_count: QPs solved.
        variable_scale: (n,), of the variables.
        side_scales: of the rows of A, G, L and R.
        value_scale: of the objective.
        lower: (n,), scaled bounds; upper likewise.
        Q: (n, n), scaled and symmetric.
        c: (n,), scaled.
        L: (p, n), scaled left sides; R, l0 and r0 likewise.
        convex_part: (n, n), positive semidefinite, which is Q where that is.
        concave_part: (n, n), what Q has less than it; None where Q is positive semidefinite.
    """

    def __init__(
        self,
        problem: QPCC,
        qp_solver: QPSolver,
        *,
        sparse_above: int = SPARSE_SIZE,
        unit: float = 1.0,
        scales: Equilibration | None = None,
    ) -> None:
        """Scale the problem; split an indefinite Q into a convex and a concave part.

        Matrices of more than ``sparse_above`` columns are sparse where that pays. The ``unit``, a
        power of two, is a typical size of the variables in their scales, by default those of the
        problem's equilibration.
        """
        self.problem = problem
        self.qp_solver = qp_solver
        self.qp_count = 0
        scales = scales or problem.equilibration
        over, over_row, over_left, over_right = (unit * scale for scale in scales.blocks)
        self.side_scales = over, over_row, over_left, over_right
        size = self.variable_scale = unit * scales.variables
        curvature = float((np.abs(problem.Q) * size[:, None] * size).max())
        self.value_scale = max(curvature, float((np.abs(problem.c) * size).max())) or 1.0
        self.lower, self.upper = problem.lb / size, problem.ub / size
        self.l0, self.r0 = problem.l0 / over_left, problem.r0 / over_right
        below, above = np.isfinite(problem.h), np.isfinite(problem.h_lower)
        self._b = problem.b / over
        rows = problem.G * size / over_row[:, None]
        self._h = np.concatenate(
            [-(problem.h / over_row)[below], (problem.h_lower / over_row)[above]]
        )
        hessian = 0.5 * (problem.Q + problem.Q.T) / self.value_scale
        hessian *= size[:, None]
        hessian *= size
        self.c = problem.c * size / self.value_scale
        convex, self.concave_part = convex_concave_split(hessian)
        self.Q = hessian
        self.L = problem.L * size / over_left[:, None]
        self.R = problem.R * size / over_right[:, None]
        # The blocks of the QPs.
        self.convex_part, self._L, self._R, self._A, self._G = sparse_where_worthwhile(
            convex,
            self.L,
            self.R,
            problem.A * size / over[:, None],
            np.concatenate([-rows[below], rows[above]]),
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
        qp_solver: QPSolver | None = None,
    ) -> PieceSolution:
        """Minimise on the piece ``sides`` with further terms in the objective.

        These are ``linear' x`` and the proximal term ``proximal / 2 |x - center|^2``. The
        concave part of an indefinite Q is linearised at ``center`` first.
        """
        solver = qp_solver or self.qp_solver
        linear = np.zeros_like(self.c) if linear is None else linear
        at = np.zeros_like(self.c) if center is None else center
        piece = self._solve_once(solver, sides, linear, at, proximal)
        if self.concave_part is None:
            return piece
        if proximal == 0.0 and piece.status in (QPStatus.UNSOLVED, QPStatus.UNBOUNDED):
            # the slope of the concave part alone may fall for ever
            return self._walk(piece, linear, at, solver)
        program = self.program(sides, linear, at, proximal)
        way = piece.x - at
        for _ in range(CONCAVE_STEPS):
            ray = drifts(self.Q, program, piece.x) if proximal == 0.0 else None
            if ray is not None:
                return replace(piece, x=ray, status=QPStatus.UNBOUNDED)
            if piece.status is not QPStatus.SOLVED:
                break
            following = self._solve_once(solver, sides, linear, piece.x, proximal)
            if following.status is not QPStatus.SOLVED:
                # too far off for the QPs' accuracy, or on a slope without end
                return piece if proximal else self._off(piece, program, way, solver)
            way = following.x - piece.x
            piece = following
            if np.abs(way).max() <= 1e-9 * (1.0 + np.abs(piece.x).max()):
                break
        return piece

    def _walk(
        self, failed: PieceSolution, linear: FloatArray, at: FloatArray, solver: QPSolver
    ) -> PieceSolution:
        """Steps with proximal terms that fade, where the linearised QP has no end."""
        found, way, weight = failed, np.zeros_like(at), 1.0
        while weight > LEAST_WEIGHT:
            step = self._solve_once(solver, failed.sides, linear, at, weight)
            if step.status is not QPStatus.SOLVED:
                break
            found, way, at, weight = step, step.x - at, step.x, FADING * weight
        if found is failed:
            return failed
        return self._off(found, self.program(found.sides, linear, at, 0.0), way, solver)

    def _off(
        self, found: PieceSolution, program: QPProblem, way: FloatArray, solver: QPSolver
    ) -> PieceSolution:
        """A ray near the last way, along which the objective curves down; else the last point.

        That is consistent, but need not be stationary.
        """
        ray = recession_ray(self.Q, program, way, solver)
        return found if ray is None else replace(found, x=ray, status=QPStatus.UNBOUNDED)

    @property
    def equations(self) -> Matrix:
        """The scaled rows of A, (e, n)."""
        return self._A

    @property
    def sides_of_equations(self) -> FloatArray:
        """The scaled b, (e,)."""
        return self._b

    def relax(self, sides: Sides, relaxation: Relaxation, qp_solver: QPSolver) -> PieceSolution:
        """Minimise another objective on a piece or relaxation; its bound holds for this one."""
        self.qp_count += 1
        free = np.zeros_like(self.c)
        program = self.program(sides, free, free, 0.0)
        size = max(1.0, float(np.abs(relaxation.gradient).max()))
        size = max(size, float(relaxation.hessian.diagonal().max()))
        program = replace(program, P=relaxation.hessian / size, c=relaxation.gradient / size)
        solution = qp_solver.solve(program)
        shift = 0.5 * relaxation.shift * float(solution.x @ solution.x)
        other = size * solution.value + relaxation.constant - shift
        return self._piece(sides, solution, size, other)

    def solve_exactly(self, piece: PieceSolution) -> PieceSolution | None:
        """The same piece from its point by QPs with exact active sets; None where that fails.

        It refines an answer, and counts as none.
        """
        solver, count = ActiveSetSolver(piece.x), self.qp_count
        exact = self.solve(piece.sides, center=piece.x, qp_solver=solver)
        self.qp_count = count
        return exact if exact.status is QPStatus.SOLVED else None

    def falling_ray(
        self, sides: Sides, time_limit: float, center: FloatArray | None = None
    ) -> FloatArray | None:
        """A direction on a piece along which the objective falls for ever, certified."""
        self.qp_count += 1
        free = np.zeros_like(self.c)
        if self.concave_part is not None:
            far = self.solve(sides, center=center)
            program = self.program(sides, free, free, 0.0)
            size = float(np.abs(far.x).max())
            ray = drifts(self.Q, program, far.x * (2.0 * FAR_OFF / (size or 1.0)))
            if ray is not None:
                return ray
        return falling_ray(self.program(sides, free, free, 0.0), time_limit)

    def polish(self, piece: PieceSolution) -> FloatArray:
        """The piece's point, in the problem's units, projected on its active rows."""
        x, lower, upper = piece.x, self.lower, self.upper
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
            return self.to_own_units(x)
        moved = x.copy()
        # Rows that are parallel but for a little meet far away: those are left out then.
        for rank in POLISH_RANKS:
            step = np.linalg.lstsq(matrix[:, ~at], -miss, rcond=rank)[0]
            if np.abs(step).max(initial=0.0) <= POLISH_STEP * (1.0 + np.abs(x).max()):
                moved[~at] += step
                break
        return self.to_own_units(moved)

    def to_own_units(self, x: FloatArray) -> FloatArray:
        """A scaled point in the problem's units, within its bounds."""
        clipped: FloatArray = np.clip(x * self.variable_scale, self.problem.lb, self.problem.ub)
        return clipped

    def _solve_once(
        self,
        solver: QPSolver,
        sides: Sides,
        linear: FloatArray,
        center: FloatArray,
        proximal: float,
    ) -> PieceSolution:
        self.qp_count += 1
        program = self.program(sides, linear, center, proximal)
        # A heavy linear term would put the residuals that count as solved out of reach.
        size = max(1.0, float(np.abs(program.c).max()))
        solution = solver.solve(replace(program, P=program.P / size, c=program.c / size))
        return self._piece(sides, solution, size, None)

    def _piece(
        self, sides: Sides, solution: QPSolution, size: float, other: float | None
    ) -> PieceSolution:
        """What a QP's answer says; ``other`` is the value of another objective that it minimised.

        The objective of the QP was divided by ``size``.
        """
        x = solution.x
        left, right = self.sides_at(x)
        multipliers = pair_multipliers(sides, solution.multipliers, len(self._b), len(self._h))
        value = self.value(x) if np.all(np.isfinite(x)) else np.inf
        bound = -np.inf
        if solution.status is QPStatus.SOLVED and self.concave_part is None:
            hidden = abs(solution.gap) + solution.dual_residual * float(np.abs(x).sum())
            bound = (value if other is None else other) - size * hidden
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
            bound=bound,
        )

    def program(
        self, sides: Sides, linear: FloatArray, center: FloatArray, proximal: float
    ) -> QPProblem:
        """The QP of a piece; the arguments are those of ``solve``."""
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
            lower=self.lower,
            upper=self.upper,
        )
