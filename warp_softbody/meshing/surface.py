"""A closed surface to be filled with tets, read by trimesh and checked."""

from __future__ import annotations

import contextlib
import io
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from warp_softbody.errors import MeshError

if TYPE_CHECKING:
    import trimesh

EXTENSIONS = (".stl", ".obj", ".ply", ".off")
"""Extensions of surface files."""


@dataclass(frozen=True, kw_only=True)
class Surface:
    """One closed surface with outward triangles.

    Attributes:
        points: (n, 3) float64 m.
        faces: (f, 3) int32.
        volume: enclosed volume, m^3, positive.
        area: m^2.
        source: what sentences call it, such as its file name.
    """

    points: npt.NDArray[np.float64]
    faces: npt.NDArray[np.int32]
    volume: float
    area: float
    source: str

    @property
    def bounds(self) -> npt.NDArray[np.float64]:
        """Lowest and highest corner (2, 3), m."""
        return np.stack([self.points.min(axis=0), self.points.max(axis=0)])

    @property
    def diagonal(self) -> float:
        """Length of the box's diagonal, m."""
        return float(np.linalg.norm(np.ptp(self.bounds, axis=0)))


def load_surface(surface: str | Path | trimesh.Trimesh) -> Surface:
    """Take a surface file or a trimesh surface as one closed surface.

    Points that differ only in their texture or normal are merged, and a surface that is inside out
    as a whole is turned.

    Raises:
        MeshError: missing or unreadable file, no triangles, points that are not finite, open edges,
            triangles that disagree about the outside, no volume, or several parts.
    """
    if isinstance(surface, str | Path):
        source = str(surface)
        mesh = _read(Path(surface))
    else:
        source = "surface"
        mesh = surface.copy()
    _check_points(mesh, source)
    mesh.merge_vertices(merge_tex=True, merge_norm=True)
    mesh.update_faces(mesh.nondegenerate_faces())
    mesh.update_faces(mesh.unique_faces())
    mesh.remove_unreferenced_vertices()
    _check_closed(mesh, source)
    if _volume(mesh) < 0.0:
        mesh.invert()
    return Surface(
        points=np.array(mesh.vertices, dtype=np.float64),
        faces=np.array(mesh.faces, dtype=np.int32),
        volume=_volume(mesh),
        area=float(mesh.area),
        source=source,
    )


def _read(path: Path) -> trimesh.Trimesh:
    """Read a file without any of trimesh's own repairs, which would drop what is to be reported."""
    import trimesh

    if not path.is_file():
        raise MeshError(f"{path}: there is no such file")
    if path.suffix.lower() not in EXTENSIONS:
        raise MeshError(
            f"{path}: no surface format is known for the extension {path.suffix!r}; "
            f"take one of {', '.join(EXTENSIONS)}"
        )
    try:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            mesh = trimesh.load_mesh(path, process=False)
    # Broken files make trimesh raise almost anything.
    except Exception as error:
        reason = " ".join(str(error).split())
        raise MeshError(f"{path}: cannot be read as a {path.suffix} surface: {reason}") from error
    if not isinstance(mesh, trimesh.Trimesh):
        raise MeshError(f"{path}: it holds no triangles")
    return mesh


def _check_points(mesh: trimesh.Trimesh, source: str) -> None:
    points = np.asarray(mesh.vertices, dtype=np.float64)
    if len(mesh.faces) == 0:
        raise MeshError(f"{source}: it holds no triangles")
    wrong = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if wrong.size:
        raise MeshError(f"{source}: point {wrong[0]} is not finite: {points[wrong[0]].tolist()}")


def _check_closed(mesh: trimesh.Trimesh, source: str) -> None:
    """Refuse what does not enclose one volume."""
    if len(mesh.faces) == 0:
        raise MeshError(f"{source}: it holds no triangles of positive area")
    edges = np.sort(mesh.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    _, uses = np.unique(edges, axis=0, return_counts=True)
    open_count, crowded = int((uses == 1).sum()), int((uses > 2).sum())
    if open_count:
        raise MeshError(f"{source}: the surface is not closed: it has {open_count} open edges")
    if crowded:
        raise MeshError(f"{source}: {crowded} edges are shared by more than two triangles")
    parts = int(mesh.body_count)
    if parts != 1:
        raise MeshError(f"{source}: the surface has {parts} separate parts, but a body is one part")
    if not mesh.is_winding_consistent:
        raise MeshError(f"{source}: neighbouring triangles disagree about which side is outside")
    smallest = 1e-12 * float(np.linalg.norm(np.ptp(mesh.vertices, axis=0))) ** 3
    volume = _volume(mesh)
    if abs(volume) <= smallest:
        raise MeshError(f"{source}: the surface encloses no volume ({volume:.3g} m^3)")


def _volume(mesh: trimesh.Trimesh) -> float:
    """Enclosed volume, m^3; trimesh's own divides by it on the way."""
    a, b, c = (mesh.triangles[:, corner] - mesh.vertices[0] for corner in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6.0
