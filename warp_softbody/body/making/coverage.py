"""Whether the tets that fill a solid reach all of its limbs."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.body.making.lattice import Filled
from warp_softbody.body.making.octree import Octree
from warp_softbody.body.making.solid import HALF, Solid, libigl
from warp_softbody.body.mesh_geometry import surface_triangles
from warp_softbody.errors import MeshError

SAMPLES = 50_000
"""Places in a solid's box, some tenths of which lie within it."""

ALONG = 40
"""Samples along the longest side of the box by which a solid's volume is estimated."""

PLASTIC = 1.2207440846057596
"""The real root of x^4 = x + 1: the multiples of its inverse powers are spread evenly in space."""

NEAR = 0.9
"""Share of a cube's edge by which places may lie outside of tets that reach them: the lattice cuts
edges and tips so short."""

FAR = 1.0
"""Edges of a cube by which a corner of the surface may lie outside of the tets without a word."""

FEW = 0.001
"""Share of the volume that tets may miss."""

FARTHEST = 0.08
"""Share of the box's diagonal beyond which no part of a body may lie from its tets; what is nearer
is carried along by its skin."""


class Unreached(NamedTuple):
    """What tets miss of a solid.

    Attributes:
        places: (k, 3) m, spread evenly over it.
        share: of the solid's volume.
        distance: of the place that is farthest from the tets, m.
        farthest: (3,) m, that place.
        little: whether it is so little that its skin can be carried along instead.
        tree: in whose cubes the tets are.
    """

    places: FloatArray
    share: float
    distance: float
    farthest: FloatArray
    little: bool
    tree: Octree


class Coverage:
    """Places within a solid, by which the tets that fill it are judged.

    Attributes:
        volume: of the solid, m^3.
    """

    def __init__(self, solid: Solid) -> None:
        """Spread the places over a solid.

        Raises:
            MeshError: nothing is inside.
        """
        low, high = solid.bounds
        steps = np.outer(np.arange(1, SAMPLES + 1), PLASTIC ** -np.arange(1.0, 4.0))
        places = low + (steps % 1.0) * (high - low)
        self._places = places[solid.winding(places) > HALF]
        self._corners = solid.points
        self._diagonal = float(np.linalg.norm(high - low))
        self.volume = _volume(solid)

    def unreached(self, filled: Filled, tree: Octree) -> Unreached:
        """What the tets in the cubes of an octree miss."""
        if not len(self._places):
            return Unreached(self._places, 0.0, 0.0, np.zeros(3), True, tree)
        found = _outside(self._places, filled)
        missed = found > NEAR * _edges(self._places, tree)
        distance = float(found[missed].max(initial=0.0))
        little = missed.mean() <= FEW and distance <= FARTHEST * self._diagonal
        farthest = self._places[int(found.argmax())]
        return Unreached(
            self._places[missed], float(missed.mean()), distance, farthest, bool(little), tree
        )

    def beyond(self, filled: Filled, tree: Octree) -> FloatArray | None:
        """The point (3,) m of the surface farthest beyond the tets, by more than a cube's edge.

        A fin or a hair may hold too little of the volume for any place to lie in it. None where all
        of the surface is near.
        """
        away = _outside(self._corners, filled) / _edges(self._corners, tree)
        place = int(away.argmax())
        return self._corners[place] if away[place] > FAR else None


def _outside(places: FloatArray, filled: Filled) -> FloatArray:
    """Distance (k,) m of places (k, 3) from tets, negative within them."""
    if not len(filled.tets):
        return np.full(len(places), np.inf)
    igl = libigl()
    kind = igl.SIGNED_DISTANCE_TYPE_FAST_WINDING_NUMBER
    triangles = surface_triangles(filled.tets)
    found: FloatArray = igl.signed_distance(places, filled.points, triangles, kind)[0]
    return found


def _edges(places: FloatArray, tree: Octree) -> FloatArray:
    """Edge (k,) m of the cube around each place (k, 3)."""
    return np.asarray(tree.spacing / 2.0 ** tree.levels(places), np.float64)


def _volume(solid: Solid) -> float:
    """Volume of what is inside, m^3, by cubes about samples."""
    low, high = solid.bounds
    step = float((high - low).max()) / ALONG
    axes = [np.arange(low[k] + 0.5 * step, high[k] + 0.5 * step, step) for k in range(3)]
    places = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    # A sample is as full as its cube is inside of the surface that passes through it.
    share = np.clip(solid.distance(places) / step + 0.5, 0.0, 1.0)
    if not share.any():
        raise MeshError(f"{solid.source}: the surface encloses no volume")
    return float(share.sum()) * step**3
