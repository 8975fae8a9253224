"""The interface to DAQP, a dual active set method for small, strictly convex QPs.

It is two to four times faster than PIQP on the QPs of 4 to 32 contacts with the forces eliminated,
and its active set is exact (docs/qpcc.md). No other file knows DAQP.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import daqp
import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.qp.diagonal_plus_low_rank import DiagonalPlusLowRank
from warp_softbody.controllers.qp.piqp import PIQPSolver
from warp_softbody.controllers.qp.problem import (
    QPMultipliers,
    QPProblem,
    QPSolution,
    QPStatus,
    verified,
)
from warp_softbody.controllers.qp.sparse_or_dense import to_dense
from warp_softbody.errors import InputError

INFEASIBLE, EQUATION = -1, 5
"""DAQP's exit flag of an infeasible problem; its mark of a row that is an equality."""

EMPTY = np.zeros(0)

SETTINGS = {
    "iter_limit", "primal_tol", "dual_tol", "zero_tol", "pivot_tol", "progress_tol", "cycle_tol",
    "eps_prox", "eta_prox", "sing_tol", "refactor_tol",
}  # fmt: skip


class DAQPSolver:
    """A QP solver by DAQP; what it does not solve to the verified accuracy goes to PIQP.

    Settings are DAQP's own, by name; a name or value that it does not take is refused.
    """

    def __init__(
        self, *, tolerance: float = 1e-12, settings: Mapping[str, Any] | None = None
    ) -> None:
        """Choose the primal and dual tolerance, and any further settings by name."""
        # An active set is right or wrong: below 1e-10 its rows' test only meets rounding.
        self._settings: dict[str, Any] = {
            "primal_tol": max(tolerance, 1e-10),
            "dual_tol": tolerance,
            "iter_limit": 1000,
            **(settings or {}),
        }
        for name, value in self._settings.items():
            if name not in SETTINGS:
                raise InputError(f"DAQP has no setting {name!r}")
            if isinstance(value, bool) or not isinstance(value, int | float):
                raise InputError(f"DAQP setting {name!r} cannot be {value!r}")
        self._tolerance = tolerance
        self._last_lifted: tuple[FloatArray, FloatArray] = (EMPTY, EMPTY)

    def solve(self, problem: QPProblem) -> QPSolution:
        """Solve one QP from scratch."""
        if problem.b.size:
            # Equalities mean redundant contacts: directions without curvature, which PIQP takes.
            return self._solve_by_piqp(problem)
        n, count = len(problem.c), len(problem.h)
        if isinstance(problem.P, DiagonalPlusLowRank):
            x, flag, multipliers, iterations = self._run_lifted(problem, problem.P)
        else:
            upper = np.full(n + count, np.inf)
            upper[:n] = problem.upper
            lower = np.concatenate([problem.lower, problem.h])
            kinds = np.zeros(n + count, np.int32)
            program = (problem.P, problem.c, problem.G, upper, lower, kinds)
            x, flag, multipliers, iterations = self._run(program, problem.cutoff)
        if flag < 1:
            return self._without_answer(problem, flag)
        # A multiplier is negative where the lower side of its row is active.
        of_lower = np.maximum(-multipliers, 0.0)
        solution = verified(
            problem,
            x,
            QPMultipliers(
                rows=of_lower[n:],
                equalities=EMPTY,
                lower=of_lower[:n],
                upper=multipliers[:n] + of_lower[:n],
            ),
            otherwise=QPStatus.UNSOLVED,
            iterations=iterations,
        )
        return solution if solution.status is QPStatus.SOLVED else self._solve_by_piqp(problem)

    def strictly_convex(self, problem: QPProblem) -> QPSolution | None:
        """DAQP's own answer to a QP with a definite P, equations included; None where it has none.

        Unlike ``solve`` it asks nobody else.
        """
        n, rows, equations = len(problem.c), len(problem.h), len(problem.b)
        upper = np.concatenate([problem.upper, np.full(rows, np.inf), problem.b])
        lower = np.concatenate([problem.lower, problem.h, problem.b])
        kinds = np.zeros(n + rows + equations, np.int32)
        kinds[n + rows :] = EQUATION
        matrix = np.ascontiguousarray(np.vstack([to_dense(problem.G), to_dense(problem.A)]))
        program = (to_dense(problem.P), problem.c, matrix, upper, lower, kinds)
        x, flag, multipliers, iterations = self._run(program, math.inf)
        if flag < 1:
            return None
        of_lower = np.maximum(-multipliers, 0.0)
        return verified(
            problem,
            x,
            QPMultipliers(
                rows=of_lower[n : n + rows],
                equalities=-multipliers[n + rows :],
                lower=of_lower[:n],
                upper=multipliers[:n] + of_lower[:n],
            ),
            otherwise=QPStatus.UNSOLVED,
            iterations=iterations,
        )

    def _run(
        self, program: tuple[npt.NDArray[Any], ...], cutoff: float
    ) -> tuple[FloatArray, int, FloatArray, int]:
        """DAQP's point, exit flag, multipliers and number of iterations."""
        settings = self._settings
        if cutoff < math.inf:
            settings = settings | {"fval_bound": cutoff}
        x, _, flag, info = daqp.solve(*program, **settings)
        return x, flag, info["lam"], int(info["iterations"])

    def _run_lifted(
        self, problem: QPProblem, matrix: DiagonalPlusLowRank
    ) -> tuple[FloatArray, int, FloatArray, int]:
        """The same for the lifted problem, with variables z = N x beside x.

        Its Hessian is diagonal: nothing is factorised, and bounds of variables cost nothing.
        Equalities tie the new variables to the old ones.
        """
        factor, n, count = matrix.factor, len(problem.c), len(problem.h)
        r = len(factor)
        rows = np.zeros((r + count, n + r))
        rows[:r, :n] = factor
        rows.reshape(-1)[n : r * (n + r) : n + r + 1] = -1.0
        rows[r:, :n] = problem.G
        upper = np.full(n + 2 * r + count, np.inf)
        upper[:n], upper[n + r : n + 2 * r] = problem.upper, 0.0
        zeros = np.zeros(r)
        lower = np.concatenate([problem.lower, -upper[n : n + r], zeros, problem.h])
        kinds = np.zeros(len(upper), np.int32)
        kinds[n + r : n + 2 * r] = EQUATION
        c = np.concatenate([problem.c, zeros])
        cutoff = problem.cutoff
        if cutoff < math.inf:
            # The minimum that DAQP measures from is that without the equalities.
            cutoff += matrix.low_rank_share(problem.c)
        program = (self._lifted_hessian(matrix), c, rows, upper, lower, kinds)
        x, flag, multipliers, iterations = self._run(program, cutoff)
        own = np.concatenate([multipliers[:n], multipliers[n + 2 * r :]])
        return x[:n], flag, own, iterations

    def _lifted_hessian(self, matrix: DiagonalPlusLowRank) -> FloatArray:
        """The diagonal matrix of all variables, kept while the diagonal is the same array."""
        size = len(matrix.diagonal) + len(matrix.factor)
        if self._last_lifted[0] is not matrix.diagonal or len(self._last_lifted[1]) != size:
            whole = np.zeros((size, size))
            whole.reshape(-1)[:: size + 1] = 1.0
            whole.reshape(-1)[: len(matrix.diagonal) * (size + 1) : size + 1] = matrix.diagonal
            self._last_lifted = matrix.diagonal, whole
        return self._last_lifted[1]

    def _solve_by_piqp(self, problem: QPProblem) -> QPSolution:
        """The answer of an interior point method."""
        whole = replace(problem, P=to_dense(problem.P))
        return PIQPSolver(tolerance=self._tolerance).solve(whole)

    def _without_answer(self, problem: QPProblem, flag: int) -> QPSolution:
        """INFEASIBLE where DAQP says so, and PIQP's answer where it failed."""
        if flag != INFEASIBLE:
            return self._solve_by_piqp(problem)
        none = np.zeros_like(problem.c)
        return QPSolution(
            x=none,
            value=np.nan,
            status=QPStatus.INFEASIBLE,
            multipliers=QPMultipliers(
                rows=np.zeros_like(problem.h),
                equalities=np.zeros(0),
                lower=none,
                upper=none,
            ),
            primal_residual=np.nan,
            dual_residual=np.nan,
            iterations=0,
        )
