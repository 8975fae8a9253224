"""Scenes at rest are left alone, and nothing is lost by it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.support.bodies import box, muscular_bar
from warp_softbody import Body, Character, Material, Plane, Push, Scene, Simulation, placed
from warp_softbody.arrays import FloatArray
from warp_softbody.controllers import Goals
from warp_softbody.controllers.objectives import linear_momentum
from warp_softbody.engine.options import SimulationOptions
from warp_softbody.run.sleep import STILL_SECONDS, STILL_SPEED, Sleep
from warp_softbody.world.view import BodyView

CUBE = Character(
    name="cube",
    mesh=box((3, 3, 3), (0.3, 0.3, 0.3)),
    material=Material(young_modulus=1e5, poisson_ratio=0.4, stiffness_damping=0.02),
    regions={"all": np.arange(64, dtype=np.int32)},
)
DROPPED = Scene(character=placed(CUBE, translation=(0.0, 0.0, 0.05)), ground=Plane(friction=0.5))


def after(scene: Scene, seconds: float, **options: Any) -> Simulation:
    simulation = Simulation(scene, options=SimulationOptions(time_step=0.01, **options), fps=100.0)
    for _ in range(round(seconds * 100.0)):
        simulation.step()
    return simulation


def places(simulation: Simulation) -> FloatArray:
    return np.array(simulation.state.positions.numpy(), dtype=np.float64)


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_dropped_cube_falls_asleep(precision: str) -> None:
    """And stands where one that is never left alone stands, to what a mode may still have swung.

    Single precision adds the creep of rounding: steps of 5e-6 m/s to and fro.
    """
    asleep, awake = (after(DROPPED, 6.0, precision=precision, sleep=s) for s in (True, False))
    assert asleep.summary().slept_steps > 200
    assert awake.summary().slept_steps == 0
    assert np.abs(places(asleep) - places(awake)).max() < 5e-5


def test_push_wakes_it() -> None:
    """The same motion after the push as without sleep, but for where it stood before."""
    push = Push(region="all", force=(150.0, 0.0, 0.0), start=5.0, duration=0.2)
    scene = replace(DROPPED, pushes=(push,))
    before, asleep, awake = (
        after(scene, 4.9),
        after(scene, 5.6),
        after(scene, 5.6, sleep=False),
    )
    moved = places(asleep)[:, 0].mean() - places(before)[:, 0].mean()
    assert before.summary().slept_steps > 100
    assert moved > 0.01
    expected = places(awake)[:, 0].mean() - places(before)[:, 0].mean()
    assert moved == pytest.approx(expected, rel=0.02)


def test_falling_neighbour_keeps_all_awake() -> None:
    """A scene sleeps as a whole: one body at rest does not hide another in flight."""
    high = placed(CUBE, name="high", translation=(2.0, 0.0, 6.0))
    simulation = after(replace(DROPPED, others=(Body(character=high),)), 1.0)
    assert simulation.summary().slept_steps == 0


def test_slow_swing_is_not_taken_for_rest() -> None:
    """A bar clamped at one end swings with 1.2 s and little damping; it goes on.

    The swing is slow for an instant at each turn; the window is longer than that.
    """
    mesh = box((8, 1, 1), (1.0, 0.05, 0.05))
    bar = Character(
        name="bar",
        mesh=mesh,
        material=Material(young_modulus=4e5, poisson_ratio=0.3, stiffness_damping=0.0),
        fixed=np.flatnonzero(mesh.points[:, 0] < 1e-9).astype(np.int32),
    )
    asleep, awake = (
        after(Scene(character=bar, gravity=(0.0, 0.0, -0.01)), 4.0, sleep=s) for s in (True, False)
    )
    assert asleep.summary().slept_steps == 0
    np.testing.assert_array_equal(places(asleep), places(awake))


class Holds:
    """Wants no momentum for a while, then nothing."""

    def __init__(self, seconds: float) -> None:
        """For so long."""
        self._seconds = seconds

    def goals(self, view: BodyView) -> Goals | None:
        """See `Controller`."""
        if view.time > self._seconds:
            return None
        return Goals(objectives=(linear_momentum(view, np.zeros(3)),))


def test_controlled_body_sleeps_only_when_limp() -> None:
    """While the controller wants something, its muscles may move at any step."""
    scene = Scene(character=muscular_bar(), ground=Plane(friction=0.5))
    simulation = Simulation(scene, Holds(1.0), time_step=0.01, fps=100.0)
    for _ in range(100):
        simulation.step()
    assert simulation.summary().slept_steps == 0
    for _ in range(500):
        simulation.step()
    assert simulation.summary().slept_steps > 100


def test_sleep_needs_the_whole_window() -> None:
    sleep = Sleep(0.01, allowed=True)
    for _ in range(round(STILL_SECONDS / 0.01) - 1):
        sleep.note(0.9 * STILL_SPEED, acted=False)
    assert not sleep.asleep
    sleep.note(1.1 * STILL_SPEED, acted=False)
    for _ in range(round(STILL_SECONDS / 0.01)):
        assert not sleep.asleep
        sleep.note(0.0, acted=False)
    assert sleep.asleep
    sleep.note(0.0, acted=True)
    assert not sleep.asleep


def test_summary_tells() -> None:
    assert "steps left out" in str(after(DROPPED, 6.0).summary())
    assert "left out" not in str(after(DROPPED, 0.5).summary())
