"""Tet files through meshio, with its habits (printing, exiting, half-written files) kept inside."""

from __future__ import annotations

import contextlib
import io
import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import numpy.typing as npt

from warp_softbody.errors import MeshError, OutputError
from warp_softbody.replacing import replacing

WRITABLE = (".vtu", ".vtk", ".msh", ".mesh", ".inp")
"""Extensions of one-file formats that keep double precision."""

OTHER_SOLIDS = ("hexahedron", "wedge", "pyramid", "tetra10")
"""Cells that fill space but cannot be taken: leaving them out would change the body."""


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Keep what meshio prints off the user's terminal."""
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        yield


def readable_extensions() -> set[str]:
    """Extensions, lower case with the dot, that meshio has a reader for."""
    import meshio

    return set(meshio.extension_to_filetypes)


def read_tets(path: Path) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
    """Read points (n, 3) and tets (m, 4), unchecked, in native byte order.

    Raises:
        MeshError: the file is missing, of an unknown or broken format, or holds other solids.
    """
    import meshio

    if not path.is_file():
        raise MeshError(f"{path}: there is no such file")
    if path.suffix.lower() not in readable_extensions():
        raise MeshError(f"{path}: no mesh format is known for the extension {path.suffix!r}")
    try:
        with _quiet():
            mesh = meshio.read(path)
    # meshio ends the whole program on some broken files, and raises almost anything on others.
    except (Exception, SystemExit) as error:
        reason = " ".join(str(error).split()) if isinstance(error, Exception) else ""
        raise MeshError(
            f"{path}: cannot be read as a {path.suffix} mesh" + (f": {reason}" if reason else "")
        ) from error
    kinds = sorted({block.type for block in mesh.cells})
    others = [kind for kind in kinds if kind in OTHER_SOLIDS]
    if others:
        raise MeshError(f"{path}: only linear tets are taken, but it holds {', '.join(others)}")
    if "tetra" not in kinds:
        raise MeshError(f"{path}: it holds no tets (found: {', '.join(kinds) or 'no cells'})")
    # Some readers hand out big-endian arrays; these conversions make them native.
    points = np.array(mesh.points, dtype=np.float64)
    return points, np.array(mesh.get_cells_type("tetra"), dtype=np.int64)


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
    if path.is_dir():
        raise OutputError(f"{path}: cannot be written: it is a folder")
    if not path.parent.is_dir():
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
    except OSError as error:
        raise OutputError(f"{path}: cannot be written: {error.strerror or error}") from error
