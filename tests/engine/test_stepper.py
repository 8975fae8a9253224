"""The step as a program: repeatable, alike in both precisions, loud about numbers that are none."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.bodies import Rig, epsilon, muscular_bar, rig
from warp_softbody.engine.options import Precision
from warp_softbody.errors import NotFiniteError
from warp_softbody.run.simulation import Simulation
from warp_softbody.world.ground import Plane
from warp_softbody.world.scene import Scene

GRAVITY = (0.0, 0.0, -9.81)


def hopping_bar(precision: Precision) -> Rig:
    """A bar that falls 1 cm onto the ground with its muscles pulled."""
    character = muscular_bar(origin=(0.0, 0.0, 0.01))
    body = rig(
        character, ground=Plane(friction=0.6), gravity=GRAVITY, time_step=0.005, precision=precision
    )
    body.activate(np.linspace(0.8, 1.0, character.segment_count))
    return body


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_run_repeats_bit_for_bit(precision: Precision) -> None:
    first, second = hopping_bar(precision), hopping_bar(precision)
    first.step(40)
    second.step(40)
    assert first.positions.tobytes() == second.positions.tobytes()
    assert first.velocities.tobytes() == second.velocities.tobytes()


def test_precisions_agree_in_flight() -> None:
    """0.2 s of free motion: steps of eps in strain and of the solver's tolerance in momentum."""
    ends = []
    for precision in ("float32", "float64"):
        body = rig(
            muscular_bar(), gravity=GRAVITY, time_step=0.005, precision=precision, tolerance=1e-6
        )
        body.activate(np.linspace(0.8, 1.0, body.model.segment_count))
        body.place(velocities=(0.3, 0.0, 1.0))
        body.step(40)
        ends.append(body.positions)
    # largest speed about 1 m/s over 0.2 s; 40 steps that may each miss it by the tolerance,
    # and by the elastic force's rounding
    moved = np.abs(ends[1] - muscular_bar().mesh.points).max()
    bound = 40 * (1e-6 + 8 * epsilon("float32")) * moved
    np.testing.assert_allclose(ends[0], ends[1], atol=bound)


def test_precisions_agree_on_the_ground() -> None:
    """0.2 s with an impact, in which single nodes may change their mode a step apart."""
    ends = []
    for precision in ("float32", "float64"):
        body = hopping_bar(precision)
        body.step(40)
        ends.append(body.positions)
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-4)


def test_numbers_that_are_none_end_the_run() -> None:
    simulation = Simulation(Scene(character=muscular_bar()), time_step=0.01, fps=100.0)
    simulation.step()
    positions = simulation.state.positions.numpy()
    positions[3, 1] = np.nan
    simulation.state.positions.assign(positions)
    with pytest.raises(NotFiniteError, match="step 1") as caught:
        simulation.step()
    assert caught.value.step == 1
    assert caught.value.time == pytest.approx(0.01)
    assert simulation.summary().status == "not finite"


def test_numbers_that_are_none_end_a_run_on_the_ground() -> None:
    scene = Scene(character=muscular_bar(), ground=Plane())
    simulation = Simulation(scene, time_step=0.01, fps=100.0)
    simulation.step()
    simulation.control.external_forces.fill_(np.nan)
    with pytest.raises(NotFiniteError):
        simulation.step()


def test_frames_come_at_their_times() -> None:
    simulation = Simulation(Scene(character=muscular_bar()), time_step=1 / 100, fps=30.0)
    frames = list(simulation.run(0.2))
    times = [frame.time for frame in frames]
    np.testing.assert_allclose(times, np.arange(7) / 30.0, atol=1e-12)
    # four steps of 1/120 s a frame: the time step asked for is never exceeded
    assert simulation.model.options.time_step == pytest.approx(1 / 120)
