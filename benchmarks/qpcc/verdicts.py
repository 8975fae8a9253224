"""Verdicts on random problems in odd units, judged by SCIP on the same problems in plain ones."""

from __future__ import annotations

import importlib.util
from collections import Counter
from dataclasses import dataclass

import numpy as np

from benchmarks.qpcc.peers import scip
from benchmarks.qpcc.peers.answer import PeerAnswer
from benchmarks.qpcc.random_problems import ScaledCase, cases
from warp_softbody.controllers.qpcc import QPCC, GeneralResult, QPCCStatus, solve_qpcc

APART = 1e-5
"""Relative difference of two objectives that is more than the judge's own tolerance makes."""

ROUNDING = 1e-9
"""Change along a ray, relative to what it is summed up of, that is none."""

CONSISTENT = 1e-6
"""Largest violation of a point of the judge that counts."""


@dataclass(frozen=True)
class Judgement:
    """What was said of a problem in odd units.

    Attributes:
        name: of the problem.
        status: what the solver claimed.
        false: what is wrong with the claim; empty where nothing is known to be.
    """

    name: str
    status: QPCCStatus
    false: str


def judged(case: ScaledCase) -> Judgement:
    """Solve a problem in odd units, and have the claim judged on the plain problem."""
    result = solve_qpcc(case.scaled)
    answer = scip.solve(case.plain)
    return Judgement(case.name, result.status, fault(case, result, answer))


def fault(case: ScaledCase, result: GeneralResult, answer: PeerAnswer) -> str:
    """What is wrong with a claim by the judge's point or its own ray; empty if nothing is."""
    status, best = result.status, None
    if answer.x is not None and violation(case.plain, answer.x) <= CONSISTENT:
        best = objective(case.plain, answer.x)
    if status is QPCCStatus.INFEASIBLE:
        return "" if best is None else "there is a point"
    if status is QPCCStatus.UNBOUNDED:
        # the judge, to whom 1e20 is infinite, takes slopes of 1e-6 for none
        return "" if falls(case.scaled, result) else "the ray is none"
    if status is QPCCStatus.GLOBAL and best is not None:
        ours = result.objective / case.factor
        if ours - best > APART * max(1.0, abs(best), abs(ours)):
            return f"{ours:.9g} is no minimum, {best:.9g} is lower"
    return ""


def falls(problem: QPCC, result: GeneralResult) -> bool:
    """Whether the objective falls along the ray of a result for ever, within the constraints."""
    ray = result.ray
    if ray is None or not problem.c @ ray + result.x @ problem.Q @ ray < 0.0:
        return False
    size = np.abs(ray)

    def least(matrix: np.ndarray) -> np.ndarray:
        """Changes along the ray, those of rounding alone being none."""
        change = matrix @ ray
        return np.where(np.abs(change) <= ROUNDING * (np.abs(matrix) @ size), 0.0, change)

    left, right = least(problem.L), least(problem.R)
    sides = (problem.L @ result.x + problem.l0, problem.R @ result.x + problem.r0)
    level = not np.any(least(problem.Q)) and not np.any(least(problem.A))
    inside = np.all(least(problem.G)[np.isfinite(problem.h)] <= 0.0)
    inside &= np.all(least(problem.G)[np.isfinite(problem.h_lower)] >= 0.0)
    inside &= np.all(ray[np.isfinite(problem.lb)] >= 0.0)
    inside &= np.all(ray[np.isfinite(problem.ub)] <= 0.0)
    closed = (np.abs(sides[0]) <= np.abs(sides[1])) & (left == 0.0) & (right >= 0.0)
    closed |= (np.abs(sides[1]) <= np.abs(sides[0])) & (right == 0.0) & (left >= 0.0)
    return bool(level and inside and closed.all())


def objective(problem: QPCC, x: np.ndarray) -> float:
    """Of a point."""
    return float(0.5 * x @ problem.Q @ x + problem.c @ x + problem.c0)


def violation(problem: QPCC, x: np.ndarray) -> float:
    """By how much a point misses an equation, a bound or a pair."""
    left, right = problem.L @ x + problem.l0, problem.R @ x + problem.r0
    parts = [
        np.abs(problem.A @ x - problem.b),
        problem.G @ x - problem.h,
        problem.h_lower - problem.G @ x,
        problem.lb - x,
        x - problem.ub,
        np.abs(np.minimum(left, right)),
    ]
    return float(max((part.max() for part in parts if part.size), default=0.0))


def print_verdicts(count: int, seed: int = 0) -> None:
    """How many claims of each kind there were, and every false one."""
    if importlib.util.find_spec("pyscipopt") is None:
        print("Verdicts are judged by SCIP: pip install pyscipopt.")
        return
    found = [judged(case) for case in cases(count, seed)]
    wrong = [one for one in found if one.false]
    for one in wrong:
        print(f"{one.name}: {one.status.name}, but {one.false}")
    claims = Counter(one.status.name for one in found)
    print(
        f"{count} random problems in odd units: "
        + ", ".join(f"{number} {name}" for name, number in sorted(claims.items()))
        + f"; {len(wrong)} claims are false by SCIP"
    )
