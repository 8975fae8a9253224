"""A closed surface is read, cleaned and checked before it is filled with tets."""

from __future__ import annotations

import os
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from warp_softbody.body.close_points import first_of_close
from warp_softbody.body.mesh_checks import LARGEST_COORDINATE
from warp_softbody.body.mesh_formats.contents import ReadingFailed
from warp_softbody.body.mesh_formats.polygons import Triangles
from warp_softbody.body.mesh_formats.surface_files import READERS, read_surface
from warp_softbody.body.meshing.surface_checks import check_closed, enclosed_volume, face_areas
from warp_softbody.errors import InputError, MeshError, MeshWarning

if TYPE_CHECKING:
    import trimesh

EXTENSIONS = tuple(READERS)
"""Extensions of surface files."""

MERGE_TOLERANCE = 1e-8
"""Points closer than this times the diagonal of the box are one point: files give single precision
or some seven digits."""


@dataclass(frozen=True, kw_only=True)
class Surface:
    """One closed surface with outward triangles.

    Attributes:
        points: (n, 3) float64 m.
        faces: (f, 3) int32.
        volume: enclosed volume, m^3, positive.
        area: m^2.
        source: what sentences call it, such as its file name.
        crossing: a clause on triangles that cross each other, empty where none do.
    """

    points: npt.NDArray[np.float64]
    faces: npt.NDArray[np.int32]
    volume: float
    area: float
    source: str
    crossing: str = ""

    @property
    def bounds(self) -> npt.NDArray[np.float64]:
        """Lowest and highest corner (2, 3), m."""
        return np.stack([self.points.min(axis=0), self.points.max(axis=0)])

    @property
    def diagonal(self) -> float:
        """Length of the box's diagonal, m."""
        return float(np.linalg.norm(np.ptp(self.bounds, axis=0)))

    @property
    def thickness(self) -> float:
        """Twice the volume over the area, m: that of a plate, the radius of a wire."""
        return 2.0 * self.volume / self.area


def load_surface(surface: str | Path | trimesh.Trimesh) -> Surface:
    """Take a surface file or a trimesh surface as one closed surface.

    Points at one place are merged, and a surface that is inside out as a whole is turned. A
    `MeshWarning` tells of points and triangles that were left out and of triangles that cross.

    Raises:
        MeshError: missing or unreadable file, no triangles, points that are not finite, open edges,
            triangles that disagree about the outside, no volume, or several parts; flaws are told
            with their number and the place of one.
    """
    if isinstance(surface, str | Path):
        source = str(surface)
        given = read_triangles(Path(surface))
    elif not (hasattr(surface, "vertices") and hasattr(surface, "faces")):
        raise InputError(
            f"a surface is a file's path or has vertices and faces, got {type(surface).__name__}"
        )
    else:
        source = "surface"
        given = Triangles(np.array(surface.vertices, np.float64), np.array(surface.faces, np.int64))
    _check_points(given, source)
    points, faces = _cleaned(given, source)
    faces, crossing, touching = check_closed(points, faces, source)
    for clause in filter(None, (crossing, touching)):
        warnings.warn(f"{source}: {clause}", MeshWarning, stacklevel=2)
    return Surface(
        points=points,
        faces=faces.astype(np.int32),
        volume=enclosed_volume(points, faces),
        area=float(face_areas(points, faces).sum()),
        source=source,
        crossing=crossing,
    )


def read_triangles(path: Path) -> Triangles:
    """Points and triangles of a surface file, as they stand in it.

    Raises:
        MeshError: the file is missing, of no known format, or cannot be read.
    """
    if not os.path.isfile(path):
        raise MeshError(f"{path}: there is no such file")
    if path.suffix.lower() not in EXTENSIONS:
        raise MeshError(
            f"{path}: no surface format is known for the extension {path.suffix!r}; "
            f"take one of {', '.join(EXTENSIONS)}"
        )
    try:
        return read_surface(path)
    except (OSError, ReadingFailed) as error:
        reason = getattr(error, "strerror", None) or error
        raise MeshError(
            f"{path}: cannot be read as a {path.suffix.lower()} surface: {reason}"
        ) from error


def _check_points(given: Triangles, source: str) -> None:
    points, faces = given
    if len(faces) == 0:
        raise MeshError(f"{source}: it holds no triangles")
    wrong = faces[(faces < 0) | (faces >= len(points))]
    if wrong.size:
        raise MeshError(f"{source}: a triangle has point {wrong[0]} of {len(points)} points")
    wrong = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if wrong.size:
        raise MeshError(f"{source}: point {wrong[0]} is not finite: {points[wrong[0]].tolist()}")
    used = np.unique(faces)
    wrong = used[(np.abs(points[used]) > LARGEST_COORDINATE).any(axis=1)]
    if wrong.size:
        raise MeshError(
            f"{source}: point {wrong[0]} lies too far from the origin: "
            f"{points[wrong[0]].tolist()}, but at most {LARGEST_COORDINATE:g} m are taken"
        )


def _cleaned(given: Triangles, source: str) -> Triangles:
    """Points that triangles use, each once, and triangles with three corners, each once."""
    used, compact = np.unique(given.faces, return_inverse=True)
    points = given.points[used]
    diagonal = float(np.linalg.norm(np.ptp(points, axis=0)))
    faces = first_of_close(points, MERGE_TOLERANCE * diagonal)[compact.reshape(-1, 3)]
    flat = (faces == np.roll(faces, 1, axis=1)).any(axis=1)
    faces = faces[~flat]
    # Each triangle begins with its lowest point, so that equal ones with one outside are equal.
    turn = (np.argmin(faces, axis=1)[:, None] + np.arange(3)) % 3
    _, first = np.unique(np.take_along_axis(faces, turn, axis=1), axis=0, return_index=True)
    left_out = {
        "points that no triangle uses": len(given.points) - len(used),
        "triangles without area": int(flat.sum()),
        "triangles that stand twice": len(faces) - len(first),
    }
    told = [f"{count} {what}" for what, count in left_out.items() if count]
    if told:
        warnings.warn(f"{source}: {', '.join(told)} are left out", MeshWarning, stacklevel=3)
    kept, compact = np.unique(faces[np.sort(first)], return_inverse=True)
    return Triangles(points[kept], compact.reshape(-1, 3).astype(np.int64))
