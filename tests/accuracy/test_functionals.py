"""Numbers of controlled motions, on motions that are known."""

from __future__ import annotations

import numpy as np
import pytest

from warp_softbody import scenes
from warp_softbody.accuracy.cases import body_motion
from warp_softbody.accuracy.cases.case import ChartCase
from warp_softbody.accuracy.cases.functionals import FUNCTIONALS
from warp_softbody.accuracy.cases.letter_rows import LETTERS
from warp_softbody.accuracy.cases.track import Track
from warp_softbody.arrays import FloatArray
from warp_softbody.scenes import exercise_h

TIMES = np.arange(0.0, 3.5 + 1e-9, 1.0 / 30.0)


def track(scene: str, turns: FloatArray, ways: FloatArray) -> Track:
    """A rigid body at rest, turned (f, 3, 3) about its centre of mass and moved (f, 3) m."""
    made = scenes.make(scene).scene
    mesh = made.character.mesh
    shares = np.repeat(mesh.volumes / 4.0, 4)
    masses = np.bincount(mesh.tets.ravel(), shares).astype(np.float64)
    centre = masses @ mesh.points / masses.sum()
    points = np.einsum("fij,nj->fni", turns, mesh.points - centre) + centre + ways[:, None]
    return Track(scene=made, times=TIMES[: len(points)], points=points, masses=masses)


def about(axis: int, degrees: FloatArray) -> FloatArray:
    angle = np.radians(degrees)
    first, second = (axis + 1) % 3, (axis + 2) % 3
    turns = np.tile(np.eye(3), (len(angle), 1, 1))
    turns[:, first, first] = turns[:, second, second] = np.cos(angle)
    turns[:, first, second], turns[:, second, first] = -np.sin(angle), np.sin(angle)
    return turns


def still(count: int = len(TIMES)) -> tuple[FloatArray, FloatArray]:
    return np.tile(np.eye(3), (count, 1, 1)), np.zeros((count, 3))


def value(name: str, of: Track) -> float:
    return FUNCTIONALS[name].of(of)


def test_angles_rolled_forward_and_back() -> None:
    """More than one turn, then back by a known angle."""
    there, back = np.linspace(0.0, 450.0, 60), np.linspace(450.0, 300.0, 20)
    angles = np.concatenate([there, back])
    rolled = track("roll-o", about(1, angles), np.zeros((80, 3)))
    assert value("rolled", rolled) == pytest.approx(300.0)
    assert value("rolled_furthest", rolled) == pytest.approx(450.0)
    assert value("rolled_back", rolled) == pytest.approx(150.0)
    turned = track("jump-t", about(2, angles), np.zeros((80, 3)))
    # on the floor all the time
    assert value("turned_in_air", turned) == 0.0
    assert value("largest_tilt", turned) == pytest.approx(0.0, abs=1e-5)


def test_tilt_and_when_it_is_over() -> None:
    """A lean about y that grows to 20 degrees and goes back, 20 degrees a second either way."""
    angles = np.interp(TIMES, [0.0, 1.0, 2.0], [0.0, 20.0, 0.0])
    leaning = track("balance-i", about(1, angles), np.zeros((len(TIMES), 3)))
    assert value("largest_tilt", leaning) == pytest.approx(20.0)
    assert value("last_tilt", leaning) == pytest.approx(0.0, abs=1e-5)
    assert value("upright_again", leaning) == pytest.approx(1.75)


def test_distance_from_the_path_of_the_exercise() -> None:
    turns, ways = still()
    path, start = exercise_h.path_in_si(scenes.make("exercise-h").scene)
    ways[:, 0] = [path.at(max(0.0, time - start))[0] for time in TIMES]
    # off from the first half period on; what comes before it does not count
    off = TIMES > start + 0.5 * path.period
    ways[:, 0] += np.where(off, 0.1 * path.amplitude, 0.0)
    swaying = track("exercise-h", turns, ways)
    assert value("sway_error", swaying) == pytest.approx(0.1)
    assert value("swing", swaying) == pytest.approx(0.5 * np.ptp(ways[:, 0]))


