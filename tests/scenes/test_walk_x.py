"""walk-x and walk-x-fast, measured from their stages."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from warp_softbody.characters import letter_x
from warp_softbody.cli import main
from warp_softbody.scenes.walk_x import FAST, SLOW
from warp_softbody.stage_exports import measure, read_take, validate
from warp_softbody.stage_exports.measures import Measures
from warp_softbody.stage_exports.reader import Take

FPS = 60.0
LENGTH = 1.0  # m, of the body
CLEAR = 0.0076  # m, 2 % of the body's height
GAITS = {"walk-x": (SLOW, 4), "walk-x-fast": (FAST, 2)}
"""Gains, and swings in a cycle."""


def run(scene: str, folder: Path, *options: str) -> tuple[Take, Measures]:
    """A run's stage, which has to be finite, valid, without inverted or sunken tets."""
    stage = folder / "walk.usdc"
    arguments = ["run", scene, "--out", str(stage), "--fps", f"{FPS:g}", "--quiet", *options]
    assert main(arguments) == 0
    assert validate(stage) == []
    take = read_take(stage)
    measures = measure(take)
    assert measures.finite.all()
    assert measures.smallest_volume_ratio.min() > 0.0
    assert measures.penetration.max() < 0.002
    return take, measures


def lowest_of_feet(take: Take) -> npt.NDArray[np.float64]:
    """Height of the lowest node of each foot's underside, (f, 4) m."""
    feet = [letter_x().region(f"foot_{i}") for i in range(4)]
    return np.stack([take.tet_points[:, foot, 2].min(axis=1) for foot in feet], axis=1)


def lifts(heights: npt.NDArray[np.float64]) -> list[float]:
    """How high a foot came each time that it was lifted and put down again, m."""
    up = np.concatenate([[False], heights > CLEAR]).astype(int)
    begins, ends = np.flatnonzero(np.diff(up) == 1), np.flatnonzero(np.diff(up) == -1)
    return [
        float(heights[begin:end].max())
        for begin, end in zip(begins[: len(ends)], ends, strict=True)
    ]


def walks(scene: str, folder: Path, *options: str) -> tuple[Take, Measures]:
    """A run that goes a body length ahead on feet that are lifted, and does not fall."""
    take, measures = run(scene, folder, *options)
    path = measures.centre_of_mass
    assert path[-1, 0] - path[0, 0] >= LENGTH
    # the sway is a tenth of the length
    assert np.abs(path[:, 1]).max() < 0.2
    assert measures.tilt.max() < 15.0
    assert take.tet_points[:, letter_x().region("hub"), 2].min() > 0.05
    heights = lowest_of_feet(take)
    for foot in heights.T:
        high = lifts(foot)
        assert len(high) >= 3
        assert min(high) > 0.02
    up = heights > CLEAR
    if scene == "walk-x":
        assert up.sum(axis=1).max() == 1
    else:
        # feet in the air together are those across from each other, and fly for a third of the time
        assert not (up[:, [0, 3]].any(axis=1) & up[:, [1, 2]].any(axis=1)).any()
        assert (up.sum(axis=1) == 2).mean() > 1.0 / 3.0
    return take, measures


@pytest.mark.parametrize("scene", GAITS)
def test_it_walks_a_body_length(scene: str, tmp_path: Path) -> None:
    take, measures = walks(scene, tmp_path)
    assert np.abs(measures.volume_change).max() < 0.05
    accelerations = np.diff(take.velocities, axis=0)
    assert (accelerations[1:] * accelerations[:-1] < 0.0).mean() < 0.15
    # A stride a cycle, as feet that do not slip must: sway and lag are the same a cycle apart.
    gains, swings = GAITS[scene]
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


@pytest.mark.parametrize("scene", GAITS)
def test_limp_it_stays_where_it_stands(scene: str, tmp_path: Path) -> None:
    take, measures = run(scene, tmp_path, "--controller", "none", "--seconds", "2")
    moved = measures.centre_of_mass[-1] - measures.centre_of_mass[0]
    # it is mirrored in x and y, so that only rounding moves it
    assert np.hypot(moved[0], moved[1]) < 1e-3
    assert lowest_of_feet(take).max() < CLEAR


def test_with_static_contacts_it_drags_its_middle(tmp_path: Path) -> None:
    take, _ = run("walk-x-fast", tmp_path, "--controller", "static")
    assert take.tet_points[:, letter_x().region("hub"), 2].min() < 1e-3
