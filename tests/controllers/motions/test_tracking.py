"""Following a path and learning what a plan misses, on a point mass with known answers."""

from __future__ import annotations

import numpy as np
import pytest

from warp_softbody import Scene
from warp_softbody.arrays import FloatArray
from warp_softbody.characters import letter_i
from warp_softbody.controllers.motions.tracking import MissingRate, following
from warp_softbody.world.view import BodyView

SCENE = Scene(character=letter_i())
COUNT = len(SCENE.character.mesh.points)
REST = SCENE.character.mesh.points - SCENE.character.mesh.points.mean(axis=0)
STEPS = (1e-3, 1.0 / 60.0, 0.1, 1.0)  # s
GAINS = (400.0, 40.0)  # 1/s^2, 1/s


def seen(place: FloatArray, speed: FloatArray, time: float, step: float) -> BodyView:
    """A body of 2 kg whose nodes all move alike."""
    return BodyView(
        scene=SCENE,
        time=time,
        time_step=step,
        masses=np.full(COUNT, 2.0 / COUNT),
        positions=REST + place,
        velocities=np.tile(speed, (COUNT, 1)),
        touching=np.zeros(COUNT, dtype=bool),
        activations=np.ones(0),
    )


def sine(time: float) -> FloatArray:
    return np.array([0.1 * np.sin(3.0 * time), 0.0, 0.5])


@pytest.mark.parametrize("step", STEPS)
def test_a_body_on_the_path_stays_on_it_at_any_step(step: float) -> None:
    place, speed = sine(0.0), (sine(0.0) - sine(-step)) / step
    for k in range(40):
        view = seen(place, speed, k * step, step)
        path = np.array([sine((k + n) * step) for n in (-1, 0, 1)])
        speed = speed + step * following(view, path, *GAINS) / view.mass
        place = place + step * speed
        assert np.abs(place - sine((k + 1) * step)).max() < 1e-11


@pytest.mark.parametrize("step", STEPS)
def test_a_body_off_the_path_comes_back_at_any_step(step: float) -> None:
    """Spring and damper are critical: implicit Euler shrinks the way by (1 + 20 dt) a step."""
    place, speed, count = sine(0.0), np.zeros(3), 60
    place[0] += 0.1
    path = np.tile(sine(0.0), (3, 1))
    for k in range(count):
        view = seen(place, speed, k * step, step)
        speed = speed + step * following(view, path, *GAINS) / view.mass
        place = place + step * speed
    shrunk = (1.0 + 20.0 * step) ** -count
    wanted = 0.1 * shrunk * (1.0 + count * 20.0 * step / (1.0 + 20.0 * step))
    assert place[0] == pytest.approx(wanted, rel=1e-6, abs=1e-12)


@pytest.mark.parametrize("step", STEPS)
def test_a_force_that_the_plan_misses_is_learnt(step: float) -> None:
    """What is still missing shrinks by (1 + dt / time) a step."""
    missed, wanted, time = np.array([3.0, 0.0, -2.0]), np.array([1.0, 0.0, 0.0]), 0.05
    missing, momentum, count = MissingRate(time), np.zeros(3), 5
    for k in range(count):
        view = seen(np.zeros(3), momentum / 2.0, k * step, step)
        rate = missing.made_up(view, wanted) - missed
        momentum = momentum + step * rate
    left = (1.0 + step / time) ** (1 - count)
    assert rate == pytest.approx(wanted - missed * left, abs=1e-9 / step)


def test_no_more_is_learnt_than_a_share_of_the_weight() -> None:
    missing = MissingRate(0.0)
    for k in range(3):
        rate = missing.made_up(seen(np.zeros(3), np.zeros(3), 0.1 * k, 0.1), np.array([1e3, 0, 0]))
    assert rate[0] == pytest.approx(1e3 + 0.3 * 2.0 * 9.81)
