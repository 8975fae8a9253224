"""Momenta and areas by native code against those that NumPy has."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.support.blocks import block, seen
from warp_softbody.controllers import objectives
from warp_softbody.errors import InputError
from warp_softbody.world.ground import Plane
from warp_softbody.world.view import BodyView

NAMES = ("mass", "center_of_mass", "linear_momentum", "angular_momentum", "turning")


def views(seed: int, workroom: dict[object, object]) -> tuple[BodyView, BodyView]:
    """The same view twice, once with room for native code."""
    rng = np.random.default_rng(seed)
    character = block(1)
    points = character.mesh.points
    plain = seen(character, points + 0.02 * rng.standard_normal(points.shape), Plane())
    plain = replace(
        plain,
        velocities=rng.standard_normal(points.shape),
        masses=np.random.default_rng(0).uniform(0.5, 2.0, len(points)),
    )
    native = replace(plain)
    object.__setattr__(native, "workroom", workroom)
    return plain, native


def test_momenta_are_those_of_numpy_and_stay_with_their_view() -> None:
    room: dict[object, object] = {}
    pairs = [views(seed, room) for seed in range(3)]
    for _, native in pairs:
        # asked for in each before any is compared
        assert native.turning.shape == (3, 3 * native.node_count)
    for plain, native in pairs:
        for name in NAMES:
            expected = np.asarray(getattr(plain, name))
            bound = 1e-13 * np.abs(expected).max()
            np.testing.assert_allclose(getattr(native, name), expected, rtol=0.0, atol=bound)
        turned = native.turning @ native.velocities.ravel()
        np.testing.assert_allclose(turned, native.angular_momentum, rtol=1e-12)


def test_the_rows_of_a_run_s_views_are_not_to_be_written() -> None:
    _, native = views(0, {})
    with pytest.raises(ValueError, match="read-only"):
        native.turning[0, 0] = 1.0


@pytest.mark.parametrize("normal", [(0.0, 0.0, 1.0), (0.3, -0.2, 1.0)])
def test_the_area_of_a_base_is_that_of_numpy(normal: tuple[float, float, float]) -> None:
    """Triangles of either sign, and the gradient against differences."""
    room: dict[object, object] = {}
    for seed in range(3):
        plain, native = views(seed, room)
        scene = replace(plain.scene, ground=Plane(normal=normal))
        plain = replace(plain, scene=scene)
        native = replace(native, scene=scene)
        object.__setattr__(native, "workroom", room)
        surface = scene.character.mesh.surface
        triangles = surface[:40]
        one = objectives.base_area(native, triangles, 0.3, 2.0)
        other = objectives.base_area(plain, triangles, 0.3, 2.0)
        bound = 1e-13 * np.abs(other.rows).max()
        np.testing.assert_allclose(one.rows, other.rows, rtol=0.0, atol=bound)
        np.testing.assert_array_equal(one.target, other.target)
    flat = surface[:1].copy()
    flat[:, 1] = flat[:, 0]
    for view in (plain, native):
        with pytest.raises(InputError, match="covers no area"):
            objectives.base_area(view, flat, 0.3, 2.0)


def test_what_is_kept_is_made_once_where_there_is_room() -> None:
    plain, native = views(0, {})
    made: list[int] = []

    def make() -> int:
        made.append(len(made))
        return made[-1]

    assert [native.kept("key", make) for _ in range(3)] == [0, 0, 0]
    assert [plain.kept("key", make) for _ in range(2)] == [1, 2]
