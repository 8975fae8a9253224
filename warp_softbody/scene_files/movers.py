"""Movers of a scene file: rigid things on paths, each a body and the handle that moves it."""

from __future__ import annotations

from typing import Any

from warp_softbody.body.mesh import TetMesh
from warp_softbody.errors import InputError
from warp_softbody.scene_files.moving import path_of
from warp_softbody.scene_files.shapes import SHAPES, SURFACE_FILES, ball_of, box_of, one_of_both
from warp_softbody.scene_files.tables import Table
from warp_softbody.world.handles import Handle
from warp_softbody.world.joined_bodies import Body, placed
from warp_softbody.world.movers import COLOR, mover

PLACE = ("translation", "axis", "degrees")


def mover_of(table: Table) -> tuple[Body, Handle]:
    """The body and the handle of a table of [[movers]]."""
    keys: tuple[str, ...] = ("file",)
    if one_of_both(table) == "shape":
        keys = ("shape", *SHAPES[table.choice("shape", SHAPES)])
    table.only((*keys, "name", "color", "path", *PLACE))
    table.needed("path")
    path = path_of(table.table("path"))
    with table.explained():
        name, color = table.take("name", "mover"), table.take("color", COLOR)
        body, handle = mover(_surface(table), path, name=name, color=color)
        given = {key: table.take(key) for key in PLACE if key in table}
        return Body(character=placed(body.character, **given)) if given else body, handle


def _surface(table: Table) -> Any:
    if "file" not in table:
        return box_of(table) if table.take("shape") == "box" else ball_of(table)
    path = table.path("file")
    suffix = path.suffix.lower()
    if suffix == ".glb" or suffix == ".char":
        raise InputError(f"file {path}: no mover is made of {suffix!r}")
    return path if suffix in SURFACE_FILES else TetMesh.read(path)
