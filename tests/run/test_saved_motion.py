"""A motion that was kept goes on to the last bit, and muscles that are driven pull."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from warp_softbody import Plane, Push, Scene, Simulation, SimulationOptions, characters, controllers
from warp_softbody.arrays import FloatArray
from warp_softbody.errors import InputError

LETTER = characters.letter_i(coarse=1)
PUSH = Push(region="head", force=(400.0, 100.0, 0.0), start=0.05, duration=0.1)
SCENE = Scene(character=LETTER, ground=Plane(), pushes=(PUSH,))


def places(simulation: Simulation, steps: int) -> list[FloatArray]:
    found = []
    for _ in range(steps):
        simulation.step()
        found.append(simulation.state.positions.numpy().copy())
    return found


@pytest.mark.parametrize("steps", [2, 6, 10])
@pytest.mark.parametrize("preconditioner", ["factor", "two_level"])
def test_goes_on_to_the_last_bit(steps: int, preconditioner: str) -> None:
    """Before, in and after a push; in the same simulation and in another one."""
    options = SimulationOptions(time_step=1 / 60, preconditioner=preconditioner)  # type: ignore[arg-type]
    simulation = Simulation(SCENE, options=options)
    simulation.drive(np.linspace(0.6, 1.0, LETTER.segment_count))
    places(simulation, steps)
    saved = simulation.save()
    once = places(simulation, 12)
    places(simulation, 5)
    for other in (simulation, Simulation(SCENE, options=options)):
        other.restore(saved)
        assert other.time == pytest.approx(steps / 60)
        for one, again in zip(once, places(other, 12), strict=True):
            np.testing.assert_array_equal(one, again)


def test_driven_muscles_shorten_the_body() -> None:
    simulation = Simulation(Scene(character=LETTER, ground=Plane()), time_step=1 / 60)
    height = LETTER.mesh.points[:, 2].max()
    simulation.drive(np.full(LETTER.segment_count, 0.6))
    contracted = places(simulation, 60)[-1][:, 2].max()
    simulation.drive(None)
    slack = places(simulation, 90)[-1][:, 2].max()
    assert contracted < 0.93 * height
    assert slack > 0.98 * height


def test_what_cannot_be_driven_or_kept() -> None:
    controlled = Simulation(SCENE, controllers.Balance(), time_step=1 / 60)
    free = Simulation(SCENE, time_step=1 / 60)
    with pytest.raises(InputError, match="drive: a controller drives the muscles"):
        controlled.drive(None)
    with pytest.raises(InputError, match="a SavedMotion with 1 controlled bodies cannot be"):
        free.restore(controlled.save())
    with pytest.raises(InputError, match=r"must be from 0.5 to 1, not 0.1 to 0.1"):
        free.drive(np.full(LETTER.segment_count, 0.1))
    with pytest.raises(InputError, match="activations of drive"):
        free.drive([0.7])
    limp = Simulation(Scene(character=replace(LETTER, muscles=())), time_step=1 / 60)
    with pytest.raises(InputError, match="a simulation of the same scene alone"):
        limp.restore(free.save())
