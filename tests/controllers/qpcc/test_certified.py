"""The QPCC solver on stored instances with a certified global minimum, where they are at hand."""

from __future__ import annotations

import glob
import os

import numpy as np
import pytest

from benchmarks.qpcc.instances import general_row, read_contact
from warp_softbody.controllers.qpcc.contact.complementarity_form import to_full
from warp_softbody.controllers.qpcc.solve import solve_qpcc, solve_static

FOLDER = os.environ.get("QPCC_INSTANCES", "")
CERTIFIED = sorted(glob.glob(f"{FOLDER}/contact_3d_nc8_*.npz")) if FOLDER else []


@pytest.mark.skipif(not CERTIFIED, reason="QPCC_INSTANCES names no folder of instances")
@pytest.mark.parametrize("path", CERTIFIED)
def test_certified_global_minima_are_reached(path: str) -> None:
    data = np.load(path)
    problem = read_contact({name: data[name] for name in data.files})
    result = solve_qpcc(problem)
    assert result.complementarity < 1e-8
    gain = solve_static(problem).objective - float(data["f_best"])
    assert -1e-4 * gain < result.objective - float(data["f_best"]) < 5e-3 * gain


@pytest.mark.skipif(not CERTIFIED, reason="QPCC_INSTANCES names no folder of instances")
@pytest.mark.parametrize("path", CERTIFIED)
def test_the_reader_keeps_the_objective_and_the_pairs(path: str) -> None:
    data = np.load(path)
    k, m, nu = int(data["nc"]), int(data["m_dirs"]), int(data["nu"])
    full = to_full(read_contact({name: data[name] for name in data.files}))
    np.testing.assert_allclose(np.linalg.eigvalsh(full.Q), np.linalg.eigvalsh(data["Q"]), atol=1e-9)
    assert full.Q.shape == (nu + k * (m + 2),) * 2


SMALL = sorted(glob.glob(f"{FOLDER}/macmpec_ex9*.npz")) if FOLDER else []


@pytest.mark.skipif(not SMALL, reason="QPCC_INSTANCES names no folder of instances")
@pytest.mark.parametrize("path", SMALL)
def test_small_instances_reach_the_known_best_value(path: str) -> None:
    row = general_row(path)
    assert row.reached and row.residual < 1e-8
