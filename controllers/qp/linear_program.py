"""Linear programs by HiGHS: a second opinion where a QP's own solver found no answer.

Nothing here is loaded before it is asked for. No other file knows HiGHS.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.qp.problem import QPMultipliers, QPProblem
from warp_softbody.controllers.qp.sparse_or_dense import Matrix, is_sparse

TOLERANCE = 1e-10
"""Of the simplex method, the least that HiGHS takes."""


@dataclass(frozen=True)
class LPSolution:
    """A vertex, its value, and the multipliers of rows and bounds as a QP has them."""

    x: FloatArray
    value: float
    multipliers: QPMultipliers


def solve_lp(problem: QPProblem, time_limit: float = np.inf) -> LPSolution | None:
    """The minimum of c'x on the points of a QP; None where there is none, or none was found."""
    from scipy.optimize import linprog

    options: Any = {
        "primal_feasibility_tolerance": TOLERANCE,
        "dual_feasibility_tolerance": TOLERANCE,
        "presolve": True,
    }
    if time_limit < np.inf:
        options["time_limit"] = max(time_limit, 1e-3)
    rows, equations = problem.h.size > 0, problem.b.size > 0
    solve: Any = linprog
    found = solve(
        problem.c,
        A_ub=-problem.G if rows else None,
        b_ub=-problem.h if rows else None,
        A_eq=problem.A if equations else None,
        b_eq=problem.b if equations else None,
        bounds=np.stack([problem.lower, problem.upper], axis=1),
        method="highs-ds",
        options=options,
    )
    if found.status != 0:
        return None
    return LPSolution(
        x=np.asarray(found.x, np.float64),
        value=float(found.fun),
        multipliers=QPMultipliers(
            rows=np.maximum(-found.ineqlin.marginals, 0.0) if rows else np.zeros(0),
            equalities=np.array(found.eqlin.marginals) if equations else np.zeros(0),
            lower=np.maximum(found.lower.marginals, 0.0),
            upper=np.maximum(-found.upper.marginals, 0.0),
        ),
    )


def least_violation(problem: QPProblem, time_limit: float = np.inf) -> LPSolution | None:
    """The point within the bounds whose rows miss least, by the sum of the misses.

    The value is that sum. Where it is not zero the multipliers of the rows prove that no point
    obeys them all.
    """
    count, equations, rows = len(problem.c), len(problem.b), len(problem.h)
    extra = 2 * equations + rows
    unit, none = np.eye(equations), np.zeros((rows, 2 * equations))
    elastic = QPProblem(
        P=problem.P,
        c=np.concatenate([np.zeros(count), np.ones(extra)]),
        A=_beside(problem.A, np.hstack([unit, -unit, np.zeros((equations, rows))])),
        b=problem.b,
        G=_beside(problem.G, np.hstack([none, np.eye(rows)])),
        h=problem.h,
        lower=np.concatenate([problem.lower, np.zeros(extra)]),
        upper=np.concatenate([problem.upper, np.full(extra, np.inf)]),
    )
    found = solve_lp(elastic, time_limit)
    if found is None:
        return None
    return LPSolution(found.x[:count], found.value, found.multipliers)


def _beside(matrix: Matrix, added: FloatArray) -> Matrix:
    if not is_sparse(matrix):
        return np.hstack([matrix, added])
    import scipy.sparse as sp

    return sp.hstack([matrix, sp.csr_array(added)], format="csr")
