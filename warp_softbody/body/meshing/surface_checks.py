"""A surface must enclose one body; each flaw is reported with its number and the place of one."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from warp_softbody.arrays import FloatArray
from warp_softbody.body.meshing.crossings import crossing_triangles
from warp_softbody.errors import MeshError

Numbers = npt.NDArray[np.int64]

FLAT = 1e-12
"""A volume below this times area and diagonal is none: rounding leaves that much of a flat one."""

MOST_TESTED = 200_000
"""Triangles up to which crossings are looked for, some five seconds of work."""


class Closed(NamedTuple):
    """A surface that encloses one volume, and what may still be wrong with it.

    Attributes:
        faces: (f, 3) triangles, turned where all were inside out.
        crossing: a clause on triangles that cross each other, empty where none do.
        touching: a clause on points at which the surface touches itself, empty where it does not.
    """

    faces: Numbers
    crossing: str
    touching: str


def check_closed(points: FloatArray, faces: Numbers, source: str) -> Closed:
    """Check that triangles (f, 3) over points (n, 3) m enclose one volume.

    Raises:
        MeshError: what keeps the surface from enclosing one volume.
    """
    if len(faces) == 0:
        raise MeshError(f"{source}: it holds no triangles of positive area")
    pairs = _neighbours(points, faces, source)
    _check_sides(points, faces, pairs, source)
    crossing = _crossing(points, faces)
    parts, part_of = connected_components(_graph(pairs[:, :2], len(faces)), directed=False)
    if parts != 1:
        place = _place(points[faces[np.flatnonzero(part_of == 1)[0]]].mean(axis=0))
        raise MeshError(
            f"{source}: the surface has {parts} separate parts, but a body is one part; "
            f"one of them is at {place}" + (f", and {crossing}" if crossing else "")
        )
    volume = enclosed_volume(points, faces)
    diagonal = float(np.linalg.norm(np.ptp(points, axis=0)))
    if abs(volume) <= FLAT * float(face_areas(points, faces).sum()) * diagonal:
        raise MeshError(f"{source}: the surface encloses no volume ({volume:.3g} m^3)")
    outward = faces if volume > 0.0 else faces[:, ::-1].copy()
    return Closed(outward, crossing, _touching(points, faces, pairs))


def enclosed_volume(points: FloatArray, faces: Numbers) -> float:
    """Volume in m^3 that a closed surface encloses; negative where it is inside out."""
    a, b, c = (points[faces[:, corner]] - points[faces[0, 0]] for corner in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6.0


def face_areas(points: FloatArray, faces: Numbers) -> FloatArray:
    """Areas (f,) of triangles, m^2."""
    a, b, c = (points[faces[:, corner]] for corner in range(3))
    return np.asarray(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1))


def _neighbours(points: FloatArray, faces: Numbers, source: str) -> Numbers:
    """Both triangles of each edge, and whether they run through it the same way, (edges, 3).

    Raises:
        MeshError: edges of one triangle or of more than two.
    """
    ends = faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    keys = ends.min(axis=1) * len(points) + ends.max(axis=1)
    edges, edge_of, uses = np.unique(keys, return_inverse=True, return_counts=True)
    for wrong, sentence in (
        (uses == 1, "the surface is not closed: it has {} open edges"),
        (uses > 2, "{} edges are shared by more than two triangles"),
    ):
        if wrong.any():
            edge = np.array(divmod(int(edges[np.flatnonzero(wrong)[0]]), len(points)))
            place = _place(points[edge].mean(axis=0))
            told = sentence.format(int(wrong.sum()))
            raise MeshError(f"{source}: {told}, one of them at {place}")
    sides = np.argsort(edge_of.ravel(), kind="stable").reshape(-1, 2)
    rising = ends[:, 0] < ends[:, 1]
    return np.stack([*(sides // 3).T, rising[sides[:, 0]] == rising[sides[:, 1]]], axis=1)


def _check_sides(points: FloatArray, faces: Numbers, pairs: Numbers, source: str) -> None:
    """Refuse triangles that see the outside where their neighbours see the inside.

    Each triangle stands twice, as it is and turned; neighbours that disagree link one with the
    other. A triangle that hangs together with its own turned self has no outside at all.
    """
    if not pairs[:, 2].any():
        return
    count = len(faces)
    first, second, same = pairs.T
    ends = np.concatenate(
        [
            np.stack([first, second + count * same], axis=1),
            np.stack([first + count, second + count * (1 - same)], axis=1),
        ]
    )
    _, label = connected_components(_graph(ends, 2 * count), directed=False)
    if (label[:count] == label[count:]).any():
        raise MeshError(f"{source}: the surface is one-sided, as a Moebius band: it has no outside")
    # Of the two sets of each part, the smaller one is taken for turned.
    sizes = np.bincount(label[:count], minlength=int(label.max()) + 1)
    turned = sizes[label[:count]] < sizes[label[count:]]
    tie = sizes[label[:count]] == sizes[label[count:]]
    turned |= tie & (label[:count] > label[count:])
    place = _place(points[faces[np.flatnonzero(turned)[0]]].mean(axis=0))
    raise MeshError(
        f"{source}: {int(turned.sum())} of {count} triangles are turned: neighbouring triangles "
        f"disagree about which side is outside, one of them at {place}"
    )


def _crossing(points: FloatArray, faces: Numbers) -> str:
    """A clause on triangles that cross each other; empty where none do, or there are too many."""
    if len(faces) > MOST_TESTED:
        return ""
    pairs, places = crossing_triangles(points, faces)
    if not len(pairs):
        return ""
    count = len(np.unique(pairs))
    return f"{count} of its triangles cross each other, two of them at {_place(places[0])}"


def _touching(points: FloatArray, faces: Numbers, pairs: Numbers) -> str:
    """A clause on points around which the triangles form more than one fan."""
    first, second = faces[pairs[:, 0]], faces[pairs[:, 1]]
    edge, one, other = np.nonzero(first[:, :, None] == second[:, None])
    corners = np.stack([3 * pairs[edge, 0] + one, 3 * pairs[edge, 1] + other], axis=1)
    _, fan = connected_components(_graph(corners, faces.size), directed=False)
    _, corner = np.unique(fan, return_index=True)
    several = np.flatnonzero(np.bincount(faces.ravel()[corner], minlength=len(points)) > 1)
    if not len(several):
        return ""
    place = _place(points[several[0]])
    return f"it touches itself at {len(several)} points, one of them at {place}"


def _graph(ends: Numbers, count: int) -> coo_array:
    return coo_array((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(count, count))


def _place(point: FloatArray) -> str:
    return f"({', '.join(f'{value:g}' for value in point)}) m"
