"""The named groups of points and cells are collected from a file that meshio has read."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

Numbers = npt.NDArray[np.int64]

KINDS_OF_DIMENSION = {0: ("vertex",), 1: ("line",), 2: ("triangle", "quad"), 3: ("tetra",)}


def named_groups(mesh: Any, file_format: str) -> tuple[dict[str, Numbers], set[str], list[str]]:
    """Points of each group, the kinds of the cells in groups, and a sentence on each broken one."""
    found: dict[str, list[Numbers]] = {}
    broken: list[str] = []
    kinds: set[str] = set()
    for name, kind, cells, rows in _parts(mesh, file_format):
        try:
            points = cells[np.asarray(rows).astype(np.int64)].astype(np.int64).ravel()
            inside = (points >= 0).all() and (points < len(mesh.points)).all()
        except (IndexError, ValueError, TypeError):
            inside = False
        if not inside:
            broken.append(f"its group {name!r} names what is not in it and is left out")
        elif len(points):
            found.setdefault(name, []).append(points)
            kinds.add(kind)
    groups = {name: np.unique(np.concatenate(parts)) for name, parts in found.items()}
    return groups, kinds, broken


def _parts(mesh: Any, file_format: str) -> Iterator[tuple[str, str, Any, Any]]:
    """Name, kind of cells, table of their points and its rows, of each part of a group."""
    for name, numbers in mesh.point_sets.items():
        yield str(name), "", np.arange(len(mesh.points)), numbers
    first = np.cumsum([0, *(len(block.data) for block in mesh.cells)])
    for name, parts in mesh.cell_sets.items():
        if not str(name).startswith("gmsh:"):
            for block, rows, before in zip(mesh.cells, parts, first, strict=False):
                if rows is not None:
                    # meshio counts the cells of FLAC3D through all blocks, those of others in each
                    shift = int(before) if file_format == "flac3d" else 0
                    yield str(name), block.type, block.data, np.asarray(rows) - shift
    for name, tag in mesh.field_data.items():
        for block, values in zip(mesh.cells, mesh.cell_data.get("gmsh:physical", []), strict=False):
            if len(tag) == 2 and block.type in KINDS_OF_DIMENSION.get(int(tag[1]), ()):
                yield str(name), block.type, block.data, np.flatnonzero(values == tag[0])
