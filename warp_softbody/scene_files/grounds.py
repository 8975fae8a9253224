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
from warp_softbody.world.ground import Ground, Plane
from warp_softbody.world.height_field import HeightField
from warp_softbody.world.triangle_ground import TriangleGround

KINDS: dict[str, type[Any]] = {
    "plane": Plane,
    "heights": HeightField,
    "triangles": TriangleGround,
}
MOST_INLINE = 64
"""Numbers that are written into the file itself; more stand beside it."""


def ground_of(table: Table) -> Ground:
    """The ground of a table."""
    kind = table.choice("kind", KINDS)
    also = ("kind", "file") if kind != "plane" else ("kind",)
    given: dict[str, Any] = {}
    if "file" in table and kind != "plane":
        names = ("heights",) if kind == "heights" else ("vertices", "faces")
        for name in names:
            if name in table:
                table.fail(f"goes without {name!r}, which it holds", "file")
        path = table.path("file")
        with table.explained():
            values = (_heights(path),) if kind == "heights" else _triangles(path)
        given = dict(zip(names, values, strict=True))
    try:
        ground: Ground = record_of(KINDS[kind], table, also=also, **given)
    except InputError as error:
        cause = str(error.__cause__ or "")
        if any(name in cause for name in (*given, "triangle ")) and given:
            table.fail(f"file {table.path('file')}: {cause}", "file")
        raise
    return ground


def _heights(path: Path) -> FloatArray:
    """Heights of a .npy file, or of a text with a row in each line.

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
    found = {"kind": kind, **table_of(ground, without=large)}
    if sum(array.size for array in arrays.values()) <= MOST_INLINE:
        return {**found, **arrays}
    if kind == "heights":
        return {**found, "file": beside.array("heights.npy", arrays["heights"])}
    return {**found, "file": beside.arrays("ground.npz", arrays)}
