"""Frames of patches: along the sliding or along the body, smooth, and turned as these are."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.support.blocks import block, seen
from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.contact_frames import carried_axes, moving_frames
from warp_softbody.world.ground import Plane

UP = (0.0, 0.0, 1.0)
REST = np.zeros(3)
RNG = np.random.default_rng(3)


def moving_frame(
    normal: tuple[float, float, float], slip: FloatArray, axes: FloatArray, speed: float
) -> FloatArray:
    """Of a single patch."""
    return np.asarray(moving_frames(np.array([normal]), slip[None], axes, speed)[0])


def turned(frame: FloatArray, turn: Rotation) -> FloatArray:
    return np.asarray(turn.apply(frame))


def quarters_apart(one: FloatArray, other: FloatArray) -> float:
    """Angle between the first tangents, rad, up to quarter turns."""
    along, across = one[1] @ other[1], one[2] @ other[1]
    return float(abs(np.angle((along + 1j * across) ** 4)) / 4.0)


@pytest.mark.parametrize("degrees", [11.0, 22.5, 37.0, 61.0, 180.0])
def test_a_turned_motion_has_turned_frames(degrees: float) -> None:
    """To the last labels of the directions, about the ground's normal."""
    turn = Rotation.from_rotvec([0.0, 0.0, degrees], degrees=True)
    for _ in range(20):
        axes = Rotation.from_rotvec(0.4 * RNG.standard_normal(3)).as_matrix()
        slip = 0.1 * RNG.standard_normal(3)
        here = moving_frame(UP, slip, axes, 0.06)
        there = moving_frame(UP, turn.apply(slip), turn.apply(axes), 0.06)
        np.testing.assert_allclose(there, turned(here, turn), atol=1e-12)


def test_frames_are_right_handed_and_stand_on_the_ground() -> None:
    for _ in range(20):
        normal = RNG.standard_normal(3)
        x, y, z = (normal / np.linalg.norm(normal)).tolist()
        axes = Rotation.from_rotvec(RNG.standard_normal(3)).as_matrix()
        frame = moving_frame((x, y, z), RNG.standard_normal(3), axes, 0.06)
        np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(frame) == pytest.approx(1.0)
        np.testing.assert_allclose(frame[0], [x, y, z], atol=1e-12)


def test_a_body_at_rest_has_its_own_axes() -> None:
    for angle in (0.0, 0.3, 2.0):
        axes = Rotation.from_rotvec([0.0, 0.0, angle]).as_matrix().T
        frame = moving_frame(UP, REST, axes, 0.06)
        np.testing.assert_allclose(frame[1], [np.cos(angle), np.sin(angle), 0.0], atol=1e-12)


def test_sliding_decides_where_it_is_fast() -> None:
    """Then some direction of the polygon is along the sliding, to the body's small part in it."""
    for _ in range(20):
        angle = RNG.uniform(-np.pi, np.pi)
        way = np.array([np.cos(angle), np.sin(angle), 0.0])
        frame = moving_frame(UP, 0.6 * way, np.eye(3), 0.06)
        along = np.stack([frame[0], way, np.cross(frame[0], way)])
        assert quarters_apart(frame, along) < 1e-3


def test_a_body_that_rolls_keeps_its_frame() -> None:
    """About one of its axes: x and z go through the upright, and the polygon lies as before."""
    for angle in np.linspace(0.0, 2.0 * np.pi, 50):
        for axis in ([0.0, 1.0, 0.0], [1.0, 0.0, 0.0]):
            axes = Rotation.from_rotvec(angle * np.array(axis)).apply(np.eye(3))
            frame = moving_frame(UP, REST, axes, 0.06)
            still = moving_frame(UP, REST, np.eye(3), 0.06)
            assert quarters_apart(frame, still) < 1e-9


def test_frames_are_continuous_as_the_sliding_grows() -> None:
    """From rest along an odd way: half the steps turn the polygon by half as much."""
    way = np.array([np.cos(0.5), np.sin(0.5), 0.0])

    def largest(steps: int) -> float:
        speeds = np.linspace(0.0, 0.3, steps + 1)
        frames = [moving_frame(UP, speed * way, np.eye(3), 0.06) for speed in speeds]
        return max(quarters_apart(a, b) for a, b in pairwise(frames))

    assert largest(400) < 0.6 * largest(200) < 0.1


def test_axes_are_carried_with_the_body() -> None:
    """A turn, a stretch and a shear take the rest axes along, wherever the body is."""
    character = block()
    gradient = Rotation.from_rotvec([0.3, -0.2, 1.0]).as_matrix() @ np.diag([1.1, 0.9, 1.0])
    points = character.mesh.points @ gradient.T + [3.0, -2.0, 5.0]
    axes = carried_axes(seen(character, points, Plane()))
    np.testing.assert_allclose(axes, gradient.T, atol=1e-12)
