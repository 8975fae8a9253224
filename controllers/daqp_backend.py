"""The only file that knows DAQP: a dual active set method for small, strictly convex QPs.

Two to four times faster than PIQP on the reduced QPs of 4 to 32 contacts, and its active set is
exact (docs/qpcc.md).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import daqp
import numpy as np

from warp_softbody.controllers.piqp_backend import PIQPBackend
from warp_softbody.controllers.qp import QPMultipliers, QPProblem, QPSolution, QPStatus, checked
from warp_softbody.errors import InputError

INFEASIBLE = -1

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

    def solve(self, problem: QPProblem) -> QPSolution:
        """Solve one QP from scratch."""
        if problem.b.size:
            # Equations mean redundant contacts: directions without curvature, PIQP's ground.
            return self._second(problem)
        n, count = len(problem.c), len(problem.c) + len(problem.h)
        lower = np.concatenate([problem.lower, problem.h])
        upper = np.full(count, np.inf)
        upper[:n] = problem.upper
        settings = self._settings
        if problem.headroom < math.inf:
            settings = settings | {"fval_bound": problem.headroom}
        x, _, flag, info = daqp.solve(
            problem.P,
            problem.c,
            problem.G,
            upper,
            lower,
            np.zeros(count, np.int32),
            **settings,
        )
        if flag < 1:
            return self._refused(problem, flag)
        slope = info["lam"]
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
            iterations=int(info["iterations"]),
        )
        return solution if solution.status is QPStatus.SOLVED else self._second(problem)

    def _second(self, problem: QPProblem) -> QPSolution:
        """Another method's answer."""
        return PIQPBackend(tolerance=self._tolerance).solve(problem)

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
