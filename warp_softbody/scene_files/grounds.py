"""Grounds of a scene file."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.body.meshing.surface import read_triangles
from warp_softbody.errors import InputError
from warp_softbody.scene_files.beside import Beside
from warp_softbody.scene_files.records import record_of, table_of
from warp_softbody.scene_files.tables import Table
from warp_softbody.world.friction_map import FrictionMap, map_of
from warp_softbody.world.ground import Ground, Plane
from warp_softbody.world.height_field import HeightField
from warp_softbody.world.triangle_ground import TriangleGround

KINDS: dict[str, type[Any]] = {
    "plane": Plane,
    "heights": HeightField,
    "triangles": TriangleGround,
}
FRICTION_MAP = "friction_map"
MOST_INLINE = 64
"""Numbers that are written into the file itself; more stand beside it."""


def ground_of(table: Table) -> Ground:
    """The ground of a table."""
    kind = table.choice("kind", KINDS)
    also = ("kind", "file", FRICTION_MAP) if kind != "plane" else ("kind", FRICTION_MAP)
    given: dict[str, Any] = {}
    if "file" in table and kind != "plane":
        names = ("heights",) if kind == "heights" else ("vertices", "faces")
        for name in names:
            if name in table:
                table.fail(f"goes without {name!r}, which it holds", "file")
        path = table.path("file")
        with table.explained():
            values = (_grid(path),) if kind == "heights" else _triangles(path)
        given = dict(zip(names, values, strict=True))
    placed = _friction_map(table.table(FRICTION_MAP)) if FRICTION_MAP in table else None
    try:
        ground: Ground = record_of(KINDS[kind], table, also=also, **given, **{FRICTION_MAP: placed})
    except InputError as error:
        if given:
            _blame_file(table, (*given, "triangle "), error)
        raise
    return ground


def _blame_file(table: Table, names: tuple[str, ...], error: InputError) -> None:
    """Fail at the file of a table if what a record refuses is one of the names that it holds."""
    cause = str(error.__cause__ or "")
    if any(name in cause for name in names):
        table.fail(f"file {table.path('file')}: {cause}", "file")


def _friction_map(table: Table) -> FrictionMap:
    """The map of a table, whose factors stand in it or in a file."""
    if "file" not in table:
        return record_of(FrictionMap, table)
    if "factors" in table:
        table.fail("goes without 'factors', which it holds", "file")
    with table.explained("file"):
        factors = _grid(table.path("file"))
    try:
        return record_of(FrictionMap, table, also=("file",), factors=factors)
    except InputError as error:
        _blame_file(table, ("factors",), error)
        raise


def _grid(path: Path) -> FloatArray:
    """Numbers of a .npy file, or of a text with a row in each line.

    Raises:
        InputError: the file is missing, or holds no numbers.
    """
    try:
        if path.suffix.lower() == ".npy":
            return np.asarray(np.load(path, allow_pickle=False))
        delimiter = "," if path.suffix.lower() == ".csv" else None
        with warnings.catch_warnings():
            # an empty file is told of below
            warnings.simplefilter("ignore", UserWarning)
            return np.loadtxt(path, delimiter=delimiter, ndmin=2, encoding="utf-8-sig")
    except FileNotFoundError as error:
        raise InputError(f"file {path}: there is no such file") from error
    except (OSError, ValueError, EOFError) as error:
        raise InputError(f"file {path}: it holds no grid of numbers: {error}") from error


def _triangles(path: Path) -> tuple[FloatArray, Any]:
    """Vertices and faces of a surface file, or of an .npz file."""
    if path.suffix.lower() != ".npz":
        found = read_triangles(path)
        return found.points, found.faces
    try:
        with np.load(path, allow_pickle=False) as arrays:
            return arrays["vertices"], arrays["faces"]
    except FileNotFoundError as error:
        raise InputError(f"file {path}: there is no such file") from error
    except (OSError, ValueError, KeyError, EOFError) as error:
        raise InputError(f"file {path}: it holds no vertices and faces: {error}") from error


def table_of_ground(ground: Ground, beside: Beside) -> dict[str, Any]:
    """What `ground_of` makes the same ground of.

    Raises:
        InputError: the ground is none of those of the package.
    """
    kind = next((name for name, known in KINDS.items() if type(ground) is known), None)
    if kind is None:
        raise InputError(
            f"a {type(ground).__name__} cannot be written to a file, only grounds of the package"
        )
    large = {"heights": ("heights",), "triangles": ("vertices", "faces")}.get(kind, ())
    arrays = {name: np.asarray(getattr(ground, name)) for name in large}
    found = {"kind": kind, **table_of(ground, without=(*large, FRICTION_MAP))}
    placed = map_of(ground)
    if placed is not None:
        found[FRICTION_MAP] = _table_of_map(placed, beside)
    if sum(array.size for array in arrays.values()) <= MOST_INLINE:
        return {**found, **arrays}
    if kind == "heights":
        return {**found, "file": beside.array("heights.npy", arrays["heights"])}
    return {**found, "file": beside.arrays("ground.npz", arrays)}


def _table_of_map(placed: FrictionMap, beside: Beside) -> dict[str, Any]:
    if placed.factors.size <= MOST_INLINE:
        return table_of(placed)
    factors = {"file": beside.array("friction.npy", placed.factors)}
    return {**table_of(placed, without=("factors",)), **factors}
