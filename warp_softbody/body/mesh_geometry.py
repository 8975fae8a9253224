"""Volumes, faces, edges and angles of tetrahedra are computed here as plain array functions."""

from __future__ import annotations

from itertools import combinations
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from warp_softbody.arrays import FloatArray

IntArray = npt.NDArray[np.int32]

# Faces of a tet of positive volume, each anticlockwise seen from outside.
FACES = np.array([[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]])


def tet_volumes(points: FloatArray, tets: IntArray) -> FloatArray:
    """Signed volumes (m,), m^3: (b - a) x (c - a) . (d - a) / 6."""
    a, b, c, d = (points[tets[:, corner]] for corner in range(4))
    volumes: FloatArray = np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6.0
    return volumes


def lumped_masses(
    tets: npt.NDArray[np.integer], volumes: FloatArray, nodes: int, density: float = 1.0
) -> FloatArray:
    """Masses (nodes,), kg: a quarter of each tet's, of volumes (m,), at each of its corners."""
    shares = np.repeat(density * volumes / 4.0, 4)
    return np.bincount(tets.ravel(), shares, nodes).astype(np.float64)


def inverse_edges(points: FloatArray, tets: IntArray) -> FloatArray:
    """Inverses (m, 3, 3), 1/m, of the matrices whose columns are the edges from corner 0."""
    corners = points[tets]
    return np.linalg.inv((corners[:, 1:] - corners[:, :1]).transpose(0, 2, 1))


def shortest_edge(points: FloatArray, tets: IntArray) -> float:
    """Length of the shortest edge, m."""
    corners = points[tets]
    squares = [
        ((corners[:, i] - corners[:, j]) ** 2).sum(axis=1).min()
        for i, j in combinations(range(4), 2)
    ]
    return float(np.sqrt(min(squares)))


def dihedral_angles(points: FloatArray, tets: IntArray) -> FloatArray:
    """Angles (m, 6) between the faces that meet at each edge, degrees."""
    corners = points[tets]
    angles = np.empty((len(tets), 6))
    for column, (i, j) in enumerate(combinations(range(4), 2)):
        k, other = (corner for corner in range(4) if corner not in (i, j))
        edge = corners[:, j] - corners[:, i]
        first = np.cross(edge, corners[:, k] - corners[:, i])
        second = np.cross(edge, corners[:, other] - corners[:, i])
        # atan2 stays accurate for angles near 0 and 180 degrees, where arccos does not.
        sine = np.linalg.norm(np.cross(first, second), axis=1)
        angles[:, column] = np.degrees(np.arctan2(sine, np.einsum("ij,ij->i", first, second)))
    return angles


class Faces(NamedTuple):
    """The 4 m faces of m tets, grouped with their equals.

    Attributes:
        nodes: (4 m, 3) int32 outward nodes; face f belongs to tet f // 4.
        order: (4 m,) face indices sorted so that equal faces stand side by side.
        group: (4 m,) group number of each sorted face.
        counts: (groups,) number of tets that use each face.
    """

    nodes: IntArray
    order: npt.NDArray[np.intp]
    group: npt.NDArray[np.intp]
    counts: npt.NDArray[np.intp]

    def used(self, times: int) -> npt.NDArray[np.intp]:
        """Face indices (groups, times), ascending, of the faces used that many times."""
        chosen = self.order[self.counts[self.group] == times].reshape(-1, times)
        chosen = np.sort(chosen, axis=1)
        return chosen[np.argsort(chosen[:, 0])]


def tet_faces(tets: IntArray) -> Faces:
    """Group the faces of tets (m, 4) by their three nodes."""
    nodes = tets[:, FACES].reshape(-1, 3)
    key = np.sort(nodes, axis=1)
    order = np.lexsort(key.T)
    key = key[order]
    starts = np.ones(len(key), dtype=bool)
    starts[1:] = (key[1:] != key[:-1]).any(axis=1)
    group = np.cumsum(starts) - 1
    return Faces(nodes, order, group, np.bincount(group))


def surface_triangles(tets: IntArray) -> IntArray:
    """Outward triangles (f, 3) int32 of the faces that only one tet uses."""
    faces = tet_faces(tets)
    return np.ascontiguousarray(faces.nodes[faces.used(1)[:, 0]], dtype=np.int32)


def face_parts(tets: IntArray) -> npt.NDArray[np.intp]:
    """Number (m,) from 0 of the piece that each tet is of; pieces hang together through faces."""
    pairs = tet_faces(tets).used(2) // 4
    count = len(tets)
    links = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    labels: npt.NDArray[np.intp] = connected_components(links, directed=False)[1].astype(np.intp)
    return labels


def count_parts(tets: IntArray) -> int:
    """Number of pieces that hang together through shared faces."""
    return int(face_parts(tets).max(initial=-1)) + 1


def same_side_pairs(tets: IntArray) -> npt.NDArray[np.intp]:
    """Pairs of tets (k, 2) of positive volume that lie on the same side of a shared face."""
    faces = tet_faces(tets)
    pairs = faces.used(2)
    first, second = faces.nodes[pairs[:, 0]], faces.nodes[pairs[:, 1]]
    # The same winding up to rotation means the same outward side.
    same = np.zeros(len(pairs), dtype=bool)
    for shift in range(3):
        same |= (first == np.roll(second, shift, axis=1)).all(axis=1)
    return pairs[same] // 4
