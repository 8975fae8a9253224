"""meshio reads a tet file here, in a process of its own, and all that it holds is returned."""

from __future__ import annotations

import importlib
import sys
import types
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from warp_softbody.body.mesh_formats.contents import Contents, ReadingFailed
from warp_softbody.body.mesh_formats.declared import compare, declare
from warp_softbody.body.mesh_formats.groups import named_groups

FLAT_CELLS = ("vertex", "line", "triangle", "quad", "polygon")
"""Beginnings of the names of cells that fill no space: leaving them out keeps the body."""


def read_by_meshio(path: Path, file_format: str) -> Contents:
    """Points, tets and named groups of a file.

    Raises:
        ReadingFailed: meshio refuses the file, or what it took is not what the file declares.
        OSError: it, or the file that belongs to it, cannot be opened.
    """
    declared = declare(path, file_format)
    mesh = _read(path, file_format)
    sizes = Counter[str]()
    for block in mesh.cells:
        sizes[str(block.type)] += len(block.data)
    _refuse_other_solids(sizes)
    notes = compare(declared, len(mesh.points), sizes)
    groups, named, broken = named_groups(mesh, file_format)
    left_out = [f"{n} {kind}" for kind, n in sorted(sizes.items()) if kind not in (*named, "tetra")]
    if left_out:
        notes.append(f"its {', '.join(left_out)} cells are left out, because tets alone are taken")
    tets = [block.data for block in mesh.cells if block.type == "tetra"]
    # Some readers hand out big-endian arrays; these conversions make them native.
    points = np.array(mesh.points, dtype=np.float64)
    corners = np.array(np.concatenate(tets), dtype=np.int64)
    return Contents(points, corners, groups, (*notes, *broken))


def _read(path: Path, file_format: str) -> Any:
    """What meshio makes of a file."""
    if file_format == "xdmf" and b"HDF" not in path.read_bytes():
        # meshio imports h5py for every XDMF, though only those with HDF5 files beside them need it.
        sys.modules.setdefault("h5py", types.ModuleType("h5py"))
    try:
        # `meshio.read` would end the program where a reader refuses a file.
        module = "dolfin" if file_format == "dolfin-xml" else file_format
        reader = importlib.import_module(f"meshio.{module}")
        if module == "dolfin":
            # It would read every file beside this one whose name begins with this one's.
            reader._dolfin._read_cell_data = lambda filename: {}
        return reader.read(str(path))
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


def _refuse_other_solids(sizes: Counter[str]) -> None:
    """Refuse a file whose body is not of linear tets alone."""
    others = sorted(kind for kind in sizes if kind != "tetra" and not kind.startswith(FLAT_CELLS))
    if others:
        raise ReadingFailed(f"only linear tets are taken, but it holds {', '.join(others)}")
    if not sizes["tetra"]:
        kinds = ", ".join(sorted(kind for kind in sizes if sizes[kind])) or "no cells"
        raise ReadingFailed(f"it holds no tets (found: {kinds})")
