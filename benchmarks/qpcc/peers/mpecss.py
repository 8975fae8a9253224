"""MPECSS (``pip install mpecss``): the relaxation of Scholtes with adaptive paths, and a polish.

It reads problems from files of CasADi functions, which are written for it.
"""

from __future__ import annotations

import contextlib
import io
import itertools
import json
import os
import tempfile
import time

import numpy as np

from benchmarks.qpcc.peers.answer import PeerAnswer
from warp_softbody.controllers.qpcc import QPCC

_NUMBERS = itertools.count()


def solve(problem: QPCC, time_limit: float = 60.0) -> PeerAnswer:
    """A local point from the origin, clipped to the bounds."""
    import casadi
    from mpecss.helpers.loaders.macmpec_loader import load_macmpec
    from mpecss.phase_2.mpecss import run_mpecss

    began = time.process_time()
    x = casadi.SX.sym("x", problem.variable_count)

    def function(name: str, expression: object) -> str:
        return str(casadi.Function(name, [x], [expression]).serialize())

    pairs = problem.pair_count
    data = {
        "lbw": _plain(problem.lb),
        "ubw": _plain(problem.ub),
        "w0": list(np.clip(np.zeros(problem.variable_count), problem.lb, problem.ub)),
        "f_fun": function("f", 0.5 * casadi.bilin(problem.Q, x, x) + casadi.dot(problem.c, x)),
        "G_fun": function("G", problem.L @ x + problem.l0),
        "H_fun": function("H", problem.R @ x + problem.r0),
        "lbG": [0.0] * pairs,
        "lbH": [0.0] * pairs,
    }
    if problem.b.size + problem.h.size:
        data["g_fun"] = function("g", casadi.vertcat(problem.A @ x, problem.G @ x))
        data["lbg"] = _plain(np.concatenate([problem.b, problem.h_lower]))
        data["ubg"] = _plain(np.concatenate([problem.b, problem.h]))
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()):
        # it keeps derivatives by the name of the file, whichever problem has it
        path = os.path.join(folder, f"problem_{next(_NUMBERS)}.nl.json")
        with open(path, "w", encoding="utf-8") as file:
            json.dump(data, file)
        try:
            made = load_macmpec(path)
            answer = run_mpecss(made, made["x0_fn"](0), {"wall_timeout": time_limit})
            point = np.asarray(answer["z_final"], np.float64).reshape(-1)
        except Exception:
            # it raises what its parts raise
            return PeerAnswer(verdict="none", x=None, seconds=time.process_time() - began)
    miss = max(problem.complementarity(point), problem.feasibility(point))
    found = np.all(np.isfinite(point)) and miss < 1e-4
    return PeerAnswer(
        verdict="point" if found else "none",
        x=point if found else None,
        seconds=time.process_time() - began,
    )


def _plain(bounds: object) -> list[float]:
    return [float(value) for value in np.clip(np.asarray(bounds), -1e20, 1e20)]
