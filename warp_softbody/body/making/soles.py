"""Soles that are nearly flat are made flat, so that a body does not stand on their bumps."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from warp_softbody.arrays import BoolArray, FloatArray, cross_rows
from warp_softbody.body.mesh_geometry import IntArray, surface_triangles, tet_volumes

BUMPS = 0.025
"""Height, over the body's, up to which a node of the skin is brought down to the floor."""

SHORTER = 0.03
"""The same of a foot that has no node as low as that: a leg that the mesh has a little shorter than
the others would hang."""

LEAST_KEPT = 0.3
"""Share of its volume that each tet keeps; nodes that would take more stay where they are."""

LEAST_AREA = 0.75
"""Area of a sole, over the square of the mesh's edges about it, below which it is broadened."""

RING = 1.4
"""Height, in edges about a sole, up to which the nodes next to it are brought down then."""


class Standing(NamedTuple):
    """A body whose soles are flat.

    Attributes:
        points: (n, 3) m.
        tets: (t, 4).
        nodes: (n,) numbers that its nodes had before.
    """

    points: FloatArray
    tets: IntArray
    nodes: npt.NDArray[np.int64]


def flat_soles(points: FloatArray, tets: IntArray) -> FloatArray:
    """Points (n, 3) m of a body that stands on z = 0, its lowest skin brought down to there."""
    nodes = np.unique(surface_triangles(tets))
    low = np.zeros(len(points), dtype=bool)
    low[nodes] = points[nodes, 2] < BUMPS * float(points[:, 2].max())
    return _brought_down(points, tets, low)


def broad_soles(points: FloatArray, tets: IntArray) -> Standing:
    """A body of points (n, 3) m and tets on z = 0, whose feet are more than points.

    A round or pointed foot that the mesh has but a node or two of would bear no moment and tip
    about that node: its neighbours are brought down too, as on a finer mesh they would be. Tets
    that this would flatten, of such a tip alone, are taken off.
    """
    skin = surface_triangles(tets)
    low = np.zeros(len(points), dtype=bool)
    nodes, height = np.unique(skin), float(points[:, 2].max())
    low[nodes] = points[nodes, 2] < SHORTER * height
    piece = _pieces(skin, low)
    found = np.unique(piece[low & (points[:, 2] < BUMPS * height)])
    low &= (points[:, 2] == 0.0) | ~np.isin(piece, found)
    points = _brought_down(points, tets, low)
    low &= points[:, 2] == 0.0
    around, amid = _around_small(points, skin, low)
    if (tet_volumes(amid, tets) > LEAST_KEPT * tet_volumes(points, tets)).all():
        points = amid
    if not around.any():
        return Standing(points, tets, np.arange(len(points)))
    tips = (low | around)[tets].all(axis=1) & around[tets].any(axis=1)
    kept = tets[~tips]
    nodes, numbers = np.unique(kept, return_inverse=True)
    kept = numbers.reshape(kept.shape).astype(tets.dtype)
    return Standing(_brought_down(points[nodes], kept, around[nodes]), kept, nodes.astype(np.int64))


def _brought_down(points: FloatArray, tets: IntArray, low: BoolArray) -> FloatArray:
    """Points (n, 3) m, those of a mask on z = 0 but where tets would lose their volume."""
    before = tet_volumes(points, tets)
    while low.any():
        flat: FloatArray = points.copy()
        flat[low, 2] = 0.0
        squeezed = tet_volumes(flat, tets) < LEAST_KEPT * before
        if not squeezed.any():
            return flat
        low = low.copy()
        low[tets[squeezed]] = False
    return points


def _pieces(skin: IntArray, low: BoolArray) -> IntArray:
    """Numbers (n,) of the pieces in which nodes of a mask hang together by the skin."""
    edges = skin[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    edges = edges[low[edges].all(axis=1)]
    graph = coo_array((np.ones(len(edges)), edges.T), shape=(len(low), len(low)))
    numbers: IntArray = connected_components(graph, directed=False)[1]
    return numbers


def _around_small(
    points: FloatArray, skin: IntArray, low: BoolArray
) -> tuple[BoolArray, FloatArray]:
    """Mask (n,) of the nodes of the skin next to soles that are small beside its edges.

    And the points with such soles amid these nodes, as a tip may be at the edge of its limb.
    """
    edges = skin[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    lengths = np.linalg.norm(points[edges[:, 1]] - points[edges[:, 0]], axis=1)
    count, piece = len(points), _pieces(skin, low)
    a, b, c = points[skin.T]
    areas = np.linalg.norm(cross_rows(b - a, c - a), axis=1) / 2.0
    around, amid = np.zeros(count, dtype=bool), points.copy()
    for number in np.unique(piece[low]):
        own = low & (piece == number)
        edge = float(lengths[own[edges].any(axis=1)].mean())
        if areas[own[skin].all(axis=1)].sum() < LEAST_AREA * edge**2:
            ring = np.setdiff1d(skin[own[skin].any(axis=1)], np.flatnonzero(low))
            around[ring[points[ring, 2] < RING * edge]] = True
            amid[own, :2] += points[ring, :2].mean(axis=0) - points[own, :2].mean(axis=0)
    return around, amid
