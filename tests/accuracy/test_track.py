"""Material points on other meshes, and the numbers of a motion, on motions that are known."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from tests.support.bodies import turn
from warp_softbody import scenes
from warp_softbody.accuracy.cases.functionals import FUNCTIONALS
from warp_softbody.accuracy.cases.track import (
    MOST_POINTS,
    MaterialPointTracker,
    Track,
    material_points,
)
from warp_softbody.arrays import FloatArray
from warp_softbody.world.refined_scene import refined_scene
from warp_softbody.world.scene import Scene

SLOPE = np.array([[0.9, 0.2, 0.0], [-0.1, 1.1, 0.3], [0.0, -0.2, 0.8]])


def linear(points: FloatArray) -> FloatArray:
    return np.asarray(points @ SLOPE.T + (0.5, -0.2, 0.1))


@pytest.mark.parametrize("cells", [1, 2, 3])
@pytest.mark.parametrize("level", [0, 1])
def test_linear_motions_are_seen_alike_on_every_mesh(cells: int, level: int) -> None:
    places = material_points(scenes.make("cantilever").scene)
    assert sum(map(len, places)) <= MOST_POINTS
    scene = refined_scene(scenes.make("cantilever", {"cells": cells}).scene, level)
    seen = MaterialPointTracker(scene, places)(linear(scene.whole.mesh.points))
    np.testing.assert_allclose(seen, linear(np.concatenate(places)), atol=1e-12)


def test_on_a_refined_mesh_they_are_nodes() -> None:
    """Any motion of the coarse nodes comes back, of several bodies too."""
    coarse = scenes.make("stack", {"count": 2}).scene
    fine = refined_scene(coarse, 1)
    start = np.concatenate(material_points(coarse))
    moved = np.sin(20.0 * fine.whole.mesh.points)
    np.testing.assert_allclose(
        MaterialPointTracker(fine, material_points(coarse))(moved), np.sin(20.0 * start), atol=1e-10
    )


def test_places_outside_a_coarser_ball_are_carried_on() -> None:
    places = material_points(scenes.make("bounce-ball", {"cells": 2}).scene)
    scene = scenes.make("bounce-ball", {"cells": 1}).scene
    seen = MaterialPointTracker(scene, places)(linear(scene.whole.mesh.points))
    np.testing.assert_allclose(seen, linear(np.concatenate(places)), atol=1e-12)


def track(name: str, move: Callable[[FloatArray, float], FloatArray], seconds: float) -> Track:
    scene: Scene = scenes.make(name).scene
    times = np.arange(round(30.0 * seconds) + 1) / 30.0
    points = scene.whole.mesh.points
    return Track(
        scene=scene,
        times=times,
        points=np.stack([move(points, t) for t in times]),
        masses=np.ones(len(points)),
    )


def value(name: str, measured: Track) -> float:
    return FUNCTIONALS[name].of(measured)


def test_turns_and_tilts() -> None:
    def spin(axis: tuple[float, float, float], rate: float) -> Callable[..., FloatArray]:
        return lambda points, t: np.asarray(points @ turn(axis, rate * t).T)

    # 2 s at 1.5 rad/s
    assert value("end_turn", track("twisted-bar", spin((1, 0, 0), 1.5), 2.0)) == pytest.approx(
        np.degrees(3.0)
    )
    assert value("rolled", track("roll-o", spin((0, 1, 0), 4.0), 2.0)) == pytest.approx(
        np.degrees(8.0)
    )
    leaning = track("balance-i", spin((0, 1, 0), 0.5), 1.0)
    assert value("largest_tilt", leaning) == pytest.approx(np.degrees(0.5))
    assert value("last_tilt", leaning) == pytest.approx(np.degrees(0.5))
    assert value("upright_again", leaning) == pytest.approx(1.0)

    def back(points: FloatArray, t: float) -> FloatArray:
        return np.asarray(points @ turn((0, 1, 0), 0.5 - 0.4 * t).T)

    # below 5 degrees of 28.6 at 22.9 a second, between frames
    rise = (np.degrees(0.5) - 5.0) / np.degrees(0.4)
    assert value("upright_again", track("balance-i", back, 1.2)) == pytest.approx(rise, rel=1e-6)


def test_heights_and_ways() -> None:
    def thrown(points: FloatArray, t: float) -> FloatArray:
        return np.asarray(points + np.array([0.7 * t, 0.0, 2.0 * t - 0.5 * 9.81 * t * t]))

    flight = track("jump-i", thrown, 0.4)
    # the first of its frames: 2 m/s half a frame before
    assert value("take_off_speed", flight) == pytest.approx(2.0 - 9.81 / 60.0)
    assert value("way_ahead", flight) == pytest.approx(0.28)

    def bounced(points: FloatArray, t: float) -> FloatArray:
        height = -2.0 * t if t < 0.2 else -0.4 + 2.0 * (t - 0.2) - 0.5 * 9.81 * (t - 0.2) ** 2
        return np.asarray(points + np.array([0.0, 0.0, height]))

    ball = track("bounce-ball", bounced, 0.6)
    start = ball.centers[0, 2]
    assert value("rebound", ball) == pytest.approx(start - 0.4 + 2.0**2 / (2.0 * 9.81))

    def sagging(points: FloatArray, t: float) -> FloatArray:
        return np.asarray(points - np.outer(points[:, 0] ** 2, (0, 0, np.sin(3.0 * t))))

    # the tip is at x = 1; the largest of the frames
    frames = np.sin(3.0 * np.arange(31) / 30.0).max()
    assert value("tip_fall", track("cantilever", sagging, 1.0)) == pytest.approx(frames)


def test_height_of_the_top_body() -> None:
    scene = scenes.make("stack", {"count": 2}).scene
    points = scene.whole.mesh.points
    stack = Track(
        scene=scene,
        times=np.zeros(2),
        points=np.stack([points, points - (0.0, 0.0, 0.05)]),
        masses=np.ones(len(points)),
    )
    # two cubes of 0.3 m, the upper one started 0.05 m above the lower
    assert value("top_height", stack) == pytest.approx(0.45)
