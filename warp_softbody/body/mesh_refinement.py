"""Red refinement of a tet mesh: every tet into eight, the body the same to rounding."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.body.mesh import TetMesh

IntArray = npt.NDArray[np.int32]

EDGES = np.array(list(combinations(range(4), 2)))
"""Corners of a tet's edges: 01, 02, 03, 12, 13, 23."""

_CORNERS = ((0, 4, 5, 6), (4, 1, 7, 8), (5, 7, 2, 9), (6, 8, 9, 3))
# Of a tet's ten nodes, the middles 4 to 9 in the order of EDGES. The three inner diagonals, each
# with the four middles around it in turn.
_DIAGONALS = np.array([(4, 9), (5, 8), (6, 7)])
_AROUND = np.array([(5, 6, 8, 7), (4, 6, 9, 7), (4, 5, 9, 8)])


def refine(mesh: TetMesh) -> tuple[TetMesh, IntArray]:
    """Red refinement: four tets at the corners, and the octahedron between them as four.

    The octahedron is cut along its shortest diagonal, which keeps the shapes of repeated refinement
    from growing flat.

    Returns:
        The mesh, whose first points are the old ones, and the edges (e, 2) whose middles follow.
    """
    points, tets = mesh.points, mesh.tets
    pairs = np.sort(tets[:, EDGES].reshape(-1, 2), axis=1)
    edges, index = np.unique(pairs, axis=0, return_inverse=True)
    every = np.concatenate([points, points[edges].mean(axis=1)])
    nodes = np.concatenate([tets, len(points) + index.reshape(-1, 6)], axis=1)
    corners = [nodes[:, corner] for corner in _CORNERS]
    small = np.concatenate([*corners, *_octahedra(every, nodes)])
    # positive, like the tets that they are cut from
    sides = every[small[:, 1:]] - every[small[:, :1]]
    turned = np.linalg.det(sides) < 0.0
    small[turned, :2] = small[turned, 1::-1]
    return TetMesh(every, small.astype(np.int32)), edges.astype(np.int32)


def _octahedra(points: FloatArray, nodes: npt.NDArray[np.int_]) -> list[npt.NDArray[np.int_]]:
    """Four tets of each octahedron, around its shortest diagonal."""
    ends = points[nodes[:, _DIAGONALS]]
    lengths = np.linalg.norm(ends[:, :, 0] - ends[:, :, 1], axis=2)
    # equal ones, but for rounding, are cut alike everywhere
    close = lengths <= lengths.min(axis=1, keepdims=True) * (1.0 + 1e-9)
    choice = close.argmax(axis=1)[:, None]
    low, high = np.take_along_axis(nodes, _DIAGONALS[choice[:, 0]], axis=1).T
    ring = np.take_along_axis(nodes, _AROUND[choice[:, 0]], axis=1)
    return [np.stack([low, high, ring[:, k], ring[:, (k + 1) % 4]], axis=1) for k in range(4)]
