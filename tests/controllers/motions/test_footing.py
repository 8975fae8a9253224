"""Footholds and the middle of a walking body over ground that is not level."""

from __future__ import annotations

import numpy as np
import pytest

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.motions.footing import FootingOnTerrain
from warp_softbody.controllers.motions.ground_below import GroundBelow
from warp_softbody.world.ground import Ground, Plane
from warp_softbody.world.height_field import HeightField
from warp_softbody.world.triangle_ground import TriangleGround

SLOPES = (0.25, -0.1)
HOME = np.array([[x, y, -0.2] for x in (-0.4, 0.4) for y in (-0.4, 0.4)])


def tilted(slopes: tuple[float, float]) -> tuple[Ground, Ground, Ground]:
    """The plane z = slopes . (x, y) as each kind of ground, from -2 to 2 m."""
    grid = np.linspace(-2.0, 2.0, 9)
    heights = slopes[0] * grid[:, None] + slopes[1] * grid[None]
    field = HeightField(heights=heights, spacing=(0.5, 0.5), origin=(-2.0, -2.0))
    vertices, faces = field.triangles()
    plane = Plane(normal=(-slopes[0], -slopes[1], 1.0))
    return plane, field, TriangleGround(vertices=vertices, faces=faces)


def height(points: FloatArray, slopes: tuple[float, float] = SLOPES) -> FloatArray:
    return np.asarray(points[:, :2] @ slopes)


@pytest.mark.parametrize("kind", [0, 1, 2])
def test_heights_of_a_slope(kind: int) -> None:
    places = np.random.default_rng(1).uniform(-1.0, 1.0, (50, 3))
    found = GroundBelow(tilted(SLOPES)[kind]).heights(places, 0.3)
    np.testing.assert_allclose(found, height(places), atol=1e-12)


def test_heights_of_a_field_are_its_own() -> None:
    heights = np.random.default_rng(2).uniform(-0.1, 0.1, (9, 9))
    field = HeightField(heights=heights, spacing=(0.25, 0.25), origin=(-1.0, -1.0))
    places = np.random.default_rng(3).uniform(-1.0, 1.0, (200, 2))
    found = GroundBelow(field).heights(places, 0.0)
    np.testing.assert_allclose(found, field.surface(places)[0], atol=1e-12)


@pytest.mark.parametrize("kind", [0, 1, 2])
def test_a_body_on_a_slope_stands_turned_with_it(kind: int) -> None:
    """Its feet are on the ground, its middle as far from it, and no foot further from it."""
    level = np.array([0.0, 0.0, 0.2]) + HOME
    below = GroundBelow(tilted(SLOPES)[kind])
    footing = FootingOnTerrain(GroundBelow(Plane()), level)
    footing._below = below
    middle = np.array([0.3, 0.2])
    stance = footing.stance(middle, HOME, np.array([0.34, 0.0]))
    normal = np.array([-SLOPES[0], -SLOPES[1], 1.0])
    normal /= np.linalg.norm(normal)
    whole = np.array([*middle, stance.height])
    np.testing.assert_allclose(whole @ normal, 0.2, atol=1e-12)
    np.testing.assert_allclose((whole + stance.home) @ normal, 0.0, atol=1e-12)
    np.testing.assert_allclose(stance.home @ stance.home.T, HOME @ HOME.T, atol=1e-12)
    for foot, place in enumerate(whole + stance.home):
        np.testing.assert_allclose(footing.foothold(foot, place), place[2], atol=1e-12)


def test_on_level_ground_nothing_changes() -> None:
    lowest = np.array([0.1, -0.2, 0.203]) + HOME
    footing = FootingOnTerrain(GroundBelow(Plane()), lowest)
    stance = footing.stance(np.array([5.0, 1.0]), HOME, np.array([0.34, 0.0]))
    np.testing.assert_allclose(stance.height, 0.203, atol=1e-12)
    np.testing.assert_allclose(stance.home, HOME, atol=1e-12)
    assert footing.foothold(1, np.array([3.0, 2.0, 0.0])) == pytest.approx(0.003)
    assert footing.hump(lowest[0], lowest[1]) == 0.0


def test_a_hump_between_two_footholds_is_seen() -> None:
    heights = np.zeros((9, 9))
    heights[4] = 0.08
    field = HeightField(heights=heights, spacing=(0.25, 0.25), origin=(-1.0, -1.0))
    footing = FootingOnTerrain(GroundBelow(field), np.array([[-0.8, 0.0, 0.0]]))
    way = np.array([[-0.8, 0.0, 0.0], [0.8, 0.0, 0.0]])
    assert footing.hump(*way) == pytest.approx(0.08)
    assert footing.hump(way[0], np.array([-0.4, 0.0, 0.0])) == 0.0
