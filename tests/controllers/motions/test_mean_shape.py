"""The mean shape of a body: closed forms of strained rings, and rates by differences."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.motions.mean_shape import MeanShape
from warp_softbody.scenes.roll_o import build
from warp_softbody.world.scene import Scene
from warp_softbody.world.view import BodyView


@pytest.fixture(scope="module")
def scene() -> Scene:
    return build({"friction": 0.5, "patches": 6.0, "coarse": 0.0})[0]


def seen(scene: Scene, strain: FloatArray, velocities: FloatArray | None = None) -> BodyView:
    """Letter O, strained (3, 3), with nodes of equal mass."""
    points = scene.character.mesh.points @ (np.eye(3) + strain)
    return BodyView(
        scene=scene,
        time=0.0,
        time_step=1.0 / 60.0,
        masses=np.full(len(points), 0.1),
        positions=points,
        velocities=np.zeros_like(points) if velocities is None else velocities,
        touching=np.zeros(len(points), dtype=bool),
        activations=np.ones(scene.character.segment_count),
    )


def test_tilt_and_squash_are_those_of_the_strain(scene: Scene) -> None:
    """Of a round body, to second order in the strain."""
    strain = np.array([[0.02, 0.0, 0.03], [0.0, 0.0, 0.0], [0.03, 0.0, -0.02]])
    rest = MeanShape.of(seen(scene, np.zeros((3, 3))))
    shape = MeanShape.of(seen(scene, strain))
    assert shape.tilt - rest.tilt == pytest.approx(0.03, abs=0.002)
    assert shape.squash - rest.squash == pytest.approx(2 * 0.02, abs=0.002)


def test_rows_are_rates_where_the_inertia_stays(scene: Scene) -> None:
    """Central differences of the moments, over an inertia that is held."""
    rng = np.random.default_rng(3)
    view = seen(scene, 0.05 * rng.normal(size=(3, 3)))
    velocities = rng.normal(size=view.positions.shape)
    shape = MeanShape.of(view)
    step = 1e-5
    ahead, behind = (
        MeanShape.of(replace(view, positions=view.positions + sign * step * velocities))
        for sign in (1.0, -1.0)
    )
    moments = [
        np.array([one.tilt, one.squash]) * one.inertia / shape.inertia for one in (ahead, behind)
    ]
    expected = (moments[0] - moments[1]) / (2.0 * step)
    np.testing.assert_allclose(shape.rows(view) @ velocities.ravel(), expected, rtol=1e-7)
