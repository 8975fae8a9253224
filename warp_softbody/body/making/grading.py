"""A solid in cubes of a spacing, smaller ones where its limbs are thin."""

from __future__ import annotations

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.body.making.coverage import Coverage, Unreached
from warp_softbody.body.making.lattice import Distance, Filled, stuff
from warp_softbody.body.making.octree import AROUND, LEVELS, Octree
from warp_softbody.body.making.solid import Solid
from warp_softbody.body.mesh_geometry import face_parts, surface_triangles, tet_volumes

MOST_ROUNDS = 7
"""Times that cubes are split where tets miss a limb."""

BESIDE = 0.1
"""Share of a cube's edge within which a cube beside a missed place is split too."""

MOST_MOVED = 0.25
"""Share of the smallest cubes' edge by which the surface may be moved outwards, so that a lattice
whose faces cut corners keeps the volume."""

CLOSE_VOLUME = 0.005
"""Share of the volume that may be lacking without the surface being moved once more."""


def reaching(
    solid: Solid, spacing: float, coverage: Coverage, most: int, rounds: int = MOST_ROUNDS
) -> tuple[Filled, Unreached]:
    """Fill a solid at a spacing, with smaller tets where they would miss its limbs.

    Args:
        solid: what is filled, in one piece.
        spacing: edge of the largest cubes, m.
        coverage: of the solid.
        most: tets from which on no cubes are split any more.
        rounds: times that cubes are split where tets miss a limb; 0: all are of one size.

    Returns:
        The tets, and what they miss: what is too thin for the smallest cubes too.
    """
    low, high = solid.bounds
    tree = Octree.around(low, high, spacing)
    for again in range(rounds, -1, -1):
        filled = _filled(solid, tree, coverage.volume)
        unreached = coverage.unreached(filled, tree)
        levels = tree.levels(unreached.places)
        split = again and len(filled.tets) <= most and (levels < LEVELS).any()
        if unreached.little or not split:
            break
        missed = (unreached.places[levels == level] for level in range(LEVELS))
        tree.refine(*(_around(places, spacing / 2**k) for k, places in enumerate(missed)))
    return filled, unreached


def total_volume(filled: Filled) -> float:
    """Volume, m^3."""
    return float(tet_volumes(filled.points, filled.tets).sum())


def _around(places: FloatArray, size: float) -> FloatArray:
    """Places (k, 3), and some beside them to all sides, so that cubes they nearly touch are met."""
    return (places[:, None] + BESIDE * size * AROUND).reshape(-1, 3)


def _filled(solid: Solid, tree: Octree, volume: float) -> Filled:
    """The largest piece of the solid in cubes, moved out so far that it keeps the volume."""
    out, most = 0.0, MOST_MOVED * tree.least_edge
    low, high = solid.bounds
    for _ in range(3):
        moved = out
        filled = _largest(stuff(_moved(solid, moved), tree.moved_to(low - out, high + out)))
        if not len(filled.tets):
            break
        lacking = volume - total_volume(filled)
        out = float(np.clip(out + lacking / _area(filled), 0.0, most))
        if abs(lacking) < CLOSE_VOLUME * volume or out == moved:
            break
    return filled


def _moved(solid: Solid, out: float) -> Distance:
    """Distance to the surface moved outwards, m."""
    return lambda places: solid.distance(places) + out


def _largest(filled: Filled) -> Filled:
    """The largest piece that hangs together through faces."""
    if not len(filled.tets):
        return filled
    part = face_parts(filled.tets)
    tets = filled.tets[part == np.bincount(part).argmax()]
    used, tets = np.unique(tets, return_inverse=True)
    return Filled(filled.points[used], tets.reshape(-1, 4).astype(np.int32))


def _area(filled: Filled) -> float:
    a, b, c = (filled.points[corner] for corner in surface_triangles(filled.tets).T)
    return float(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())