def test_ways_and_what_is_lost_of_them() -> None:
    turns, ways = still()
    ways[:, 0] = 0.3 * TIMES - 0.1 * np.sin(2.0 * np.pi * TIMES)
    crawling = track("crawl-i", turns, ways)
    assert value("gone", crawling) == pytest.approx(ways[-1, 0])
    lost = -np.minimum(np.diff(ways[:, 0]), 0.0).sum()
    assert value("slipped", crawling) == pytest.approx(lost) and lost > 0.05


def test_heights_of_belly_and_feet() -> None:
    turns, ways = still(3)
    ways[1, 2] = 0.2
    assert value("arch", track("crawl-i-inchworm", turns, ways)) == pytest.approx(0.2)
    walking = track("walk-x", turns, np.zeros((3, 3)))
    for number in range(4):
        # each foot higher than the one before; the last one is still up when the run ends
        foot = walking.scene.character.region(f"foot_{number}")
        walking.points[2 if number == 3 else 1, foot, 2] += 0.01 * (number + 2)
    assert value("swing_height", walking) == pytest.approx(0.03)
    # what is lifted by less than a fiftieth of the height is not swung
    assert value("swing_height", track("walk-x", turns, 0.025 * ways)) == 0.0


@pytest.mark.parametrize("left", [0.31, 0.325, 1.0 / 3.0])
def test_turn_in_the_air(left: float) -> None:
    """A body that turns by 200 degrees a second leaves and lands between frames."""
    speed, gravity = 1.4, 9.81
    since = np.maximum(TIMES - left, 0.0)
    height = np.maximum(speed * since - 0.5 * gravity * since**2, 0.0)
    ways = height[:, None] * [0.0, 0.0, 1.0]
    jumping = track("jump-t", about(2, 200.0 * TIMES), ways)
    # as long as it is more than 1 mm up
    seconds = 2.0 * np.sqrt(speed**2 - 2.0 * gravity * 1e-3) / gravity
    assert value("turned_in_air", jumping) == pytest.approx(200.0 * seconds, rel=1e-4)


def test_heights_in_the_air() -> None:
    """On the floor for ten frames, then up and down."""
    height = np.concatenate([np.zeros(10), 0.3 * np.sin(np.linspace(0.0, np.pi, 21)), np.zeros(9)])
    ways = np.stack([np.zeros(40), np.zeros(40), height], axis=1)
    jumping = track("jump-t", about(2, np.zeros(40)), ways)
    # 0.3 m times pi over 20 frames, by the difference over two of them
    rate = 0.3 * np.sin(np.pi / 10.0) / 2.0 * 30.0
    assert value("take_off_speed", jumping) == pytest.approx(rate)
    assert value("take_off_speed", track("jump-t", *still())) == pytest.approx(0.0, abs=1e-9)


def test_a_short_hop_turns_by_what_its_frames_tell() -> None:
    """Of two frames in the air, and of one that ends there, no parabola is known."""
    lowest, angle = np.array([0.0, 0.101, 0.101, 0.0]), np.array([0.0, 10.0, 20.0, 30.0])
    beyond = 10.0 * (1.0 - 1e-3 / 0.101)
    assert body_motion.turned_in_air(lowest, angle) == pytest.approx(10.0 + 2.0 * beyond)
    assert body_motion.turned_in_air(lowest[:3], angle[:3]) == pytest.approx(10.0 + beyond)
    assert body_motion.turned_in_air(lowest[1:3], angle[1:3]) == pytest.approx(10.0)


@pytest.mark.parametrize("case", LETTERS, ids=lambda case: case.scene)
def test_a_body_that_does_nothing_is_measured_too(case: ChartCase) -> None:
    """Numbers, not errors, whatever a setting does to a motion."""
    idle = track(case.scene, *still())
    assert all(np.isfinite(value(name, idle)) for name in case.functionals)
