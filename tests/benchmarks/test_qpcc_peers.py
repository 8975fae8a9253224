"""Other solvers are asked the problem that is meant."""

from __future__ import annotations

import numpy as np
import pytest

from warp_softbody.controllers.qpcc import QPCC


def nearest(count: int, target: float) -> QPCC:
    """In each of some planes, the point of the curve y = max(0, 1 - x) nearest (target, 1/2)."""
    eye, none = np.eye(count), np.zeros((count, count))
    wanted = np.r_[np.full(count, target), np.full(count, 0.5)]
    return QPCC(
        Q=2.0 * np.eye(2 * count),
        c=-2.0 * wanted,
        c0=float(wanted @ wanted),
        L=np.hstack([none, eye]),
        l0=np.zeros(count),
        R=np.hstack([eye, eye]),
        r0=-np.ones(count),
    )


@pytest.mark.parametrize(("package", "module"), [("mpecss", "mpecss"), ("casadi", "ipopt")])
def test_problems_of_several_sizes_one_after_the_other(package: str, module: str) -> None:
    """MPECSS keeps derivatives by the name of a problem."""
    pytest.importorskip(package)
    solve = __import__(f"benchmarks.qpcc.peers.{module}", fromlist=["solve"]).solve
    for count, target in ((1, 0.8), (3, 0.8), (2, 0.7)):
        problem = nearest(count, target)
        answer = solve(problem, time_limit=10.0)
        assert answer.x is not None and answer.x.shape == (2 * count,)
        # both pieces meet at (1, 0); the nearest point has x + y = 1
        least = count * 0.5 * (target - 0.5) ** 2
        assert problem.objective(answer.x) == pytest.approx(least, abs=1e-4)
