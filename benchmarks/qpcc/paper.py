"""The paper's experiment made again: static contacts, our search and exhaustive search."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.qpcc.sequences import problems_of
from warp_softbody.controllers import (
    ContactQPCC,
    SolverOptions,
    enumerate_qpcc,
    solve_qpcc,
    solve_static,
)

CONTACTS = 4

ONLINE = SolverOptions(max_qps=20, kicks=12)
"""What the paper's target allows."""


@dataclass(frozen=True, kw_only=True)
class MethodComparison:
    """One problem: objective of the three, and the QPs that ours took."""

    static: float
    ours: float
    exhaustive: float
    qps: int


def problems(count: int = 10) -> list[ContactQPCC]:
    """Problems of a pushed character in which four patches touch, spread over the run."""
    run = [p for p in problems_of("balance-i", 3.0, {"push": 0.5}) if p.contact_count >= CONTACTS]
    chosen = np.linspace(0, len(run) - 1, min(count, len(run))).astype(int)
    return [_four(run[i]) for i in chosen]


def trial(
    problem: ContactQPCC, previous: tuple[int, ...] | None
) -> tuple[MethodComparison, tuple[int, ...]]:
    """Solve one problem three times; exhaustive search is 18^4 QPs, a minute or more."""
    ours = solve_qpcc(problem, start=previous, options=ONLINE)
    row = MethodComparison(
        static=solve_static(problem).objective,
        ours=ours.objective,
        exhaustive=enumerate_qpcc(problem).objective,
        qps=ours.qp_count,
    )
    return row, ours.modes


def gap_ratio(trials: list[MethodComparison]) -> float:
    """Mean gap of the static baseline over the mean gap of ours, gaps to exhaustive search."""
    static = np.mean([row.static - row.exhaustive for row in trials])
    ours = np.mean([row.ours - row.exhaustive for row in trials])
    return float(static / ours) if ours > 0.0 else np.inf


def _four(problem: ContactQPCC) -> ContactQPCC:
    """The four contacts that come nearest to touching; the others are left out."""
    near = np.sort(np.argsort(problem.velocity_offset[::3], kind="stable")[:CONTACTS])
    rows = (3 * near[:, None] + np.arange(3)).reshape(-1)
    nu = problem.control_count
    z = np.r_[np.arange(nu), nu + rows]
    return ContactQPCC(
        hessian=problem.hessian[np.ix_(z, z)],
        gradient=problem.gradient[z],
        constant=problem.constant,
        lower=problem.lower,
        upper=problem.upper,
        velocity_offset=problem.velocity_offset[rows],
        velocity_from_controls=problem.velocity_from_controls[rows],
        velocity_from_forces=problem.velocity_from_forces[np.ix_(rows, rows)],
        friction=problem.friction[near],
        directions=problem.directions,
    )
