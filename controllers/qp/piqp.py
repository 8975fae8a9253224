"""The interface to PIQP, a proximal interior point method for convex QPs, dense or sparse.

No other file knows PIQP.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import piqp

from warp_softbody.controllers.qp.problem import (
    QPMultipliers,
    QPProblem,
    QPSolution,
    QPStatus,
    verified,
)
from warp_softbody.controllers.qp.sparse_or_dense import column_major, is_sparse
from warp_softbody.errors import InputError

STATUSES = {
    piqp.PIQP_PRIMAL_INFEASIBLE: QPStatus.INFEASIBLE,
    piqp.PIQP_DUAL_INFEASIBLE: QPStatus.UNBOUNDED,
}


class PIQPSolver:
    """A QP solver by PIQP; problems are dense or sparse as their matrices are.

    Settings are PIQP's own, by name; a name or value that it does not take is refused.
    """

    def __init__(
        self, *, tolerance: float = 1e-12, settings: Mapping[str, Any] | None = None
    ) -> None:
        """Choose the tolerance of residuals and duality gap, and any further settings by name."""
        self._settings: dict[str, Any] = {
            "eps_abs": tolerance,
            "eps_rel": tolerance,
            "eps_duality_gap_abs": tolerance,
            "eps_duality_gap_rel": tolerance,
            "max_iter": 100,
            # Problems come scaled: three sweeps of equilibration do what PIQP's ten would.
            "preconditioner_iter": 3,
            **(settings or {}),
        }
        trial = piqp.DenseSolver().settings
        for name, value in self._settings.items():
            if name.startswith("_") or not hasattr(trial, name):
                raise InputError(f"PIQP has no setting {name!r}")
            try:
                setattr(trial, name, value)
            except TypeError as error:
                raise InputError(f"PIQP setting {name!r} cannot be {value!r}") from error

    def solve(self, problem: QPProblem) -> QPSolution:
        """Solve one QP from scratch (an interior point method has no warm start)."""
        sparse = is_sparse(problem.P)
        solver = piqp.SparseSolver() if sparse else piqp.DenseSolver()
        for name, value in self._settings.items():
            setattr(solver.settings, name, value)
        rows, equations = problem.h.size > 0, problem.b.size > 0
        symmetric = not sparse and problem.P.flags.c_contiguous
        solver.setup(
            # P is symmetric: its transpose is the column-major copy that PIQP wants.
            problem.P.T if symmetric else column_major(problem.P),
            problem.c,
            column_major(problem.A) if equations else None,
            problem.b if equations else None,
            column_major(problem.G) if rows else None,
            problem.h if rows else None,
            None,
            problem.lower,
            problem.upper,
        )
        status = solver.solve()
        result = solver.result
        return verified(
            problem,
            result.x,
            QPMultipliers(
                rows=np.array(result.z_l) if rows else np.zeros(0),
                equalities=-np.array(result.y) if equations else np.zeros(0),
                lower=np.array(result.z_bl),
                upper=np.array(result.z_bu),
            ),
            otherwise=STATUSES.get(status, QPStatus.UNSOLVED),
            iterations=int(result.info.iter),
        )
