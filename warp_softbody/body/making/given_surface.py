"""A surface as its file gives it: triangles, and the unit and the up axis that the format has."""

from __future__ import annotations

import os
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.body import other_surfaces
from warp_softbody.body.mesh_formats.contents import ReadingFailed
from warp_softbody.body.mesh_formats.polygons import Triangles
from warp_softbody.body.mesh_formats.surface_files import READERS, read_surface
from warp_softbody.body.skin import Skin
from warp_softbody.body.skin_formats.glb_skin import read_glb_skin
from warp_softbody.errors import MeshError
from warp_softbody.inputs import checks, input_kinds

GLB = ".glb"
EXTENSIONS = (*READERS, GLB)
"""Extensions of the files that are read."""

GLB_AXES = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""Takes rows of points as the skin of a glTF file has them, z upwards, to those of the file."""

LARGEST_FILE = 2**30
"""Bytes of a file of glTF that are read."""


class GivenSurface(NamedTuple):
    """Triangles as they are given, whatever is wrong with them.

    Attributes:
        points: (n, 3) in the file's unit.
        faces: (f, 3) their corners.
        unit: the unit that the format has; None where it has none.
        up: the axis that the format has upwards; None where it has none.
        source: what sentences call it.
    """

    points: FloatArray
    faces: npt.NDArray[np.int64]
    unit: str | None
    up: str | None
    source: str


def given_surface(surface: object) -> GivenSurface:
    """Read a surface file, or take the vertices and faces of a trimesh surface.

    Raises:
        MeshError: it is missing, of no known format, unreadable, or without triangles.
    """
    if isinstance(surface, str | os.PathLike):
        path = input_kinds.path("surface of a character", surface)
        given = _read(path)
    elif isinstance(surface, Skin):
        given = _of_skin(surface, "skin")
    elif hasattr(surface, "vertices") and hasattr(surface, "faces"):
        points = np.array(surface.vertices, np.float64).reshape(-1, 3)
        faces = np.array(surface.faces, np.int64).reshape(-1, 3)
        given = GivenSurface(points, faces, None, None, "surface")
    else:
        checks.refuse("surface of a character", "a file, a Skin or a trimesh.Trimesh", surface)
    points, faces, source = given.points, given.faces, given.source
    if not len(faces):
        raise MeshError(f"{source}: it holds no triangles")
    if ((faces < 0) | (faces >= len(points))).any():
        wrong = faces[(faces < 0) | (faces >= len(points))][0]
        raise MeshError(f"{source}: a triangle has point {wrong} of {len(points)} points")
    used, compact = np.unique(faces, return_inverse=True)
    bad = used[~np.isfinite(points[used]).all(axis=1)]
    if bad.size:
        raise MeshError(f"{source}: point {bad[0]} is not finite: {points[bad[0]].tolist()}")
    return given._replace(points=points[used], faces=compact.reshape(-1, 3).astype(np.int64))


def _of_skin(skin: Skin, source: str) -> GivenSurface:
    """The triangles of a skin, which is in m with z upwards."""
    return GivenSurface(np.array(skin.points), skin.faces.astype(np.int64), "m", "z", source)


def _read(path: Path) -> GivenSurface:
    extension = path.suffix.lower()
    if not path.is_file():
        raise MeshError(f"{path}: there is no such file")
    if extension not in EXTENSIONS:
        raise MeshError(
            f"{path}: no surface format is known for the extension {path.suffix!r}; "
            f"take one of {', '.join((*EXTENSIONS, *other_surfaces.READERS))}"
        )
    try:
        if extension == GLB:
            return GivenSurface(*_read_glb(path), "m", "y", str(path))
        return GivenSurface(*read_surface(path), None, None, str(path))
    except (OSError, ReadingFailed) as error:
        reason = getattr(error, "strerror", None) or error
        raise MeshError(f"{path}: cannot be read as a {extension} surface: {reason}") from error


def _read_glb(path: Path) -> Triangles:
    """Triangles of all meshes of a binary glTF file, each where its node puts it, y upwards."""
    if path.stat().st_size > LARGEST_FILE:
        raise ReadingFailed(f"it has more than {LARGEST_FILE >> 20} MiB")
    try:
        found = read_glb_skin(path)
    except ValueError as error:
        raise ReadingFailed(str(error)) from error
    return Triangles(found.points @ GLB_AXES, found.faces)
