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


HALF = 0.1
SIDE = np.array([1.0, 0.0])


def footing_at_a_step(at: float) -> FootingOnTerrain:
    """A step of 5 cm behind a place x, m, and a foot of half length 0.1 m."""
    x = np.arange(-2.0, 2.0, 0.0125)
    heights = np.repeat(0.05 * (x > at)[:, None], 2, axis=1)
    field = HeightField(heights=heights, spacing=(0.0125, 4.0), origin=(-2.0, -2.0))
    return FootingOnTerrain(GroundBelow(field), np.array([[-1.0, 0.0, 0.0]]), HALF)


@pytest.mark.parametrize("off", [-0.09, -0.02, 0.03, 0.1])
def test_a_foot_is_set_down_beside_an_edge(off: float) -> None:
    """The whole sole on one side of it, and no further away than it takes."""
    footing = footing_at_a_step(0.5 + off)
    place = np.array([0.5, 0.0, 0.0])
    shift = footing.beside_edge(place, SIDE)
    room = abs(0.5 + shift[0] - 0.5 - off)
    assert shift[1] == 0.0
    assert HALF < room < 1.3 * HALF + 0.25 * HALF + 0.0125


def test_a_foot_stays_where_it_belongs_on_slopes_and_far_from_edges() -> None:
    place = np.array([0.3, 0.1, 0.1])
    for ground in tilted(SLOPES):
        footing = FootingOnTerrain(GroundBelow(ground), HOME, HALF)
        np.testing.assert_array_equal(footing.beside_edge(place, SIDE), 0.0)
    np.testing.assert_array_equal(footing_at_a_step(0.9).beside_edge(place, SIDE), 0.0)


def test_the_end_of_a_sole_sees_a_step_before_its_middle() -> None:
    begin, end = np.array([0.0, 0.0, 0.0]), np.array([0.3, 0.0, 0.0])
    assert footing_at_a_step(0.33).hump(begin, end) == pytest.approx(0.05)
    assert footing_at_a_step(0.45).hump(begin, end) == 0.0
