"""In which tet of a mesh a point lies, and where in it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.body.mesh_geometry import IntArray, inverse_edges


class Location(NamedTuple):
    """Tets that hold points, or come nearest to it.

    Attributes:
        tets: (k,) indices.
        weights: (k, 4) barycentric weights of the tets' corners; all in 0..1 inside.
    """

    tets: npt.NDArray[np.intp]
    weights: FloatArray


def locate(
    points: FloatArray, tets: IntArray, places: FloatArray, *, nearest: int | None = None
) -> Location:
    """For each place the tet whose least barycentric weight there is greatest.

    Args:
        points: (n, 3) m, of the mesh.
        tets: (m, 4) of them.
        places: (k, 3) m.
        nearest: how many tets are tried, those whose centres are nearest; None for all.
    """
    inverse, first = inverse_edges(points, tets), points[tets[:, 0]]
    tried = _nearest(points, tets, places, len(tets) if nearest is None else nearest)
    chosen = np.zeros(len(places), dtype=np.intp)
    weights = np.zeros((len(places), 4))
    for index, (place, some) in enumerate(zip(places, tried, strict=True)):
        inner = np.einsum("tij,tj->ti", inverse[some], place - first[some])
        shares = np.concatenate([1.0 - inner.sum(axis=1, keepdims=True), inner], axis=1)
        best = int(np.argmax(shares.min(axis=1)))
        chosen[index] = best if isinstance(some, slice) else some[best]
        weights[index] = shares[best]
    return Location(chosen, weights)


def _nearest(
    points: FloatArray, tets: IntArray, places: FloatArray, count: int
) -> Sequence[slice | npt.NDArray[np.intp]]:
    """The tets to try for each place."""
    if count >= len(tets):
        return [slice(None)] * len(places)
    # few meshes need it, and it takes a while to load
    from scipy.spatial import cKDTree

    _, near = cKDTree(points[tets].mean(axis=1)).query(places, k=count)
    return list(np.asarray(near).reshape(len(places), count))
