"""Unit vectors, names, and what a scene refuses before anything falls through it."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.bodies import box
from warp_softbody import Handle, MotionPath, Plane, Push, TriangleGround
from warp_softbody.body.character import Character
from warp_softbody.errors import InputError
from warp_softbody.inputs import checks
from warp_softbody.world.force_fields import UniformField
from warp_softbody.world.joined_bodies import Body, placed
from warp_softbody.world.scene import Scene


def test_a_unit_vector_stays_as_it_is() -> None:
    rng = np.random.default_rng(3)
    for given in (*rng.normal(size=(2000, 3)).tolist(), [0.0, 1.0, 1.0], [1e-150, 2e-150, 0.0]):
        once = checks.direction("normal", given)
        assert abs(np.linalg.norm(once) - 1.0) < 1e-15
        assert checks.direction("normal", once) == once
    plane = Plane(normal=(0.0, 1.0, 1.0))
    assert Plane(normal=plane.normal) == plane


def test_a_name_of_a_body_and_of_a_region_is_ambiguous() -> None:
    cube = Character(
        name="cube",
        mesh=box(),
        regions={"head": np.array([0, 1], np.int32), "cube": np.array([0, 2], np.int32)},
    )
    head = Body(character=placed(Character(name="head", mesh=box()), translation=(9.0, 0.0, 0.0)))
    path = MotionPath.straight((1.0, 0.0, 0.0))
    for name in ("head", "cube"):
        with pytest.raises(InputError, match=f"'{name}' is the name of a body and of a region"):
            Scene(character=cube, others=(head,), handles=(Handle(region=name, path=path),))
    # there is no doubt where both are of the same nodes
    mesh = box()
    whole = Character(
        name="cube", mesh=mesh, regions={"cube": np.arange(len(mesh.points), dtype=np.int32)}
    )
    scene = Scene(character=whole, handles=(Handle(region="cube", path=path),))
    assert len(scene.handle_nodes[0]) == len(mesh.points)


def test_nothing_acts_on_a_region_without_nodes() -> None:
    cube = Character(name="cube", mesh=box(), regions={"top": np.zeros(0, np.int32)})
    push = Push(region="top", force=(1.0, 0.0, 0.0), start=0.0, duration=1.0)
    with pytest.raises(InputError, match="'top' has no nodes"):
        Scene(character=cube, pushes=(push,))
    field = UniformField(acceleration=(1.0, 0.0, 0.0), region="top")
    with pytest.raises(InputError, match="'top' has no nodes"):
        Scene(character=cube, fields=(field,))


def test_a_ground_upside_down_is_refused() -> None:
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0.2], [0, 1, 0]])
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    TriangleGround(vertices=corners, faces=faces)
    TriangleGround(vertices=corners, faces=faces[:, ::-1], normal=(0.0, 0.0, -1.0))
    with pytest.raises(InputError, match="faces run clockwise"):
        TriangleGround(vertices=corners, faces=faces[:, ::-1])
    # a closed surface has as much of both
    solid = box()
    TriangleGround(vertices=solid.points, faces=solid.surface)
