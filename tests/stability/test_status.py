"""A linear solve that does not converge is told in the step's status and counted in the summary."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from benchmarks.stability.bodies import bar_mesh, body
from tests.support.bodies import rig
from warp_softbody import Scene, Simulation, SimulationOptions
from warp_softbody.body.mesh_geometry import shortest_edge
from warp_softbody.engine.options import Precision
from warp_softbody.errors import NotFiniteError

OUT_OF_REACH = 1e-60
"""A relative residual that no iteration comes to, even by its own recurrence."""

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


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_a_body_beyond_the_numbers_is_an_error(precision: Precision) -> None:
    """Finite, but so far away that rounding moves nodes by more than the shortest edge."""
    mesh = bar_mesh()
    shortest = shortest_edge(mesh.points, mesh.tets)
    beyond = 4.0 * shortest / float(np.finfo(precision).eps)
    for share, resolved in ((0.01, True), (1.0, False)):
        speed = (share * beyond / 0.01, 0.0, 0.0)
        scene = Scene(character=body(mesh, clamped=False), initial_velocity=speed)
        options = SimulationOptions(time_step=0.01, precision=precision)
        simulation = Simulation(scene, options=options, fps=100.0)
        if resolved:
            simulation.step()
            continue
        with pytest.raises(NotFiniteError, match=f"too far away for {precision} to tell") as caught:
            simulation.step()
        assert caught.value.step == 0
