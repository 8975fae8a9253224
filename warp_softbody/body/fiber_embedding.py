"""The vertices of fibres are located in the mesh; those just outside are moved onto its surface."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.body.mesh import TetMesh
from warp_softbody.body.point_location import locate
from warp_softbody.errors import InputError, MeshWarning

IntArray = npt.NDArray[np.int32]

JUST_OUTSIDE = 5e-3
"""Distance from the mesh, over the diagonal of its box, up to which a vertex is moved in: the
meshers may leave the given surface by a fifth to two fifths of it."""

SAMPLED = 0.02
"""Spacing, over the diagonal of the mesh's box, of the places at which segments are tested."""

SLACK = 1e-6
"""A barycentric weight of at least minus this counts as inside."""


class Embedding(NamedTuple):
    """Vertices of fibres in a mesh.

    Attributes:
        points: (p, 3) m, where they lie.
        nodes: (p, 4) int32 nodes of the tet of each.
        weights: (p, 4) barycentric weights.
    """

    points: FloatArray
    nodes: IntArray
    weights: FloatArray


def embed(mesh: TetMesh, points: FloatArray, names: Sequence[str]) -> Embedding:
    """Tets and weights of points (p, 3); ``names`` are those of the fibres of each.

    A `MeshWarning` tells how many points were moved and how far.

    Raises:
        InputError: a point lies further outside than `JUST_OUTSIDE`.
    """
    location = locate(mesh.points, mesh.tets, points)
    diagonal = float(np.linalg.norm(np.ptp(mesh.bounds, axis=0)))
    shape = (len(points), 4)
    result = Embedding(points.copy(), np.zeros(shape, np.int32), np.zeros(shape))
    moved: dict[int, float] = {}
    for index, point in enumerate(points):
        weights, nodes = location.weights[index], mesh.tets[location.tets[index]]
        if weights.min() < -SLACK:
            triangle, on_it = nearest_on_triangles(mesh.points[mesh.surface], point)
            nodes = np.append(mesh.surface[triangle], mesh.surface[triangle, 0]).astype(np.int32)
            weights = np.append(on_it, 0.0)
            result.points[index] = weights @ mesh.points[nodes]
            moved[index] = float(np.linalg.norm(result.points[index] - point))
            if moved[index] > JUST_OUTSIDE * diagonal:
                place = ", ".join(f"{value:g}" for value in point)
                raise InputError(
                    f"fibre {names[index]!r}: vertex ({place}) m lies outside the mesh, "
                    f"{moved[index]:.3g} m from it; at most {JUST_OUTSIDE * diagonal:.3g} m is "
                    f"taken for a vertex of the surface"
                )
        result.nodes[index], result.weights[index] = nodes, weights
    _tell(moved, names)
    return result


def tell_of_gaps(mesh: TetMesh, vertices: FloatArray, name: str) -> None:
    """Warn where a fibre with vertices (k, 3) m leaves the mesh between them.

    Segments are sampled at intervals of at most `SAMPLED`, so that longer gaps alone are found.
    """
    diagonal = float(np.linalg.norm(np.ptp(mesh.bounds, axis=0)))
    places = _between(vertices, SAMPLED * diagonal)
    if not len(places):
        return
    weights = locate(mesh.points, mesh.tets, places).weights
    outside = places[weights.min(axis=1) < -SLACK]
    skin = mesh.points[mesh.surface]
    away = np.zeros(len(outside))
    for index, place in enumerate(outside):
        triangle, on_it = nearest_on_triangles(skin, place)
        away[index] = np.linalg.norm(on_it @ skin[triangle] - place)
    if len(away) and away.max() > JUST_OUTSIDE * diagonal:
        place = ", ".join(f"{value:.3g}" for value in outside[away.argmax()])
        warnings.warn(
            f"fibre {name!r} leaves the mesh between its vertices, by {away.max():.2g} m at "
            f"({place}) m: lead it through the body, or give it more segments",
            MeshWarning,
            stacklevel=4,
        )


def _between(vertices: FloatArray, spacing: float) -> FloatArray:
    """Places (s, 3) m within the segments of a polyline, at most a spacing, m, apart."""
    found = [np.zeros((0, 3))]
    for first, last in pairwise(vertices):
        parts = int(np.ceil(np.linalg.norm(last - first) / spacing))
        share = np.arange(1, parts)[:, None] / max(parts, 1)
        found.append(first + share * (last - first))
    return np.concatenate(found)


def _tell(moved: dict[int, float], names: Sequence[str]) -> None:
    if moved:
        furthest = max(moved, key=lambda index: moved[index])
        those = "1 vertex" if len(moved) == 1 else f"{len(moved)} vertices"
        were = "was" if len(moved) == 1 else "were"
        warnings.warn(
            f"{those} of fibres lay outside the mesh and {were} moved onto its "
            f"surface, by at most {moved[furthest]:.3g} m (fibre {names[furthest]!r})",
            MeshWarning,
            stacklevel=2,
        )


def nearest_on_triangles(triangles: FloatArray, point: FloatArray) -> tuple[int, FloatArray]:
    """Nearest of triangles (f, 3, 3) to a point, and the weights (3,) of the place on it."""
    weights = np.stack([*_on_edges(triangles, point), _on_planes(triangles, point)])
    places = np.einsum("kfc,fcx->kfx", weights, triangles)
    distance = np.linalg.norm(places - point, axis=2)
    kind, triangle = np.unravel_index(int(np.argmin(distance)), distance.shape)
    return int(triangle), weights[kind, triangle]


def _on_edges(triangles: FloatArray, point: FloatArray) -> list[FloatArray]:
    """Weights (f, 3) of the nearest place on each of the three edges."""
    found = []
    for a, b in ((0, 1), (1, 2), (2, 0)):
        along = triangles[:, b] - triangles[:, a]
        square = np.einsum("fx,fx->f", along, along)
        t = np.clip(np.einsum("fx,fx->f", point - triangles[:, a], along) / square, 0.0, 1.0)
        weights = np.zeros((len(triangles), 3))
        weights[:, a], weights[:, b] = 1.0 - t, t
        found.append(weights)
    return found


def _on_planes(triangles: FloatArray, point: FloatArray) -> FloatArray:
    """Weights (f, 3) of the foot of the perpendicular, or of the first corner if it is outside."""
    a, u, v = triangles[:, 0], triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    normal = np.cross(u, v)
    square = np.einsum("fx,fx->f", normal, normal)
    r = np.einsum("fx,fx->f", np.cross(point - a, v), normal) / square
    s = np.einsum("fx,fx->f", np.cross(u, point - a), normal) / square
    weights = np.stack([1.0 - r - s, r, s], axis=1)
    inside = np.asarray((weights >= 0.0).all(axis=1))
    return np.where(inside[:, None], weights, np.array([1.0, 0.0, 0.0]))
