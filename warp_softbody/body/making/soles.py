"""Soles that are nearly flat are made flat, so that a body does not stand on their bumps."""

from __future__ import annotations

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.body.mesh_geometry import IntArray, surface_triangles, tet_volumes

BUMPS = 0.025
"""Height, over the body's, up to which a node of the skin is brought down to the floor."""

LEAST_KEPT = 0.3
"""Share of its volume that each tet keeps; nodes that would take more stay where they are."""


def flat_soles(points: FloatArray, tets: IntArray) -> FloatArray:
    """Points (n, 3) m of a body that stands on z = 0, its lowest skin brought down to there."""
    skin = np.unique(surface_triangles(tets))
    low = np.zeros(len(points), dtype=bool)
    low[skin] = points[skin, 2] < BUMPS * float(points[:, 2].max())
    before = tet_volumes(points, tets)
    while low.any():
        flat: FloatArray = points.copy()
        flat[low, 2] = 0.0
        squeezed = tet_volumes(flat, tets) < LEAST_KEPT * before
        if not squeezed.any():
            return flat
        low[tets[squeezed]] = False
    return points
