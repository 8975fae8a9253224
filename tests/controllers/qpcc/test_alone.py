"""The QPCC solver as a library of its own: what a fresh process loads for it."""

from __future__ import annotations

import json
import subprocess
import sys

PROGRAM = """
import json, sys
import numpy as np
from warp_softbody.controllers import qpcc

for name in qpcc.__all__:
    getattr(qpcc, name)
left, right = np.eye(2)[:1], np.eye(2)[1:]
pair = dict(L=left, l0=np.zeros(1), R=right, r0=np.zeros(1))
general = qpcc.solve_qpcc(qpcc.QPCC(Q=np.eye(2), c=np.array([-2.0, -1.0]), **pair))
contact = qpcc.solve_qpcc(
    qpcc.ContactQPCC(
        hessian=np.diag([1.0, 0.0, 0.0, 0.0]),
        gradient=np.zeros(4),
        lower=np.array([-1.0]),
        upper=np.array([1.0]),
        velocity_offset=np.array([-0.1, 0.0, 0.0]),
        velocity_from_controls=np.array([[0.0], [0.5], [0.0]]),
        velocity_from_forces=0.5 * np.eye(3),
        friction=0.5,
    )
)
print(json.dumps([sorted(sys.modules), general.status.name, contact.status.name]))
"""

FOUNDATIONS = ("errors", "arrays", "atomic_files", "contact_mode", "inputs")
"""What of the package it may import beside itself: nothing of these knows of bodies or engines."""

HEAVY = ("warp", "pxr", "trimesh", "meshio", "rich", "scipy.sparse", "scipy.optimize")


def loaded() -> tuple[set[str], str, str]:
    """Modules of a process that solves one problem of each form, and how both ended."""
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=True, timeout=120
    )
    modules, general, contact = json.loads(done.stdout)
    return set(modules), general, contact


def test_it_is_loaded_and_used_without_the_rest_of_the_package() -> None:
    modules, general, contact = loaded()
    assert (general, contact) == ("GLOBAL", "STRONGLY_STATIONARY")
    assert not modules.intersection(HEAVY)
    own = {name.split(".", 1)[1] for name in modules if name.startswith("warp_softbody.")}
    rest = {name for name in own if name.split(".")[0] not in FOUNDATIONS}
    solver = ("controllers.qp.", "controllers.qpcc.")
    assert {name for name in rest if not f"{name}.".startswith(solver)} == {"controllers"}
