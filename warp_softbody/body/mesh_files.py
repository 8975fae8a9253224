"""Tet files are read by meshio in a process of its own, and written whole or not at all."""

from __future__ import annotations

import contextlib
import io
import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import numpy.typing as npt

from warp_softbody.atomic_files import replacing
from warp_softbody.body.mesh_formats.child import READER, ReadingProcess, read_in_child
from warp_softbody.body.mesh_formats.contents import Contents, ReadingFailed
from warp_softbody.errors import MeshError, OutputError

WRITABLE = (".vtu", ".vtk", ".msh", ".mesh", ".inp")
"""Extensions of one-file formats that keep double precision."""

SURFACES = (".stl", ".obj", ".ply", ".off")
"""Extensions of files that hold surfaces and never tets."""

FORMATS = {
    ".avs": "avsucd",
    ".bdf": "nastran",
    ".cgns": "cgns",
    ".dat": "tecplot",
    ".dato": "permas",
    ".e": "exodus",
    ".ele": "tetgen",
    ".ex2": "exodus",
    ".exo": "exodus",
    ".f3grid": "flac3d",
    ".fem": "nastran",
    ".h5m": "h5m",
    ".hmf": "hmf",
    ".inp": "abaqus",
    ".mdpa": "mdpa",
    ".med": "med",
    ".mesh": "medit",
    ".meshb": "medit",
    ".msh": "gmsh",
    ".nas": "nastran",
    ".node": "tetgen",
    ".post": "permas",
    ".su2": "su2",
    ".tec": "tecplot",
    ".ugrid": "ugrid",
    ".vol": "netgen",
    ".vtk": "vtk",
    ".vtu": "vtu",
    ".xdmf": "xdmf",
    ".xml": "dolfin-xml",
    ".xmf": "xdmf",
}
"""meshio's name of the format of each extension; an Ansys .msh is told by its first byte."""


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Keep what meshio prints off the user's terminal."""
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        yield


def read_tets(path: Path, reader: ReadingProcess = READER) -> Contents:
    """Read points, tets and named groups, unchecked; the notes name the file.

    Raises:
        MeshError: the file is missing, of an unknown or broken format, or holds other solids.
    """
    suffix = path.suffix.lower()
    if not os.path.isfile(path):
        raise MeshError(f"{path}: there is no such file")
    if suffix in SURFACES:
        raise MeshError(f"{path}: a surface holds no tets; TetMesh.from_surface fills it with them")
    if suffix not in FORMATS:
        raise MeshError(f"{path}: no mesh format is known for the extension {path.suffix!r}")
    try:
        found = read_in_child(path, _format(path), reader)
    except (OSError, ReadingFailed) as error:
        reason = getattr(error, "strerror", None) or error
        raise MeshError(f"{path}: cannot be read as a {suffix} mesh: {reason}") from error
    return found._replace(notes=tuple(f"{path}: {note}" for note in found.notes))


def _format(path: Path) -> str:
    """Name by which meshio knows the format of a file."""
    if path.suffix.lower() == ".msh":
        with path.open("rb") as stream:
            if stream.read(64).lstrip().startswith(b"("):
                return "ansys"
    return FORMATS[path.suffix.lower()]


def check_writable(path: Path) -> None:
    """Refuse an output path before any work is done for it.

    Raises:
        OutputError: unknown extension, missing folder, or a folder that cannot be written.
    """
    if path.suffix.lower() not in WRITABLE:
        raise OutputError(
            f"{path}: cannot write a mesh with the extension {path.suffix!r}; "
            f"take one of {', '.join(WRITABLE)}"
        )
    if os.path.isdir(path):
        raise OutputError(f"{path}: cannot be written: it is a folder")
    if os.path.isfile(path.parent):
        raise OutputError(f"{path}: cannot be written: {path.parent} is a file and no folder")
    if not os.path.isdir(path.parent):
        raise OutputError(f"{path}: cannot be written: there is no folder {path.parent}")
    if not os.access(path.parent, os.W_OK | os.X_OK):
        raise OutputError(f"{path}: cannot be written: no permission in {path.parent}")


def write_tets(path: Path, points: npt.NDArray[np.float64], tets: npt.NDArray[np.int32]) -> None:
    """Write a tet file, in one step.

    Raises:
        OutputError: unknown extension, or the file cannot be written; nothing is left behind.
    """
    import meshio

    check_writable(path)
    try:
        with replacing(path) as beside, _quiet():
            meshio.Mesh(points, [("tetra", tets)]).write(beside)
    # A name that no file can have is a ValueError.
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise OutputError(f"{path}: cannot be written: {reason}") from error
