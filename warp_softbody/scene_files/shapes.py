"""Shapes of bodies in a scene file: shipped characters, files of meshes, boxes and balls."""

from __future__ import annotations

import inspect
from pathlib import Path
from typing import Any

import numpy as np

from warp_softbody import characters
from warp_softbody.body.character import Character
from warp_softbody.body.character_files import EXTENSION
from warp_softbody.body.mesh import TetMesh
from warp_softbody.body.mesh_files import FORMATS, SURFACES
from warp_softbody.errors import InputError
from warp_softbody.inputs import checks
from warp_softbody.scene_files.tables import Table
from warp_softbody.scenes.drop_block import box_mesh
from warp_softbody.scenes.stairs import ball_mesh

MOST_NODES = 1_000_000
"""Of a box or a ball."""

OF_SURFACE = ("unit", "height", "up", "forward", "repair", "tets", "density", "on_floor")
"""Arguments of `Character.from_surface`."""

SHAPES = {
    "box": ("size", "cells", "origin"),
    "ball": ("radius", "center", "refinements", "shells"),
}
"""Shapes that are made in code, and their keys."""

SURFACE_FILES = (*SURFACES, ".glb")


def one_of_both(table: Table) -> str:
    """Which of "file" and "shape" a table has.

    Raises:
        InputError: it has both, or none.
    """
    found = [key for key in ("file", "shape") if key in table]
    if not found:
        table.fail("the key 'shape' is missing, or 'file' in its place")
    if len(found) == 2:
        table.fail("goes without 'shape': a body has one of both", "file")
    return found[0]


def keys_of_shape(table: Table) -> tuple[str, ...]:
    """The keys that go with the shape or the file of a table."""
    if one_of_both(table) == "file":
        own = table.path("file").suffix.lower() in SURFACE_FILES
        return ("file", *(OF_SURFACE if own else ()))
    shape = table.choice("shape", (*SHAPES, *characters.names()))
    return ("shape", *SHAPES.get(shape, ("coarse",)))


def character_of_shape(table: Table, name: str | None) -> Character:
    """The character of a table's shape or file, with a name where one is given."""
    if "file" in table:
        with table.explained():
            return _of_file(table, table.path("file"), name)
    shape = table.take("shape")
    with table.explained():
        if shape in SHAPES:
            mesh = box_of(table) if shape == "box" else ball_of(table)
            return Character(name=name or shape, mesh=mesh)
        made = getattr(characters, shape)
        coarse = checks.whole("coarse", table.take("coarse", 0))
        if not coarse:
            return characters.make(shape)
        if "coarse" not in inspect.signature(made).parameters:
            raise InputError(f"coarse: the character {shape!r} has no coarser mesh")
        character: Character = made(coarse=coarse)
        return character


def _of_file(table: Table, path: Path, name: str | None) -> Character:
    suffix = path.suffix.lower()
    if suffix == EXTENSION:
        return Character.load(path)
    if suffix in SURFACE_FILES:
        given = {key: table.take(key) for key in OF_SURFACE if key in table}
        return Character.from_surface(path, name=name, **given)
    if suffix in FORMATS:
        return Character(name=name or path.stem, mesh=TetMesh.read(path))
    known = ", ".join((EXTENSION, *SURFACE_FILES, *FORMATS))
    raise InputError(f"file {path}: no body is read from {suffix!r}; take one of {known}")


def box_of(table: Table) -> TetMesh:
    """The mesh of a box."""
    size = checks.vector("size", table.needed("size"), unit="m")
    if min(size) <= 0.0:
        raise InputError(f"size must be three positive numbers of m, not {size}")
    given = checks.several("cells", table.take("cells", (4, 4, 4)), "three whole numbers")
    cells = tuple(checks.whole("cells", count, low=1) for count in given)
    if len(cells) != 3:
        raise InputError(f"cells must be three whole numbers, not {len(cells)}")
    if np.prod([count + 1.0 for count in cells]) > MOST_NODES:
        raise InputError(f"cells {cells} make more than {MOST_NODES} nodes")
    middle = (-0.5 * size[0], -0.5 * size[1], 0.0)
    origin = checks.vector("origin", table.take("origin", middle), unit="m")
    box: Any = box_mesh
    mesh: TetMesh = box(cells, size, origin)
    return mesh


def ball_of(table: Table) -> TetMesh:
    """The mesh of a ball."""
    radius = checks.number("radius", table.needed("radius"), above=0.0, unit="m")
    center = checks.vector("center", table.take("center", (0.0, 0.0, radius)), unit="m")
    refinements = checks.whole("refinements", table.take("refinements", 2), high=6)
    shells = checks.whole("shells", table.take("shells", 3), low=1, high=64)
    return ball_mesh(radius, np.array(center), refinements, shells)
