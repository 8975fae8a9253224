"""Read a tet file by meshio and tell all that it holds; runs in a process of its own."""

from __future__ import annotations

import importlib
import sys
import types
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from warp_softbody.mesh_formats.contents import Contents, ReadingFailed
from warp_softbody.mesh_formats.declared import compare, declare

FLAT_CELLS = ("vertex", "line", "triangle", "quad", "polygon")
"""Beginnings of the names of cells that fill no space: leaving them out keeps the body."""

Numbers = npt.NDArray[np.int64]


def read_by_meshio(path: Path, file_format: str) -> Contents:
    """Points, tets and named groups of a file.

    Raises:
        ReadingFailed: meshio refuses the file, or what it took is not what the file declares.
    """
    declared = declare(path, file_format)
    if file_format == "xdmf" and b"HDF" not in path.read_bytes():
        # meshio imports h5py for every XDMF, though only those with HDF5 files beside them need it.
        sys.modules.setdefault("h5py", types.ModuleType("h5py"))
    try:
        # `meshio.read` would end the program where a reader refuses a file.
        module = "dolfin" if file_format == "dolfin-xml" else file_format
        mesh = importlib.import_module(f"meshio.{module}").read(str(path))
    # meshio's readers raise almost anything on broken files.
    except ModuleNotFoundError as error:
        raise ReadingFailed(
            f"reading it needs the Python package {error.name!r}, which is not installed"
        ) from error
    except MemoryError as error:
        raise ReadingFailed("it asks for more memory than a file of its size may") from error
    except KeyError as error:
        raise ReadingFailed(f"it refers to {error}, which it does not hold") from error
    except (Exception, SystemExit) as error:
        reason = " ".join(str(error).split())[:200]
        raise ReadingFailed(reason or f"its reader failed ({type(error).__name__})") from error
    sizes = Counter[str]()
    for block in mesh.cells:
        sizes[str(block.type)] += len(block.data)
    _refuse_other_solids(sizes)
    notes = compare(declared, len(mesh.points), sizes)
    groups, named = _groups(mesh)
    left_out = [f"{n} {kind}" for kind, n in sorted(sizes.items()) if kind not in (*named, "tetra")]
    if left_out:
        notes.append(f"its {', '.join(left_out)} cells are left out, because tets alone are taken")
    tets = [block.data for block in mesh.cells if block.type == "tetra"]
    # Some readers hand out big-endian arrays; these conversions make them native.
    points = np.array(mesh.points, dtype=np.float64)
    return Contents(points, np.array(np.concatenate(tets), np.int64), groups, tuple(notes))


def _refuse_other_solids(sizes: Counter[str]) -> None:
    """Refuse a file whose body is not of linear tets alone."""
    others = sorted(kind for kind in sizes if kind != "tetra" and not kind.startswith(FLAT_CELLS))
    if others:
        raise ReadingFailed(f"only linear tets are taken, but it holds {', '.join(others)}")
    if not sizes["tetra"]:
        kinds = ", ".join(sorted(kind for kind in sizes if sizes[kind])) or "no cells"
        raise ReadingFailed(f"it holds no tets (found: {kinds})")


def _groups(mesh: Any) -> tuple[dict[str, Numbers], set[str]]:
    """Points of each named group of points or cells, and the kinds of the cells that have names."""
    found: dict[str, list[Numbers]] = {}
    named: set[str] = set()

    def add(name: object, points: Any, kind: str = "") -> None:
        if len(points):
            found.setdefault(str(name), []).append(np.asarray(points, dtype=np.int64).ravel())
            named.add(kind)

    for name, points in mesh.point_sets.items():
        add(name, points)
    for name, parts in mesh.cell_sets.items():
        for block, rows in zip(mesh.cells, parts, strict=True):
            if rows is not None and not str(name).startswith("gmsh:"):
                add(name, block.data[np.asarray(rows, dtype=np.int64)], block.type)
    tags = mesh.cell_data.get("gmsh:physical", [])
    for name, tag in mesh.field_data.items():
        for block, values in zip(mesh.cells, tags, strict=False):
            if len(tag) == 2 and _dimension(block.type) == tag[1]:
                add(name, block.data[np.asarray(values) == tag[0]], block.type)
    return {name: np.unique(np.concatenate(parts)) for name, parts in found.items()}, named


def _dimension(kind: str) -> int:
    return {"vertex": 0, "line": 1, "tetra": 3}.get(kind, 2)
