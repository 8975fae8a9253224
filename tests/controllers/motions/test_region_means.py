"""Means over regions are those of the volume or area, and so the same on every mesh."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.support.blocks import SIZE, block, seen
from warp_softbody.controllers.motions.body_measures import mean_weights, region_mean
from warp_softbody.world.ground import Plane

RNG = np.random.default_rng(5)


@pytest.mark.parametrize("regions", [("foot",), ("left", "right"), ("head",), ("rim",)])
def test_means_of_linear_values_are_the_same_on_refined_meshes(regions: tuple[str, ...]) -> None:
    """To rounding: of a face, of a face in two halves, of a part of the volume, of an edge."""
    slope = RNG.standard_normal((3, 3))
    found = []
    for level in range(3):
        character = block(level)
        x, _, z = character.mesh.points.T
        low = z < 1e-9
        named = {"head": z > 0.74, "rim": low & (x < 1e-9)}
        places = {name: np.flatnonzero(inside).astype(np.int32) for name, inside in named.items()}
        character = replace(character, regions={**character.regions, **places})
        view = seen(character, character.mesh.points @ slope.T, Plane())
        found.append(mean_weights(view, regions) @ view.positions)
        if len(regions) == 1:
            mean = region_mean(view, view.positions, regions[0])
            np.testing.assert_allclose(mean, found[-1], rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(found, [found[0]] * 3, rtol=1e-12, atol=1e-14)
    heights = {"foot": 0.0, "left": 0.0, "head": 0.875, "rim": 0.0}
    middle = SIZE * [0.0 if regions == ("rim",) else 0.5, 0.5, 0.0]
    middle[2] = heights[regions[0]] * SIZE[2]
    np.testing.assert_allclose(found[0], slope @ middle, rtol=1e-9, atol=1e-14)


def test_curved_values_converge() -> None:
    """At second order: errors fall to a quarter."""
    means = []
    for level in range(3):
        character = block(level)
        view = seen(character, character.mesh.points**2, Plane())
        means.append(region_mean(view, view.positions, "foot")[:2])
    errors = [float(np.abs(mean - SIZE[:2] ** 2 / 3.0).max()) for mean in means]
    assert errors[1] < 0.26 * errors[0] and errors[2] < 0.26 * errors[1]
