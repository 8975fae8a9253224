"""A linear solve that does not converge is told in the step's status and counted in the summary."""

from __future__ import annotations

from typing import Any

import pytest

from benchmarks.stability_bodies import bar_mesh, body
from tests.bodies import rig
from warp_softbody import Scene, Simulation, SimulationOptions

OUT_OF_REACH = 1e-18
"""A relative residual below double precision."""

FEW: dict[str, Any] = {
    "max_iterations": 1,
    "tolerance": OUT_OF_REACH,
    "time_step": 0.01,
    "precision": "float64",
}


def test_step_tells_that_it_did_not_converge() -> None:
    character = body(bar_mesh())
    hanging = rig(character, gravity=(0.0, 0.0, -9.81), **FEW)
    for _ in range(3):
        statistics = hanging.step()
        assert not statistics.converged
        assert statistics.finite


def test_step_tells_that_it_converged() -> None:
    hanging = rig(body(bar_mesh()), gravity=(0.0, 0.0, -9.81), time_step=0.01)
    assert hanging.step().converged


def test_summary_counts_steps_that_did_not_converge() -> None:
    options = SimulationOptions(**FEW)
    simulation = Simulation(Scene(character=body(bar_mesh())), options=options, fps=100.0)
    for _ in range(5):
        simulation.step()
    assert simulation.summary().unconverged_steps == 5


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_summary_of_a_run_that_converges_counts_none(precision: str) -> None:
    options = SimulationOptions(time_step=0.01, precision=precision)  # type: ignore[arg-type]
    simulation = Simulation(Scene(character=body(bar_mesh())), options=options, fps=100.0)
    for _ in range(5):
        simulation.step()
    assert simulation.summary().unconverged_steps == 0
