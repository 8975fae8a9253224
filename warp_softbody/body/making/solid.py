"""What is inside a surface, flawed or not: its signed distance by generalised winding numbers.

Parts are united, holes closed and cavities kept as the winding number has it (Jacobson, Kavan and
Sorkine-Hornung, ACM TOG 32(4), 2013); libigl computes it (Barill et al., ACM TOG 37(4), 2018).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from warp_softbody.arrays import FloatArray
from warp_softbody.body.close_points import first_of_close
from warp_softbody.body.mesh_checks import LARGEST_COORDINATE
from warp_softbody.errors import MeshError, MissingExtraError

Numbers = npt.NDArray[np.int64]

MERGE_TOLERANCE = 1e-6
"""Points nearer than this share of the box's diagonal are one point."""

CERTAIN = 1.1
"""Winding numbers are approximate: from 1 / 2 + 1 / 2.2 on a point is as far inside as it seems."""

HALF = 0.5
"""Winding number from which on a point is inside."""


@dataclass(frozen=True)
class Solid:
    """A surface of which it is known what is inside.

    Attributes:
        points: (n, 3) m.
        faces: (f, 3), whose parts agree about the outside.
        repairs: what was done to the surface, a clause each.
        source: what sentences call it.
    """

    points: FloatArray
    faces: Numbers
    repairs: tuple[str, ...]
    source: str

    @property
    def bounds(self) -> FloatArray:
        """Lowest and highest corner (2, 3) of the box, m."""
        return np.stack([self.points.min(axis=0), self.points.max(axis=0)])

    def distance(self, places: FloatArray) -> FloatArray:
        """Distance (k,) m of places (k, 3) to the surface, positive inside."""
        igl = libigl()
        kind = igl.SIGNED_DISTANCE_TYPE_UNSIGNED
        found: FloatArray = igl.signed_distance(places, self.points, self.faces, kind)[0]
        # Across a hole the number falls from one to nothing, and the skin is where it is a half.
        side: FloatArray = np.clip(CERTAIN * (2.0 * self.winding(places) - 1.0), -1.0, 1.0)
        return found * side

    def winding(self, places: FloatArray) -> FloatArray:
        """Winding number (k,) of the surface around places (k, 3): 1 inside, 0 outside."""
        found: FloatArray = libigl().fast_winding_number(self.points, self.faces, places)
        return found


def solid_of(points: FloatArray, faces: Numbers, source: str) -> Solid:
    """Merge points, turn parts that are inside out, and tell what else is wrong.

    Raises:
        MeshError: it encloses nothing.
        MissingExtraError: libigl is not installed.
    """
    igl = libigl()
    if abs(points).max() > LARGEST_COORDINATE:
        raise MeshError(
            f"{source}: a point lies {abs(points).max():.3g} m from the origin, but at most "
            f"{LARGEST_COORDINATE:g} m are taken"
        )
    diagonal = float(np.linalg.norm(np.ptp(points, axis=0)))
    faces = first_of_close(points, MERGE_TOLERANCE * diagonal)[faces]
    flat = (faces == np.roll(faces, 1, axis=1)).any(axis=1)
    used, faces = np.unique(faces[~flat], return_inverse=True)
    points, faces = points[used], faces.reshape(-1, 3)
    if not len(faces):
        raise MeshError(f"{source}: it holds no triangles of positive area")
    agreeing, patch = igl.bfs_orient(faces)
    turned = int((agreeing != faces).any(axis=1).sum())
    parts = _parts(faces, len(points))
    repairs = [f"{_count(parts, 'part')} united"] if parts > 1 else []
    if open_edges := _open_edges(faces):
        repairs.append(f"{_count(open_edges, 'open edge')} closed")
    agreeing, inside_out = _outward(points, agreeing, np.asarray(patch))
    if turned:
        repairs.append("triangles turned that disagreed about the outside")
    elif inside_out:
        repairs.append(f"{_count(inside_out, 'part')} turned inside out")
    return Solid(points, agreeing, tuple(repairs), source)


def _count(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"


def libigl() -> Any:
    """libigl, which is loaded when it is needed."""
    try:
        import igl
    except ImportError as error:
        raise MissingExtraError(
            "libigl is not installed, which finds what is inside a surface; "
            '"pip install libigl" brings it'
        ) from error
    return igl


def _parts(faces: Numbers, count: int) -> int:
    ends = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]]])
    graph = coo_array((np.ones(len(ends)), ends.T), shape=(count, count))
    return int(connected_components(graph, directed=False)[0])


def _open_edges(faces: Numbers) -> int:
    """Number of edges of one triangle."""
    edges = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    return int((np.unique(edges, axis=0, return_counts=True)[1] == 1).sum())


def _outward(points: FloatArray, faces: Numbers, patch: Numbers) -> tuple[Numbers, int]:
    """The triangles, with patches that enclose a negative volume turned, but for cavities.

    A patch of negative volume that lies within the others is the skin of a cavity.
    """
    igl = libigl()
    faces = faces.copy()
    corners = points[faces] - points.mean(axis=0)
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    inward = np.flatnonzero(np.bincount(patch, weights=volume) < 0.0)
    rest = faces[~np.isin(patch, inward)]
    turned = 0
    for number in inward:
        mine = patch == number
        place = points[faces[mine][:1, 0]]
        around = igl.fast_winding_number(points, rest, place)[0] if len(rest) else 0.0
        if around < HALF:
            faces[mine] = faces[mine][:, ::-1]
            turned += 1
    return faces, turned
