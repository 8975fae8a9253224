"""Bodies are placed in a scene and joined for the engine into one mesh of several parts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.body.directional_friction import DirectionalFriction
from warp_softbody.body.material import Material
from warp_softbody.body.mesh import TetMesh
from warp_softbody.body.muscles import MuscleGroup
from warp_softbody.errors import InputError
from warp_softbody.inputs import array_checks, checks
from warp_softbody.inputs.records import FrozenValue

Vector = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Body(FrozenValue):
    """A further body of a scene, beside its character.

    Attributes:
        character: where it stands at the start.
        velocity: of all its nodes at the start, m/s.
        spin: about its centre of mass at the start, rad/s.
        pose: (n, 3) m, where its nodes are at the start; None for the shape at rest.
    """

    character: Character
    velocity: Vector = (0.0, 0.0, 0.0)
    spin: Vector = (0.0, 0.0, 0.0)
    pose: FloatArray | None = None

    def __post_init__(self) -> None:
        """Refuse a velocity or a spin that is not finite."""
        checks.instance("Body.character", self.character, Character)
        checks.keep(
            self,
            velocity=checks.vector("Body.velocity", self.velocity, unit="m/s"),
            spin=checks.vector("Body.spin", self.spin, unit="rad/s"),
            pose=checked_pose("Body.pose", self.pose, self.character),
        )


def checked_pose(label: str, given: object, character: Character) -> FloatArray | None:
    """Places (n, 3) m of all nodes of a character, read-only; None where none are given.

    Raises:
        InputError: the array is of another shape, or not finite.
    """
    if given is None:
        return None
    shape = (len(character.mesh.points), 3)
    pose = np.array(array_checks.array(label, given, shape, unit="m"))
    pose.setflags(write=False)
    return pose


@dataclass(frozen=True)
class Part:
    """Where a body's nodes, tets and segments stand in the joined arrays."""

    name: str
    material: Material
    nodes: slice
    tets: slice
    segments: slice


def placed(
    character: Character,
    *,
    name: str | None = None,
    translation: Vector = (0.0, 0.0, 0.0),
    axis: Vector = (0.0, 0.0, 1.0),
    degrees: float = 0.0,
) -> Character:
    """Return a copy of a character, rotated about an axis through the origin, then translated.

    Args:
        character: what is copied.
        name: of the copy; the same where none is given.
        translation: m.
        axis: of the turn, right-handed.
        degrees: of the turn.
    """
    checks.instance("character of placed", character, Character)
    angle = math.radians(checks.number("degrees of placed", degrees))
    turn = _turn(checks.direction("axis of placed", axis), angle)
    shift = np.array(checks.vector("translation of placed", translation, unit="m"))

    def move(points: FloatArray) -> FloatArray:
        return np.asarray(points @ turn.T + shift)

    muscles = tuple(
        replace(group, fibers=tuple(replace(f, vertices=move(f.vertices)) for f in group.fibers))
        for group in character.muscles
    )
    frictions = tuple(
        replace(friction, direction=tuple((turn @ friction.direction).tolist()))
        for friction in character.directional_friction
    )
    return replace(
        character,
        name=character.name if name is None else name,
        mesh=replace(character.mesh, points=move(character.mesh.points), skin=None),
        skin=None
        if character.skin is None
        else replace(character.skin, points=move(character.skin.points)),
        muscles=muscles,
        directional_friction=frictions,
    )


def join(characters: Sequence[Character]) -> Character:
    """All bodies as one character of several parts.

    Names and regions of the first stay as they are; regions and fibres of another get its name and
    a dot in front. The material is that of the first: see `parts_of` for the others'.
    """
    first = characters[0]
    if len(characters) == 1:
        return first
    parts = parts_of(characters)
    regions: dict[str, npt.NDArray[np.int32]] = {}
    frictions: list[DirectionalFriction] = []
    muscles: list[MuscleGroup] = []
    for character, part in zip(characters, parts, strict=True):
        prefix = "" if character is first else f"{character.name}."
        for name, nodes in character.regions.items():
            if prefix + name in regions:
                raise InputError(
                    f"two regions of the scene are called {prefix + name!r}: one of body "
                    f"{first.name!r}, and {name!r} of body {character.name!r}"
                )
            regions[prefix + name] = nodes + part.nodes.start
        for friction in character.directional_friction:
            frictions.append(replace(friction, region=prefix + friction.region))
        muscles += [_prefixed(group, prefix) for group in character.muscles]
    points = np.concatenate([c.mesh.points for c in characters])
    tets = np.concatenate(
        [c.mesh.tets + p.nodes.start for c, p in zip(characters, parts, strict=True)]
    )
    fixed = [c.fixed + p.nodes.start for c, p in zip(characters, parts, strict=True)]
    return replace(
        first,
        mesh=TetMesh(points, tets),
        # each body has its own
        skin=None,
        muscles=tuple(muscles),
        regions=regions,
        fixed=np.concatenate(fixed).astype(np.int32),
        directional_friction=tuple(frictions),
    )


def _prefixed(group: MuscleGroup, prefix: str) -> MuscleGroup:
    """A muscle group with something in front of its name and those of its fibres."""
    if not prefix:
        return group
    fibers = tuple(replace(fiber, name=prefix + fiber.name) for fiber in group.fibers)
    return replace(group, name=prefix + group.name, fibers=fibers)


def parts_of(characters: Sequence[Character]) -> tuple[Part, ...]:
    """Where each body stands in the joined arrays."""
    ends = [
        np.cumsum([0, *counts]).tolist()
        for counts in (
            [len(c.mesh.points) for c in characters],
            [len(c.mesh.tets) for c in characters],
            [c.segment_count for c in characters],
        )
    ]
    slices = [[slice(a, b) for a, b in pairwise(kind)] for kind in ends]
    return tuple(
        Part(c.name, c.material, nodes, tets, segments)
        for c, nodes, tets, segments in zip(characters, *slices, strict=True)
    )


def _turn(axis: tuple[float, ...], angle: float) -> FloatArray:
    """Rotation matrix about a unit axis (Rodrigues)."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross)
