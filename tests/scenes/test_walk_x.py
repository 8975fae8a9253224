"""walk-x and walk-x-fast, measured from their stages."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.motions.criteria import LIFTED, feet, went
from benchmarks.motions.criterion import RecordedMotion
from benchmarks.motions.measures import lifts
from tests.scenes.runs import missed, run
from warp_softbody import scenes
from warp_softbody.characters import letter_x
from warp_softbody.controllers.body_units import BodyUnits, in_si
from warp_softbody.scenes.walk_x import FAST, SLOW

FPS = 60.0
GAITS = {"walk-x": (SLOW, 4), "walk-x-fast": (FAST, 2)}
"""Gains, and swings in a cycle."""


def walks(scene: str, folder: Path, *options: str) -> RecordedMotion:
    """A run that goes a body length ahead on feet that are lifted, and does not fall."""
    motion = run(scene, folder, *options)
    assert missed(scene, motion) == []
    # the sway is a tenth of the length
    assert np.abs(motion.measures.centre_of_mass[:, 1]).max() < 0.2
    heights = feet(motion)
    for foot in heights.T:
        assert min(lifts(foot, LIFTED)) > 0.02
    up = heights > LIFTED
    if scene == "walk-x-fast":
        # feet in the air together are those across from each other, and fly for a third of the time
        assert not (up[:, [0, 3]].any(axis=1) & up[:, [1, 2]].any(axis=1)).any()
        assert (up.sum(axis=1) == 2).mean() > 1.0 / 3.0
    return motion


@pytest.mark.parametrize("scene", GAITS)
def test_it_walks_a_body_length(scene: str, tmp_path: Path) -> None:
    measures = walks(scene, tmp_path).measures
    # A stride a cycle, as feet that do not slip must: sway and lag are the same a cycle apart.
    own, swings = GAITS[scene]
    gains = in_si(own, BodyUnits.of_scene(scenes.make(scene).scene))
    cycle = round(swings * gains.swing * FPS)
    strides = measures.centre_of_mass[-1, 0] - measures.centre_of_mass[-1 - 2 * cycle, 0]
    assert strides == pytest.approx(2.0 * gains.stride, rel=0.05)


@pytest.mark.long
@pytest.mark.parametrize("options", [("--set", "friction=0.64"), ("--set", "friction=0.96")])
@pytest.mark.parametrize("scene", GAITS)
def test_it_walks_on_other_floors(scene: str, options: tuple[str, ...], tmp_path: Path) -> None:
    walks(scene, tmp_path, *options)


@pytest.mark.long
@pytest.mark.parametrize("scene", GAITS)
def test_it_walks_at_half_the_time_step(scene: str, tmp_path: Path) -> None:
    walks(scene, tmp_path, "--time-step", f"{1 / 120}")


@pytest.mark.long
@pytest.mark.parametrize("scene", GAITS)
def test_it_walks_on_after_a_push(scene: str, tmp_path: Path) -> None:
    walks(scene, tmp_path, "--set", "push=0.3")


def test_two_feet_come_up_as_far_for_as_long_as_it_walks(tmp_path: Path) -> None:
    """The line between the other two holds no body; tipped, two feet came 21 mm high and two 93."""
    options = ("--time-step", f"{1 / 120}", "--seconds", "11")
    tops = [lifts(foot, LIFTED) for foot in feet(run("walk-x-fast", tmp_path, *options)).T]
    for foot in tops:
        assert len(foot) >= 7
        assert min(foot) > 0.03
        # the first swings are from the stance; then none is half as high as another
        assert max(foot[-3:]) < 0.08 and min(foot[-3:]) > 0.6 * max(foot[1:4])


@pytest.mark.parametrize("scene", GAITS)
def test_limp_it_stays_where_it_stands(scene: str, tmp_path: Path) -> None:
    motion = run(scene, tmp_path, "--controller", "none", "--seconds", "2")
    path = motion.measures.centre_of_mass
    moved = path[-1] - path[0]
    # it is mirrored in x and y, so that only rounding moves it
    assert np.hypot(moved[0], moved[1]) < 1e-3
    assert feet(motion).max() < LIFTED


@pytest.mark.parametrize("scene", GAITS)
def test_with_static_contacts_it_sinks_down_and_stays_behind(scene: str, tmp_path: Path) -> None:
    motion = run(scene, tmp_path, "--controller", "static", volume=0.15)
    # of 1 m that are asked, and of 0.05 m above the ground
    assert went(motion) < 0.6
    assert (feet(motion) > LIFTED).all(axis=1).any()
    assert motion.take.tet_points[:, letter_x().region("hub"), 2].min() < 0.025
