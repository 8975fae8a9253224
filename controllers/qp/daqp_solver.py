"""The only file that knows DAQP: a dual active set method for small, strictly convex QPs.

Two to four times faster than PIQP on the reduced QPs of 4 to 32 contacts, and its active set is
exact (docs/qpcc.md).
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
from warp_softbody.controllers.qp.diagonal_plus_low_rank import Gram
from warp_softbody.controllers.qp.piqp_solver import PIQPBackend
from warp_softbody.controllers.qp.problem import (
    QPMultipliers,
    QPProblem,
    QPSolution,
    QPStatus,
    checked,
)
from warp_softbody.controllers.qp.sparse_or_dense import dense
from warp_softbody.errors import InputError

INFEASIBLE, EQUATION = -1, 5
"""DAQP's verdict of no point; its mark of a row that is an equation."""

NONE = np.zeros(0)

SETTINGS = {
    "iter_limit", "primal_tol", "dual_tol", "zero_tol", "pivot_tol", "progress_tol", "cycle_tol",
    "eps_prox", "eta_prox", "sing_tol", "refactor_tol",
}  # fmt: skip


class DAQPBackend:
    """DAQP behind ``solve``; what it does not solve to the checked accuracy goes to PIQP.

    Settings are DAQP's own, by name; a name or value that it does not take is refused.
    """

    def __init__(
        self, *, tolerance: float = 1e-12, settings: Mapping[str, Any] | None = None
    ) -> None:
        """Choose the accuracy of rows and duals, and any further settings by name."""
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
        self._known: tuple[FloatArray, FloatArray] = (NONE, NONE)

    def solve(self, problem: QPProblem) -> QPSolution:
        """Solve one QP from scratch."""
        if problem.b.size:
            # Equations mean redundant contacts: directions without curvature, PIQP's ground.
            return self._second(problem)
        n, count = len(problem.c), len(problem.h)
        if isinstance(problem.P, Gram):
            x, flag, slope, iterations = self._spread(problem, problem.P)
        else:
            upper = np.full(n + count, np.inf)
            upper[:n] = problem.upper
            lower = np.concatenate([problem.lower, problem.h])
            kinds = np.zeros(n + count, np.int32)
            program = (problem.P, problem.c, problem.G, upper, lower, kinds)
            x, flag, slope, iterations = self._run(program, problem.headroom)
        if flag < 1:
            return self._refused(problem, flag)
        against = np.maximum(-slope, 0.0)
        solution = checked(
            problem,
            x,
            QPMultipliers(
                rows=against[n:],
                equalities=NONE,
                lower=against[:n],
                upper=slope[:n] + against[:n],
            ),
            otherwise=QPStatus.UNSOLVED,
            iterations=iterations,
        )
        return solution if solution.status is QPStatus.SOLVED else self._second(problem)

    def _run(
        self, program: tuple[npt.NDArray[Any], ...], headroom: float
    ) -> tuple[FloatArray, int, FloatArray, int]:
        """DAQP's point, verdict, multipliers and iterations."""
        settings = self._settings
        if headroom < math.inf:
            settings = settings | {"fval_bound": headroom}
        x, _, flag, info = daqp.solve(*program, **settings)
        return x, flag, info["lam"], int(info["iterations"])

    def _spread(self, problem: QPProblem, matrix: Gram) -> tuple[FloatArray, int, FloatArray, int]:
        """The same with the squared rows as variables of their own, z = N x.

        The matrix is then diagonal: nothing is factorised, and the distance of a variable from its
        bounds costs nothing. Equations hold the new variables.
        """
        rows, n, count = matrix.rows, len(problem.c), len(problem.h)
        r = len(rows)
        sides = np.zeros((r + count, n + r))
        sides[:r, :n] = rows
        sides.reshape(-1)[n : r * (n + r) : n + r + 1] = -1.0
        sides[r:, :n] = problem.G
        upper = np.full(n + 2 * r + count, np.inf)
        upper[:n], upper[n + r : n + 2 * r] = problem.upper, 0.0
        nothing = np.zeros(r)
        lower = np.concatenate([problem.lower, -upper[n : n + r], nothing, problem.h])
        kinds = np.zeros(len(upper), np.int32)
        kinds[n + r : n + 2 * r] = EQUATION
        c = np.concatenate([problem.c, nothing])
        headroom = problem.headroom
        if headroom < math.inf:
            headroom += matrix.saved(problem.c)
        program = (self._spread_diagonal(matrix), c, sides, upper, lower, kinds)
        x, flag, slope, iterations = self._run(program, headroom)
        return x[:n], flag, np.concatenate([slope[:n], slope[n + 2 * r :]]), iterations

    def _spread_diagonal(self, matrix: Gram) -> FloatArray:
        """The matrix of all variables, kept while the diagonal is the same array."""
        size = len(matrix.diagonal) + len(matrix.rows)
        if self._known[0] is not matrix.diagonal or len(self._known[1]) != size:
            whole = np.zeros((size, size))
            whole.reshape(-1)[:: size + 1] = 1.0
            whole.reshape(-1)[: len(matrix.diagonal) * (size + 1) : size + 1] = matrix.diagonal
            self._known = matrix.diagonal, whole
        return self._known[1]

    def _second(self, problem: QPProblem) -> QPSolution:
        """Another method's answer."""
        whole = replace(problem, P=dense(problem.P))
        return PIQPBackend(tolerance=self._tolerance).solve(whole)

    def _refused(self, problem: QPProblem, flag: int) -> QPSolution:
        """DAQP's verdict where there is no point, a second opinion on anything else."""
        if flag != INFEASIBLE:
            return self._second(problem)
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
