"""Isosurface stuffing: what lies inside a surface is filled with tets of a lattice.

A body-centred cubic lattice is cut along the surface, after its nodes that lie near the surface
have been moved onto it, so that no tet becomes flat (Labelle and Shewchuk, "Isosurface Stuffing",
ACM TOG 26(3), 2007). The same distances give the same mesh, and the spacing sets how many tets.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.body.making.cut_tets import cut_tets
from warp_softbody.body.making.graded_lattice import graded_lattice
from warp_softbody.body.making.octree import Octree

Numbers = npt.NDArray[np.int64]
IntArray = npt.NDArray[np.int32]
Distance = Callable[[FloatArray], FloatArray]
"""Signed distance (k,) m of points (k, 3) m to the surface, positive inside."""

NEAR_ON_LONG, NEAR_ON_SHORT = 0.24999, 0.41189
"""Share of an edge within which a node is moved onto the surface: the paper's safe values."""

ROUNDING = 1e-6
"""Share by which the coordinates of a diagonal of a cube may differ."""


DIGITS = 6
"""Decimals of a ratio of lengths of edges, so that equal ones are so."""


class Filled(NamedTuple):
    """Points (n, 3) m and tets (m, 4) of positive volume that fill a surface."""

    points: FloatArray
    tets: IntArray


def stuff(distance: Distance, tree: Octree) -> Filled:
    """Fill what has a positive distance within an octree's grid with tets.

    Args:
        distance: signed distance to the surface.
        tree: cubes, in each of which the body has some 12 tets.
    """
    lattice = graded_lattice(tree)
    inside = distance(lattice.nodes)
    tets = lattice.tets[(inside[lattice.tets] > 0.0).any(axis=1)]
    used, tets = np.unique(tets, return_inverse=True)
    nodes, inside = lattice.nodes[used].copy(), inside[used]
    tets = tets.reshape(-1, 4)
    _move_onto_surface(nodes, inside, tets)
    cut = cut_tets(nodes, inside, tets)
    return Filled(cut.points, cut.tets.astype(np.int32))


def _move_onto_surface(nodes: FloatArray, inside: FloatArray, tets: Numbers) -> None:
    """Move each node that lies near the surface along an edge onto it; its distance becomes 0.

    Near is measured by the shortest of the node's edges of that kind: cubes of two sizes may meet.
    """
    every = np.concatenate([tets[:, [a, b]] for a in range(4) for b in range(a)])
    every = np.unique(np.sort(every, axis=1), axis=0)
    start = nodes.copy()
    along = abs(start[every[:, 1]] - start[every[:, 0]])
    # from a cube's centre to its corner; the others are axes of the grid and diagonals of faces
    short = along.min(axis=1) > (1.0 - ROUNDING) * along.max(axis=1)
    for edges, near in ((every[~short], NEAR_ON_LONG), (every[short], NEAR_ON_SHORT)):
        lengths = np.linalg.norm(start[edges[:, 1]] - start[edges[:, 0]], axis=1)
        shortest = np.full(len(nodes), np.inf)
        for column in (0, 1):
            np.minimum.at(shortest, edges[:, column], lengths)
        crossed = inside[edges[:, 0]] * inside[edges[:, 1]] < 0.0
        edges, lengths = edges[crossed], np.tile(lengths[crossed], 2)
        ends = np.concatenate([edges, edges[:, ::-1]])
        share = inside[ends[:, 0]] / (inside[ends[:, 0]] - inside[ends[:, 1]])
        far = share * np.round(lengths / shortest[ends[:, 0]], DIGITS)
        order = np.lexsort((ends[:, 1], far))
        close = far[order] < near
        ends, share = ends[order][close], share[order][close]
        moved, first = np.unique(ends[:, 0], return_index=True)
        way = nodes[ends[first, 1]] - nodes[moved]
        nodes[moved] += share[first, None] * way
        inside[moved] = 0.0
