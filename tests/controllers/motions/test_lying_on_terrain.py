"""How high a crawling body carries itself over slopes and steps."""

from __future__ import annotations

import numpy as np
import pytest

from warp_softbody.controllers.motions.ground_below import GroundBelow
from warp_softbody.controllers.motions.lying_on_terrain import EDGE_MARGIN, MARGIN, LyingOnTerrain
from warp_softbody.world.ground import Plane
from warp_softbody.world.height_field import HeightField


def step(height: float, at: float = 1.0) -> HeightField:
    """A step up behind x = ``at`` m."""
    x = np.arange(-2.0, 4.0, 0.01)
    heights = np.repeat(np.where(x > at, height, 0.0)[:, None], 2, axis=1)
    return HeightField(heights=heights, spacing=(0.01, 4.0), origin=(-2.0, -2.0))


@pytest.mark.parametrize("slope", [0.25, -0.5])
def test_on_a_slope_nothing_stands_up(slope: float) -> None:
    terrain = LyingOnTerrain(GroundBelow(Plane(normal=(-slope, 0.0, 1.0))), 1.0)
    place = np.array([0.4, 0.1, 0.3])
    for rise in (terrain.over(place), terrain.along(place)):
        assert rise.height == pytest.approx(0.4 * slope, abs=1e-12)
        assert rise.slope == pytest.approx(slope, abs=1e-9)
        assert rise.bump == pytest.approx(0.0, abs=1e-12)
    lacks, _ = terrain.lacking(np.array([place, [0.0, 0.0, -1.0]]))
    np.testing.assert_array_equal(lacks, 0.0)


def test_an_end_is_lifted_before_and_behind_a_step() -> None:
    height = 0.05
    terrain = LyingOnTerrain(GroundBelow(step(height)), 1.0)
    far, near, on, beyond = (terrain.over(np.array([x, 0.0, 0.0])) for x in (0.5, 0.93, 1.05, 1.6))
    assert far.height == pytest.approx(0.0, abs=1e-9) and far.bump == pytest.approx(0.0, abs=1e-9)
    assert 0.6 * height < near.height and near.bump > 0.4 * height
    # above the step by the margin, against the slope that the step is seen as
    assert height * 0.9 < on.height < height * (1.3 + MARGIN)
    assert beyond.height == pytest.approx(height, abs=1e-9)


def test_nodes_lack_what_they_are_below_an_edge_that_is_near() -> None:
    terrain = LyingOnTerrain(GroundBelow(step(0.05)), 1.0)
    places = [(0.9, 0.0), (0.96, 0.0), (0.99, 0.02), (1.005, 0.045), (0.99, 0.06), (1.1, 0.05)]
    lacks, near = terrain.lacking(np.array([[x, 0.0, z] for x, z in places]))
    top = 0.05 + EDGE_MARGIN
    np.testing.assert_allclose(lacks, [0.0, top, top - 0.02, top - 0.045, 0.0, 0.0], atol=1e-9)
    assert 0.0 < near[1] < near[2] < near[3]


def test_all_scales_with_the_body() -> None:
    small, large = (
        LyingOnTerrain(GroundBelow(ground), size)
        for ground, size in ((step(0.05), 1.0), (_twice(step(0.05)), 2.0))
    )
    places = np.array([[0.96, 0.3, 0.01], [0.99, -0.2, 0.02], [1.4, 0.0, 0.05]])
    np.testing.assert_allclose(
        large.lacking(2.0 * places)[0], 2.0 * small.lacking(places)[0], atol=1e-12
    )
    for place in places:
        np.testing.assert_allclose(
            np.array(large.over(2.0 * place)),
            np.array(small.over(place)) * [2.0, 1.0, 2.0],
            atol=1e-9,
        )


def _twice(field: HeightField) -> HeightField:
    (dx, dy), (x, y) = field.spacing, field.origin
    return HeightField(
        heights=2.0 * field.heights, spacing=(2.0 * dx, 2.0 * dy), origin=(2.0 * x, 2.0 * y)
    )
