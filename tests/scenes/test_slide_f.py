"""slide-f and its variants, measured from their stages."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.motions.criterion import RecordedMotion
from benchmarks.motions.measures import base_path
from tests.scenes.runs import Shipped, missed, run
from warp_softbody import scenes
from warp_softbody.world.scene import STANDARD_GRAVITY

FRICTION, PULL = 0.1, 0.27  # of the scene; pull in body weights
STARTS, STRONGEST, ENDS = 0.5, 3.0, 3.5  # s, of the pull
SCENES = ("slide-f", "slide-f-left", "slide-f-delayed")


def rests_at_the_end(motion: RecordedMotion) -> bool:
    """Whether the base has moved by less than 0.1 m in the last half second."""
    times, path = motion.measures.times, base_path(motion.take)[:, 0]
    return bool(np.ptp(path[times > times[-1] - 0.5]) < 0.1)


@pytest.mark.parametrize("scene", ["slide-f", "slide-f-left"])
def test_it_leans_against_the_pull_and_slides(scene: str, shipped: Shipped) -> None:
    motion = shipped(scene)
    assert missed(scene, motion) == []
    assert rests_at_the_end(motion)


def test_friction_cannot_hold_it_back_further(shipped: Shipped) -> None:
    """Friction is at most mu times the normal force, whose impulse is m g T plus a change of m v_z.

    So from when the pull exceeds mu m g until it is strongest, m v_x grows by the pull's impulse
    less that bound at least. Without the bound, by the pull's impulse at most.
    """
    motion = shipped("slide-f")
    take, measures = motion.take, motion.measures
    begins = STARTS + FRICTION / PULL * (STRONGEST - STARTS)
    path, times = measures.centre_of_mass, measures.times
    speed = np.gradient(path, times, axis=0)
    first, last = np.searchsorted(times, [begins, STRONGEST - 1.5 / take.fps])
    gained = speed[last] - speed[first]
    length = times[last] - times[first]
    pulled = np.interp(times, [STARTS, STRONGEST], [0.0, PULL])[first : last + 1]
    pull = STANDARD_GRAVITY * np.trapezoid(pulled, times[first : last + 1])
    bound = FRICTION * (STANDARD_GRAVITY * length + gained[2])
    # A central difference is the mean over two frames, so a frame of the forces may be missed.
    unseen = (PULL + FRICTION) * STANDARD_GRAVITY / take.fps
    assert gained[0] > pull - bound - unseen
    assert gained[0] < pull + unseen


def test_it_recovers_when_it_starts_late(shipped: Shipped) -> None:
    motion = shipped("slide-f-delayed")
    limp = motion.measures.times < STARTS + 0.3
    assert (motion.take.activations[limp] == 1.0).all()
    assert (motion.take.activations[~limp].min(axis=0) < 1.0).any()
    assert missed("slide-f-delayed", motion) == []
    assert rests_at_the_end(motion)


@pytest.mark.long
@pytest.mark.parametrize(
    "options",
    [
        ("--set", "friction=0.08"),
        ("--set", "friction=0.12"),
        ("--time-step", "0.00834"),
    ],
)
@pytest.mark.parametrize("scene", SCENES)
def test_it_slides_upright_elsewhere(scene: str, options: tuple[str, ...], tmp_path: Path) -> None:
    assert missed(scene, run(scene, tmp_path, *options)) == []


@pytest.mark.parametrize("scene", ["slide-f", "slide-f-left"])
def test_without_muscles_it_topples(scene: str, tmp_path: Path) -> None:
    measures = run(scene, tmp_path, "--controller", "none", "--seconds", "4").measures
    assert measures.centre_of_mass[-1, 2] < 0.6 * measures.centre_of_mass[0, 2]
    assert measures.tilt[-1] > 60.0


def test_the_pull_grows_evenly() -> None:
    """Its impulse is that of the ramp up and the ramp down; pieces at their middle keep it."""
    plan = scenes.make("slide-f-left", {"pull": 0.2})
    character = plan.scene.character
    weight = character.material.density * character.mesh.volume * STANDARD_GRAVITY
    impulse = sum(push.force[0] * push.duration for push in plan.scene.pushes)
    np.testing.assert_allclose(impulse, -0.5 * 0.2 * weight * (ENDS - STARTS))
    assert {push.region for push in plan.scene.pushes} == {"head"}
    assert scenes.make("slide-f", {"pull": 0.0}).scene.pushes == ()
