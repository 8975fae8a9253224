"""Bodies of a scene file: a shape, and what is changed of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.body.directional_friction import DirectionalFriction
from warp_softbody.body.material import Material
from warp_softbody.body.muscles import Fiber, FiberKind, MuscleGroup
from warp_softbody.body.region_materials import holds_tet, without_tet
from warp_softbody.inputs import array_checks, input_kinds
from warp_softbody.scene_files.beside import array_of_file
from warp_softbody.scene_files.records import changed, record_of
from warp_softbody.scene_files.shapes import character_of_shape, keys_of_shape
from warp_softbody.scene_files.tables import Table
from warp_softbody.world.joined_bodies import Body, checked_pose, placed

OWN = ("name", "material", "materials", "strengths", "muscles", "regions", "fixed", "color")
"""Keys that change a shape's character."""

FRICTION = "directional_friction"
PLACE = ("translation", "axis", "degrees")
START = ("velocity", "spin")
POSE = "pose"
CONTROLLER = "controller"


def body_of(table: Table, materials: Mapping[str, Material], *also: str) -> Body:
    """The body of a table, where it stands and as it moves at the start.

    Keys that are read elsewhere are given as ``also``.
    """
    table.only((*keys_of_shape(table), *OWN, FRICTION, *PLACE, *START, POSE, *also))
    character = character_of_shape(table, table.text("name"))
    character = _dressed(character, table, materials)
    with table.explained():
        given = {key: table.take(key) for key in PLACE if key in table}
        if given:
            character = placed(character, **given)
        moving = {key: table.take(key) for key in START if key in table}
    with table.explained(POSE if POSE in table else None):
        pose = array_of_file(table.path(POSE)) if POSE in table else None
        checked_pose(POSE, pose, character)
    with table.explained():
        return Body(character=character, pose=pose, **moving)


def _dressed(character: Character, table: Table, materials: Mapping[str, Material]) -> Character:
    """A character with what a table says of it beside its shape."""
    new: dict[str, Any] = {key: table.take(key) for key in ("name", "color") if key in table}
    if "material" in table:
        new["material"] = _material(character.material, table, materials)
    muscles = _muscles(table) if "muscles" in table else character.muscles
    if "strengths" in table:
        muscles = _with_strengths(muscles, table)
    new["muscles"] = muscles
    regions = dict(character.regions)
    if "regions" in table:
        own = table.table("regions")
        regions |= {name: _nodes(character, own, name) for name in own}
    if "fixed" in table:
        new["fixed"] = _nodes(replace(character, regions=regions), table, "fixed")
    frictions = character.directional_friction
    if FRICTION in table:
        frictions = tuple(record_of(DirectionalFriction, t) for t in table.tables(FRICTION))
        for each, friction in zip(table.tables(FRICTION), frictions, strict=True):
            _known_region(friction.region, regions, each, "region")
    if "materials" in table:
        own, base = table.table("materials"), new.get("material", character.material)
        for name in own:
            _known_region(name, regions, own, name)
            if not holds_tet(character.mesh.tets, regions[name]):
                own.fail(without_tet(name), name)
        new["materials"] = {name: _material(base, own, materials, name) for name in own}
    with table.explained():
        return replace(character, regions=regions, directional_friction=frictions, **new)


def _known_region(name: str, regions: Mapping[str, Any], table: Table, key: str) -> None:
    if name not in regions:
        known = ", ".join(sorted(regions)) or "none"
        table.fail(f"the body has no region {name!r}; it has: {known}", key)


def _material(
    own: Material, table: Table, materials: Mapping[str, Material], key: str = "material"
) -> Material:
    """A material by its name, or the body's own with what a table changes of it."""
    if table.is_table(key):
        return changed(own, table.table(key))
    name = table.take(key)
    if name not in materials:
        known = ", ".join(materials) or "none"
        table.fail(f"there is no [materials.{name}]; there are: {known}", key)
    return materials[name]


def _with_strengths(muscles: tuple[MuscleGroup, ...], table: Table) -> tuple[MuscleGroup, ...]:
    """Muscles whose strengths are given by group, Pa."""
    strengths = table.table("strengths")
    if not muscles:
        table.fail("the body has no muscles", "strengths")
    strengths.only(group.name for group in muscles)
    with strengths.explained():
        return tuple(
            replace(group, strength=strengths.take(group.name, group.strength)) for group in muscles
        )


def _muscles(table: Table) -> tuple[MuscleGroup, ...]:
    return tuple(
        record_of(
            MuscleGroup,
            each,
            also=("fibers",),
            fibers=tuple(_fiber(fiber) for fiber in each.tables("fibers")),
        )
        for each in table.tables("muscles")
    )


def _fiber(table: Table) -> Fiber:
    kind = table.choice("kind", [kind.value for kind in FiberKind]) if "kind" in table else None
    return record_of(
        Fiber, table, also=("kind",), kind=FiberKind(kind or FiberKind.LONGITUDINAL.value)
    )


def _nodes(character: Character, table: Table, key: str) -> Any:
    """Nodes by their numbers, by the name of a region, or those in a box."""
    given = table.take(key)
    if isinstance(given, str):
        with table.explained(key):
            return character.region(given)
    if not table.is_table(key):
        if given == ():
            table.fail("holds no nodes; leave the key out", key)
        with table.explained(key):
            return input_kinds.node_set(f"nodes of {key!r}", given, len(character.mesh.points))
    box = table.table(key)
    box.only(("low", "high"))
    if not len(list(box)):
        box.fail("a box needs 'low' or 'high', three numbers of m each")
    points = character.mesh.points
    low, high = _corner(box, "low", -np.inf), _corner(box, "high", np.inf)
    inside = np.all((points >= low) & (points <= high), axis=1)
    found = np.flatnonzero(inside)
    if not len(found):
        box.fail("no node of the body is in this box")
    return found


def _corner(box: Table, key: str, open_end: float) -> FloatArray:
    """A corner (3,) of a box, m; infinite where it is not given, or is said to be so."""
    given = box.take(key, (open_end,) * 3)
    with box.explained(key):
        corner = array_checks.array(key, given, (3,), finite=False, unit="m")
    if np.isnan(corner).any():
        box.fail("must be three numbers of m", key)
    return corner
