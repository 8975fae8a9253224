"""A scene of another size, or under another gravity, that moves like the one that it is made of.

Weight, elasticity, damping, muscles and pushes keep their ratios (Cauchy, Froude and Strouhal
numbers), so that positions over the length and speeds over sqrt(g L) are the same functions of
t sqrt(g / L). Densities, Poisson ratios, activations and friction are pure numbers or stay.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from warp_softbody.body.character import Character
from warp_softbody.body.material import Material
from warp_softbody.body.muscles import Fiber, MuscleGroup
from warp_softbody.errors import InputError
from warp_softbody.inputs import checks
from warp_softbody.world.force_fields import DragField, ForceField, RadialField, UniformField
from warp_softbody.world.friction_map import FrictionMap, map_of
from warp_softbody.world.ground import Ground, Plane
from warp_softbody.world.handles import Handle
from warp_softbody.world.height_field import HeightField
from warp_softbody.world.joined_bodies import Body
from warp_softbody.world.scene import Push, Scene
from warp_softbody.world.triangle_ground import TriangleGround

Vector = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class Similarity:
    """Factors from a scene to one that is similar to it.

    Attributes:
        length: of all lengths.
        gravity: of gravity.
    """

    length: float = 1.0
    gravity: float = 1.0

    def __post_init__(self) -> None:
        """Refuse factors that are not positive."""
        checks.settle(self, positive=("length", "gravity"))

    @property
    def time(self) -> float:
        """Factor of all times."""
        return float((self.length / self.gravity) ** 0.5)

    @property
    def speed(self) -> float:
        """Factor of all speeds."""
        return float((self.length * self.gravity) ** 0.5)

    @property
    def stress(self) -> float:
        """Factor of moduli and strengths at an equal density."""
        return self.gravity * self.length

    @property
    def force(self) -> float:
        """Factor of all forces."""
        return self.stress * self.length**2


def similar_scene(scene: Scene, by: Similarity) -> Scene:
    """The scene at another size and gravity; run it with time steps scaled by ``by.time``.

    Raises:
        InputError: the ground is none of those of the package.
    """
    return replace(
        scene,
        character=_character(scene.character, by),
        others=tuple(
            Body(
                character=_character(body.character, by),
                velocity=_times(body.velocity, by.speed),
                spin=_times(body.spin, 1.0 / by.time),
                pose=None if body.pose is None else body.pose * by.length,
            )
            for body in scene.others
        ),
        ground=None if scene.ground is None else _ground(scene.ground, by.length),
        gravity=_times(scene.gravity, by.gravity),
        pushes=tuple(_push(push, by) for push in scene.pushes),
        fields=tuple(_field(field, by) for field in scene.fields),
        handles=tuple(_handle(handle, by) for handle in scene.handles),
        initial_velocity=_times(scene.initial_velocity, by.speed),
        initial_spin=_times(scene.initial_spin, 1.0 / by.time),
        initial_pose=None if scene.initial_pose is None else scene.initial_pose * by.length,
    )


def _character(character: Character, by: Similarity) -> Character:
    return replace(
        character,
        mesh=replace(character.mesh, points=character.mesh.points * by.length, skin=None),
        skin=None
        if character.skin is None
        else replace(character.skin, points=character.skin.points * by.length),
        material=_material(character.material, by),
        materials={name: _material(own, by) for name, own in character.materials.items()},
        muscles=tuple(_muscles(group, by) for group in character.muscles),
    )


def _material(material: Material, by: Similarity) -> Material:
    return replace(
        material,
        young_modulus=material.young_modulus * by.stress,
        stiffness_damping=material.stiffness_damping * by.time,
        mass_damping=material.mass_damping / by.time,
    )


def _muscles(group: MuscleGroup, by: Similarity) -> MuscleGroup:
    return replace(
        group,
        fibers=tuple(_fiber(fiber, by.length) for fiber in group.fibers),
        strength=group.strength * by.stress,
        kernel_width=group.kernel_width * by.length,
    )


def _fiber(fiber: Fiber, length: float) -> Fiber:
    return replace(fiber, vertices=fiber.vertices * length)


def _push(push: Push, by: Similarity) -> Push:
    return replace(
        push,
        force=_times(push.force, by.force),
        start=push.start * by.time,
        duration=push.duration * by.time,
    )


def _field(field: ForceField, by: Similarity) -> ForceField:
    timing = {
        "start": field.start * by.time,
        "duration": field.duration * by.time,
        "period": None if field.period is None else field.period * by.time,
    }
    if isinstance(field, UniformField):
        pull = _times(field.acceleration, by.gravity)
        return replace(field, **timing, acceleration=pull)  # type: ignore[arg-type]
    if isinstance(field, RadialField):
        return replace(
            field,
            **timing,  # type: ignore[arg-type]
            center=_times(field.center, by.length),
            acceleration=field.acceleration * by.gravity,
            distance=field.distance * by.length,
        )
    if isinstance(field, DragField):
        wind, rate = _times(field.wind, by.speed), field.rate / by.time
        return replace(field, **timing, wind=wind, rate=rate)  # type: ignore[arg-type]
    raise InputError(f"a {type(field).__name__} cannot be scaled, only fields of the package")


def _handle(handle: Handle, by: Similarity) -> Handle:
    path = handle.path
    return replace(
        handle,
        until=None if handle.until is None else handle.until * by.time,
        path=replace(
            path,
            times=path.times * by.time,
            shifts=np.asarray(path.shifts) * by.length,
            center=None if path.center is None else _times(path.center, by.length),
        ),
    )


def _ground(ground: Ground, length: float) -> Ground:
    placed = _friction_map(map_of(ground), length)
    if isinstance(ground, Plane):
        return replace(ground, offset=ground.offset * length, friction_map=placed)
    if isinstance(ground, HeightField):
        (dx, dy), (x, y) = ground.spacing, ground.origin
        return replace(
            ground,
            heights=ground.heights * length,
            spacing=(dx * length, dy * length),
            origin=(x * length, y * length),
            friction_map=placed,
        )
    if isinstance(ground, TriangleGround):
        return replace(ground, vertices=ground.vertices * length, friction_map=placed)
    raise InputError(f"a {type(ground).__name__} cannot be scaled, only grounds of the package")


def _friction_map(given: FrictionMap | None, length: float) -> FrictionMap | None:
    if given is None:
        return None
    (dx, dy), (x, y) = given.spacing, given.origin
    return replace(given, spacing=(dx * length, dy * length), origin=(x * length, y * length))


def _times(vector: Vector, factor: float) -> Vector:
    x, y, z = vector
    return factor * x, factor * y, factor * z
