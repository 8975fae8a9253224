"""Isosurface stuffing: what lies inside a surface is filled with tets of one lattice.

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

Numbers = npt.NDArray[np.int64]
IntArray = npt.NDArray[np.int32]
Distance = Callable[[FloatArray], FloatArray]
"""Signed distance (k,) m of points (k, 3) m to the surface, positive inside."""

NEAR_ON_LONG, NEAR_ON_SHORT = 0.24999, 0.41189
"""Share of an edge within which a node is moved onto the surface: the paper's safe values."""

CORNERS = np.array(
    [[[0, 1, 0], [0, 1, 1]], [[0, 1, 1], [0, 0, 1]], [[0, 0, 1], [0, 0, 0]], [[0, 0, 0], [0, 1, 0]]]
)
"""Corners, by cell, of the four edges of the face between a cell and the one before it along x."""


class Lattice(NamedTuple):
    """Nodes (n, 3) m and tets (m, 4) of a body-centred cubic lattice.

    The ends of the two long edges of a tet are its first two and its last two nodes.
    """

    nodes: FloatArray
    tets: Numbers


class Filled(NamedTuple):
    """Points (n, 3) m and tets (m, 4) of positive volume that fill a surface."""

    points: FloatArray
    tets: IntArray


def stuff(distance: Distance, low: FloatArray, high: FloatArray, spacing: float) -> Filled:
    """Fill what has a positive distance within a box with tets.

    Args:
        distance: signed distance to the surface.
        low: lowest corner (3,) m of the surface's box.
        high: its highest corner.
        spacing: edge of the lattice's cubes, m; the body has some 12 tets in each of them.
    """
    lattice = body_centred_lattice(low, high, spacing)
    inside = distance(lattice.nodes)
    tets = lattice.tets[(inside[lattice.tets] > 0.0).any(axis=1)]
    used, tets = np.unique(tets, return_inverse=True)
    nodes, inside = lattice.nodes[used].copy(), inside[used]
    tets = tets.reshape(-1, 4)
    _move_onto_surface(nodes, inside, tets)
    cut = cut_tets(nodes, inside, tets)
    return Filled(cut.points, cut.tets.astype(np.int32))


def body_centred_lattice(low: FloatArray, high: FloatArray, spacing: float) -> Lattice:
    """Lattice around a box, with one cell to spare on each side, centred on it but in height.

    Its lowest layer within the box lies in the box's floor, so that flat soles come out flat.
    """
    cells = np.ceil((high - low) / spacing).astype(np.int64) + 2
    origin = 0.5 * (low + high) - 0.5 * spacing * cells
    origin[2] = low[2] - spacing
    corners = _grid(cells + 1)
    middles = _grid(cells)
    nodes = np.concatenate([corners, middles + 0.5]) * spacing + origin
    tets = []
    for axis in range(3):
        after = middles[middles[:, axis] > 0]
        before = after - np.eye(3, dtype=np.int64)[axis]
        ends = [_number(cell, cells) + len(corners) for cell in (before, after)]
        for pair in np.roll(CORNERS, axis, axis=2):
            edge = [_number(after + corner, cells + 1) for corner in pair]
            tets.append(np.stack([*ends, *edge], axis=1))
    return Lattice(nodes, np.concatenate(tets))


def _grid(counts: Numbers) -> Numbers:
    """Whole coordinates (k, 3) of a grid, the last one fastest."""
    x, y, z = (np.arange(count, dtype=np.int64) for count in counts)
    grid = np.meshgrid(x, y, z, indexing="ij")
    return np.stack([axis.ravel() for axis in grid], axis=1)


def _number(cells: Numbers, counts: Numbers) -> Numbers:
    """Index of each of the cells (k, 3) in `_grid`."""
    numbers: Numbers = (cells[:, 0] * counts[1] + cells[:, 1]) * counts[2] + cells[:, 2]
    return numbers


def _move_onto_surface(nodes: FloatArray, inside: FloatArray, tets: Numbers) -> None:
    """Move each node that lies near the surface along an edge onto it; its distance becomes 0."""
    for pairs, near in (
        (((0, 1), (2, 3)), NEAR_ON_LONG),
        (((0, 2), (0, 3), (1, 2), (1, 3)), NEAR_ON_SHORT),
    ):
        edges = np.concatenate([tets[:, pair] for pair in pairs])
        edges = np.unique(np.sort(edges, axis=1), axis=0)
        edges = edges[inside[edges[:, 0]] * inside[edges[:, 1]] < 0.0]
        ends = np.concatenate([edges, edges[:, ::-1]])
        share = inside[ends[:, 0]] / (inside[ends[:, 0]] - inside[ends[:, 1]])
        order = np.lexsort((ends[:, 1], share))
        ends, share = ends[order][share[order] < near], share[order][share[order] < near]
        moved, first = np.unique(ends[:, 0], return_index=True)
        way = nodes[ends[first, 1]] - nodes[moved]
        nodes[moved] += share[first, None] * way
        inside[moved] = 0.0
