"""Ours and other solvers on stored instances: ``python -m benchmarks.qpcc --peers``."""

from __future__ import annotations

import importlib
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from benchmarks.qpcc import instances
from benchmarks.qpcc.peers.answer import PeerAnswer
from warp_softbody.controllers.qpcc import QPCC, solve_qpcc

PEERS = {
    "SCIP": ("pyscipopt", "benchmarks.qpcc.peers.scip"),
    "Ipopt": ("casadi", "benchmarks.qpcc.peers.ipopt"),
    "MPECSS": ("mpecss", "benchmarks.qpcc.peers.mpecss"),
}
"""The package each needs, and the file that calls it."""

LARGEST = 130
"""Variables above which instances are left out: the slowest of them takes minutes there."""


@dataclass(frozen=True, kw_only=True)
class PeerRow:
    """One solver on all instances.

    Attributes:
        name: of the solver.
        solved: instances at the best known value.
        proved: of these, those with a proof.
        count: instances tried.
        median: ms of CPU time.
    """

    name: str
    solved: int
    proved: int
    count: int
    median: float


def print_comparison(folder: str, time_limit: float = 20.0) -> None:
    """Print a row for each solver at hand, and a sentence for each that is not."""
    chosen = [path for path in instances.paths(folder) if _is_small(path)]
    solvers: dict[str, Callable[[QPCC], PeerAnswer]] = {"ours": _ours}
    for name, (package, module) in PEERS.items():
        try:
            importlib.import_module(package)
        except ImportError:
            print(f"{name} is left out: the package {package} is not installed.")
            continue
        solve = importlib.import_module(module).solve
        solvers[name] = partial(solve, time_limit=time_limit)
    print("LCQPow is left out: no package index has it, and it is built from source alone.")
    print(f"{'solver':10}{'at the best value':>20}{'proved':>9}{'median ms':>12}")
    for name, solve in solvers.items():
        row = _row(name, solve, chosen)
        print(
            f"{row.name:10}{f'{row.solved} of {row.count}':>20}{row.proved:9d}{row.median:12.1f}",
            flush=True,
        )


def _is_small(path: str) -> bool:
    with np.load(path) as data:
        return bool(data["Q"].shape[0] <= LARGEST and np.isfinite(data["f_best"]))


def _row(name: str, solve: Callable[[QPCC], PeerAnswer], paths: list[str]) -> PeerRow:
    solved, proved, times = 0, 0, []
    for path in paths:
        problem, best = QPCC.load(path), float(np.load(path)["f_best"])
        answer = solve(problem)
        times.append(answer.seconds)
        if answer.x is None:
            continue
        size = max(abs(best), instances.ABSOLUTE / instances.RELATIVE)
        reached = (problem.objective(answer.x) - best) / size <= instances.RELATIVE
        solved += reached
        proved += reached and answer.verdict == "optimal"
    return PeerRow(
        name=name,
        solved=solved,
        proved=proved,
        count=len(paths),
        median=1e3 * float(np.median(times)),
    )


def _ours(problem: QPCC) -> PeerAnswer:
    began = time.process_time()
    result = solve_qpcc(problem)
    proved = result.status.name == "GLOBAL"
    return PeerAnswer(
        verdict="optimal" if proved else "point" if result.status.usable else "none",
        x=result.x if result.status.usable else None,
        seconds=time.process_time() - began,
        bound=result.lower_bound,
    )
