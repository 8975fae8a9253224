"""A similar scene keeps every ratio of forces, and everything that has a dimension is scaled."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.support.bodies import box, muscular_bar
from warp_softbody import (
    Body,
    FrictionMap,
    HeightField,
    Material,
    Plane,
    Push,
    Scene,
    TriangleGround,
    placed,
)
from warp_softbody.body.character import Character
from warp_softbody.errors import InputError
from warp_softbody.world.similar_scene import Similarity, similar_scene

BY = Similarity(length=4.0, gravity=0.25)
MATERIAL = Material(young_modulus=1e5, stiffness_damping=0.02, mass_damping=0.4)


def scene(**changes: Any) -> Scene:
    other = placed(Character(name="other", mesh=box((1, 1, 1))), translation=(5.0, 0.0, 0.0))
    given: dict[str, Any] = {
        "character": muscular_bar(MATERIAL),
        "others": (Body(character=other, velocity=(1.0, 0.0, 0.0)),),
        "pushes": (Push(region="top", force=(1.0, 2.0, 0.0), start=0.5, duration=0.2),),
        "initial_velocity": (0.0, 3.0, 0.0),
    }
    return Scene(**(given | changes))


def test_forces_keep_their_ratios() -> None:
    """Weight, elastic force, muscles and push: all by the factor of forces."""
    old, new = scene(), similar_scene(scene(), BY)
    assert (BY.time, BY.speed, BY.stress, BY.force) == (4.0, 1.0, 1.0, 16.0)
    volume = new.character.mesh.volume / old.character.mesh.volume
    assert volume * BY.gravity == pytest.approx(BY.force, rel=1e-12)
    assert new.gravity == (0.0, 0.0, 0.25 * old.gravity[2])
    assert new.pushes[0] == Push(region="top", force=(16.0, 32.0, 0.0), start=2.0, duration=0.8)
    assert new.character.material == Material(
        young_modulus=1e5, stiffness_damping=0.08, mass_damping=0.1
    )
    for group, before in zip(new.character.muscles, old.character.muscles, strict=True):
        assert group.strength == before.strength and group.kernel_width == 4.0 * before.kernel_width
        for fiber, was in zip(group.fibers, before.fibers, strict=True):
            np.testing.assert_array_equal(fiber.vertices, 4.0 * was.vertices)
    np.testing.assert_array_equal(
        new.others[0].character.mesh.points, 4.0 * old.others[0].character.mesh.points
    )
    assert new.others[0].velocity == (1.0, 0.0, 0.0) and new.initial_velocity == (0.0, 3.0, 0.0)


def test_there_and_back_is_the_same_scene() -> None:
    """By factors that round nothing."""
    back = Similarity(length=0.25, gravity=4.0)
    grounds = (
        Plane(offset=-0.3, friction=0.4),
        Plane(friction_map=FrictionMap.stripes([1.0, 0.5], width=0.25, start=-1.0)),
        HeightField(heights=np.array([[0.0, 0.1], [0.2, 0.0]]), spacing=(0.5, 1.0)),
        TriangleGround(vertices=np.eye(3), faces=np.array([[0, 1, 2]])),
        None,
    )
    for ground in grounds:
        one = scene(ground=ground)
        other = similar_scene(one, BY)
        assert other != one and similar_scene(other, back) == one


def test_what_cannot_be_scaled_is_refused() -> None:
    with pytest.raises(InputError, match=r"Similarity\.length must be a positive number"):
        Similarity(length=0.0)

    class Hole:
        friction, normal = 0.5, (0.0, 0.0, 1.0)

        def measure(self, points: Any) -> Any:
            return points[:, 2], points

    with pytest.raises(InputError, match="a Hole cannot be scaled"):
        similar_scene(scene(ground=Hole()), BY)
