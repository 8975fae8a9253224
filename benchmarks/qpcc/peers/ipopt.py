"""Ipopt (``pip install casadi``) on the relaxation of Scholtes: left_i right_i <= t, t falling."""

from __future__ import annotations

import time

import numpy as np

from benchmarks.qpcc.peers.answer import PeerAnswer
from warp_softbody.controllers.qpcc import QPCC

STEPS = 10.0 ** -np.arange(0, 9)
"""Values of t."""


def solve(problem: QPCC, time_limit: float = 60.0) -> PeerAnswer:
    """A local point from the origin, clipped to the bounds."""
    import casadi

    began = time.process_time()
    n = problem.variable_count
    x, t = casadi.SX.sym("x", n), casadi.SX.sym("t")
    left, right = problem.L @ x + problem.l0, problem.R @ x + problem.r0
    rows = [problem.A @ x, problem.G @ x, left, right, left * right - t]
    pairs = problem.pair_count
    zeros, free = np.zeros(pairs), np.full(pairs, np.inf)
    low = np.concatenate([problem.b, problem.h_lower, zeros, zeros, -free])
    high = np.concatenate([problem.b, problem.h, free, free, zeros])
    program = {
        "x": x,
        "p": t,
        "f": 0.5 * casadi.bilin(problem.Q, x, x) + casadi.dot(problem.c, x),
        "g": casadi.vertcat(*rows),
    }
    options = {
        "print_time": False,
        "ipopt.print_level": 0,
        "ipopt.sb": "yes",
        "ipopt.tol": 1e-9,
        "ipopt.max_cpu_time": time_limit,
    }
    solver = casadi.nlpsol("solver", "ipopt", program, options)
    point = np.clip(np.zeros(n), problem.lb, problem.ub)
    for value in STEPS:
        if time.process_time() - began > time_limit:
            break
        answer = solver(x0=point, p=value, lbx=problem.lb, ubx=problem.ub, lbg=low, ubg=high)
        point = np.array(answer["x"]).reshape(-1)
    miss = max(problem.complementarity(point), problem.feasibility(point))
    found = np.all(np.isfinite(point)) and miss < 1e-4
    return PeerAnswer(
        verdict="point" if found else "none",
        x=point if found else None,
        seconds=time.process_time() - began,
    )
