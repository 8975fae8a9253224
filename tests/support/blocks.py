"""Upright blocks with a foot, and what a controller sees of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from tests.support.bodies import box
from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.body.directional_friction import DirectionalFriction
from warp_softbody.body.material import Material
from warp_softbody.body.refinement import refined_character
from warp_softbody.controllers.contact_quadrature import measure
from warp_softbody.world.ground import Ground
from warp_softbody.world.height_field import HeightField
from warp_softbody.world.scene import Scene
from warp_softbody.world.view import BodyView

SOFT = Material(young_modulus=1e5, poisson_ratio=0.4)
SIZE = np.array([0.4, 0.3, 1.0])


def block(level: int = 0, scale: float = 1.0) -> Character:
    """A block 1 m tall, times a scale, whose foot is "foot", in two halves."""
    mesh = box((4, 2, 4), tuple((SIZE * scale).tolist()))
    x, _, z = mesh.points.T
    foot = z < 1e-9
    regions = {
        "foot": foot,
        "left": foot & (x <= 0.5 * SIZE[0] * scale + 1e-9),
        "right": foot & (x >= 0.5 * SIZE[0] * scale - 1e-9),
    }
    character = Character(
        name="block",
        mesh=mesh,
        material=SOFT,
        regions={name: np.flatnonzero(inside).astype(np.int32) for name, inside in regions.items()},
        directional_friction=(DirectionalFriction(region="foot", factors=(1.0, 2.0, 4.0, 2.0)),),
    )
    for _ in range(level):
        character = refined_character(character)
    return character


def seen(
    character: Character, positions: FloatArray, ground: Ground, impulses: FloatArray | None = None
) -> BodyView:
    count = len(positions)
    gaps, _ = ground.measure(positions)
    return BodyView(
        scene=Scene(character=character, ground=ground),
        time=0.0,
        time_step=0.01,
        masses=np.ones(count),
        positions=positions,
        velocities=np.zeros((count, 3)),
        touching=gaps <= 0.0,
        activations=np.zeros(0),
        impulses=np.zeros((count, 3)) if impulses is None else impulses,
    )


def bent(points: FloatArray, tilt: float = 0.03) -> FloatArray:
    """The block, tilted, twisted and bulging below: all smooth in the rest place."""
    x, y, z = (points - [0.5 * SIZE[0], 0.5 * SIZE[1], 0.0]).T
    twist = 0.8 * x + 0.5 * y
    flat = np.column_stack([x - twist * y, y + twist * x, z + 0.2 * x**2 + 0.1 * x * y])
    return np.asarray(Rotation.from_rotvec([0.4 * tilt, -tilt, 0.5]).apply(flat))


def dunes() -> HeightField:
    """Finer than any of the meshes, so that it is smooth to them."""
    x, y = np.meshgrid(*2 * (np.arange(-240, 241) * 0.0025,), indexing="ij")
    heights = 0.01 * np.sin(9.0 * x) * np.cos(7.0 * y)
    return HeightField(heights=heights, spacing=(0.0025, 0.0025), origin=(-0.6, -0.6))


def pressed(character: Character, positions: FloatArray, ground: Ground) -> BodyView:
    """The foot bears a pressure that is smooth in the rest place, up to half the weight in all."""
    view = seen(character, positions, ground)
    foot = character.region("foot")
    near = measure(view, ground, [foot])
    x, y, _ = character.mesh.points[foot].T
    pressure = (1.0 + 2.0 * x / SIZE[0]) * (1.5 - y / SIZE[1]) / (SIZE[0] * SIZE[1])
    impulses = np.zeros((len(positions), 3))
    share = 0.25 * view.weight * view.time_step * pressure * near.areas
    impulses[foot] = share[:, None] * near.normals
    return replace(view, impulses=impulses)
