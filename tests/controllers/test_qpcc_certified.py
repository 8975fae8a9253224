"""The QPCC solver on stored instances with a certified global minimum, where they are at hand."""

from __future__ import annotations

import glob
import os
from typing import Any

import numpy as np
import pytest

from warp_softbody.controllers.full_form import force_map, to_full
from warp_softbody.controllers.qpcc import ContactQPCC, FloatArray
from warp_softbody.controllers.result import SolverOptions
from warp_softbody.controllers.solver import solve_qpcc, solve_static

FOLDER = os.environ.get("QPCC_INSTANCES", "")
CERTIFIED = sorted(glob.glob(f"{FOLDER}/contact_3d_nc8_*.npz")) if FOLDER else []


@pytest.mark.skipif(not CERTIFIED, reason="QPCC_INSTANCES names no folder of instances")
@pytest.mark.parametrize("path", CERTIFIED)
def test_certified_global_minima_are_reached(path: str) -> None:
    data = np.load(path)
    problem = read_instance(data)
    result = solve_qpcc(problem, options=SolverOptions(kicks=40, max_qps=120))
    assert result.complementarity < 1e-8
    gain = solve_static(problem).objective - float(data["f_best"])
    assert -1e-4 * gain < result.objective - float(data["f_best"]) < 5e-3 * gain


def read_instance(data: dict[str, FloatArray]) -> ContactQPCC:
    """A stored instance in general form (directions are +t1, -t1, +t2, -t2 in some order)."""
    k, m, nu = int(data["nc"]), int(data["m_dirs"]), int(data["nu"])
    physics: dict[str, Any] = {
        "lower": data["lb"][:nu],
        "upper": data["ub"][:nu],
        "velocity_offset": data["v0"],
        "velocity_from_controls": data["B"],
        "velocity_from_forces": data["W"],
    }
    rows = data["R"][1 : m + 1, :nu]
    directions = np.linalg.lstsq(data["B"][1:3].T, rows.T, rcond=None)[0].T
    order = np.argsort(np.round(np.arctan2(directions[:, 1], directions[:, 0]), 9) % (2 * np.pi))
    directions = directions[order] / np.linalg.norm(directions[order], axis=1)[:, None]
    law: dict[str, Any] = {"friction": np.full(k, float(data["mu"])), "directions": directions}
    size = nu + 3 * k
    bare = ContactQPCC(hessian=np.zeros((size, size)), gradient=np.zeros(size), **physics, **law)
    within = [nu + (m + 2) * i + np.r_[0, 1 + order, m + 1] for i in range(k)]
    column = np.concatenate([np.arange(nu), *within])
    back = np.linalg.pinv(force_map(bare))
    problem = ContactQPCC(
        hessian=back.T @ data["Q"][np.ix_(column, column)] @ back,
        gradient=back.T @ data["c"][column],
        constant=float(data["c0"]),
        **physics,
        **law,
    )
    full, pairs = to_full(problem), column[nu:] - nu
    np.testing.assert_allclose(full.Q, data["Q"][np.ix_(column, column)], atol=1e-9)
    np.testing.assert_allclose(full.R, data["R"][np.ix_(pairs, column)], atol=1e-9)
    np.testing.assert_allclose(full.r0, data["r0"][pairs], atol=1e-9)
    return problem
