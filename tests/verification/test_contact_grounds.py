"""Height fields and triangle meshes: the same contact as a plane, on any shape."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from tests.support.bodies import Rig, Vector, box
from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.body.material import Material
from warp_softbody.body.mesh import TetMesh
from warp_softbody.engine.model import build_model
from warp_softbody.engine.options import SimulationOptions
from warp_softbody.engine.state import Contacts, Control, State
from warp_softbody.engine.stepper import Stepper
from warp_softbody.errors import InputError
from warp_softbody.world.ground import Ground, Plane
from warp_softbody.world.height_field import HeightField
from warp_softbody.world.scene import Scene
from warp_softbody.world.triangle_ground import TriangleGround

G = 9.81
SOFT = Material(young_modulus=1e5, poisson_ratio=0.4, stiffness_damping=0.02)


def standing(
    mesh: TetMesh, ground: Ground, velocity: Vector = (0.0, 0.0, 0.0), **options: Any
) -> Rig:
    character = Character(name="body", mesh=mesh, material=SOFT)
    scene = Scene(character=character, ground=ground, initial_velocity=velocity)
    given: dict[str, Any] = {"time_step": 0.01} | options
    model = build_model(scene, SimulationOptions(**given))
    return Rig(
        model=model,
        stepper=Stepper(model),
        state=State.at_rest(model),
        after=State.at_rest(model),
        control=Control.slack(model),
        contacts=Contacts.none(model),
    )


def sheet(slope: float, friction: float = 0.5) -> TriangleGround:
    """A square of 4 m of the plane z = slope x, in two triangles."""
    corners = np.array([[-2.0, -2.0], [2.0, -2.0], [2.0, 2.0], [-2.0, 2.0]])
    vertices = np.column_stack([corners, slope * corners[:, 0]])
    return TriangleGround(
        vertices=vertices, faces=np.array([[0, 1, 2], [0, 2, 3]]), friction=friction
    )


def ramp(slope: float, friction: float = 0.5) -> HeightField:
    """The same as a grid of heights."""
    x = np.linspace(-2.0, 2.0, 9)
    heights = np.repeat(slope * x[:, None], 9, axis=1)
    return HeightField(heights=heights, spacing=(0.5, 0.5), origin=(-2.0, -2.0), friction=friction)


def hills(seed: int = 2, size: int = 9) -> HeightField:
    heights = np.random.default_rng(seed).uniform(-0.05, 0.05, (size, size))
    return HeightField(heights=heights, spacing=(0.25, 0.2), origin=(-1.0, -0.8))


def block(height: float = 0.0) -> TetMesh:
    return box((3, 3, 3), (0.2, 0.2, 0.2), (-0.1, -0.1, height))


@pytest.mark.parametrize("slope", [0.0, 0.3])
@pytest.mark.parametrize("kind", [ramp, sheet])
def test_a_flat_ground_of_any_kind_is_the_plane(
    kind: Callable[[float], Ground], slope: float
) -> None:
    """Sliding, landing and sticking: float64 paths agree to what solves at 1e-12 leave."""
    options: dict[str, Any] = {"precision": "float64", "tolerance": 1e-12}
    normal = (-slope, 0.0, 1.0)
    mesh = block(0.05)
    twin = standing(mesh, Plane(friction=0.5, normal=normal), (0.5, 0.2, 0.0), **options)
    body = standing(mesh, kind(slope), (0.5, 0.2, 0.0), **options)
    twin.step(60)
    body.step(60)
    np.testing.assert_allclose(body.positions, twin.positions, atol=1e-8)
    np.testing.assert_array_equal(body.contacts.modes.numpy(), twin.contacts.modes.numpy())


def closest(ground: TriangleGround, point: FloatArray) -> float:
    """Distance to the triangles, by bounding every edge and plane apart."""
    best = np.inf
    for face in ground.faces:
        a, b, c = ground.vertices[face]
        normal = np.cross(b - a, c - a)
        normal /= np.linalg.norm(normal)
        flat = point - ((point - a) @ normal) * normal
        sides = [
            np.cross(end - start, flat - start) @ normal for start, end in ((a, b), (b, c), (c, a))
        ]
        if min(sides) >= 0.0:
            best = min(best, abs((point - a) @ normal))
        for start, end in ((a, b), (b, c), (c, a)):
            along = np.clip((point - start) @ (end - start) / ((end - start) @ (end - start)), 0, 1)
            best = min(best, float(np.linalg.norm(point - start - along * (end - start))))
    return best


def cube_ground() -> TriangleGround:
    """The surface of a cube with corners at 0 and 1."""
    mesh = box((1, 1, 1), (1.0, 1.0, 1.0))
    return TriangleGround(vertices=mesh.points, faces=mesh.surface)


def test_distances_to_triangles_are_signed_and_exact() -> None:
    """Against a search through all triangles, inside and outside of a cube."""
    points = np.random.default_rng(1).uniform(-0.5, 1.5, (300, 3))
    gaps, normals = cube_ground().measure(points)
    inside = ((points > 0.0) & (points < 1.0)).all(axis=1)
    np.testing.assert_array_equal(gaps < 0.0, inside)
    expected = [closest(cube_ground(), point) for point in points]
    np.testing.assert_allclose(np.abs(gaps), expected, atol=1e-12)
    # the normal leads from the closest point to the point
    nearest = points - gaps[:, None] * normals
    np.testing.assert_allclose(np.abs(nearest - np.clip(nearest, 0.0, 1.0)).max(), 0.0, atol=1e-12)


def test_a_height_field_is_its_triangles() -> None:
    """At points of its surface both measure nothing, and the triangles' normals are the field's."""
    field = hills()
    flat = np.random.default_rng(3).uniform((-1.0, -0.8), (0.99, 0.79), (300, 2))
    height, _ = field.surface(flat)
    points = np.column_stack([flat, height])
    vertices, faces = field.triangles()
    gaps, normals = TriangleGround(vertices=vertices, faces=faces).measure(points)
    np.testing.assert_allclose(gaps, 0.0, atol=1e-12)
    own_gaps, own_normals = field.measure(points)
    np.testing.assert_allclose(own_gaps, 0.0, atol=1e-12)
    inner = np.abs(normals - own_normals).max(axis=1) < 1e-9
    assert inner.mean() > 0.99
    # beyond the grid it goes on level
    edge, slopes = field.surface(np.array([[5.0, 0.0], [-5.0, 0.1]]))
    assert edge[0] == field.surface(np.array([[1.0, 0.0]]))[0][0] and slopes[0, 0] == 0.0


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("kind", ["heights", "triangles"])
def test_a_block_rests_on_hills(kind: str, precision: str) -> None:
    """Carried to 1e-4 of its weight, which slanted normals and friction share; nothing sinks."""
    field = hills()
    ground: Ground = field
    if kind == "triangles":
        vertices, faces = field.triangles()
        ground = TriangleGround(vertices=vertices, faces=faces)
    body = standing(block(0.06), ground, precision=precision)
    deepest = 0.0
    # on edges between its nodes it rocks for longer than on nodes
    for _ in range(400):
        body.step()
        surface = body.positions[body.model.scene.character.mesh.surface_nodes]
        deepest = min(deepest, ground.measure(surface)[0].min())
    forces = body.contacts.impulses.numpy().astype(np.float64).sum(axis=0) / 0.01
    edges = body.contacts.pairs
    if edges is not None:
        # the hills' sharp edges bear between the nodes
        there = edges.nodes.numpy()[:, 0] >= 0
        forces += edges.impulses.numpy()[there].astype(np.float64).sum(axis=0) / 0.01
        assert there.any()
    weight = body.masses.sum() * G
    np.testing.assert_allclose(forces, [0.0, 0.0, weight], atol=1e-4 * weight)
    assert np.abs(body.velocities).max() < 1e-4
    # from triangle to triangle a node sinks by at most the way of a step along a slope of a half
    assert deepest > -0.5 * 1.0 * 0.01
    assert ground.measure(body.positions)[0].min() > -1e-4


def test_mistakes_in_a_ground_are_one_sentence() -> None:
    with pytest.raises(InputError, match="at least 2 x 2 heights"):
        HeightField(heights=np.zeros((1, 5)))
    with pytest.raises(InputError, match="it holds nan at"):
        HeightField(heights=np.full((2, 2), np.nan))
    with pytest.raises(InputError, match="spacing must be positive"):
        HeightField(heights=np.zeros((2, 2)), spacing=(0.1, 0.0))
    with pytest.raises(InputError, match="outside its 3 vertices"):
        TriangleGround(vertices=np.eye(3), faces=np.array([[0, 1, 3]]))
    with pytest.raises(InputError, match="triangle 0 of the ground has no area"):
        TriangleGround(vertices=np.zeros((3, 3)), faces=np.array([[0, 1, 2]]))
    with pytest.raises(InputError, match="friction must be a finite number, at least 0"):
        TriangleGround(vertices=np.eye(3), faces=np.array([[0, 1, 2]]), friction=-1.0)
