"""A solid is filled with about as many tets as are asked for."""

from __future__ import annotations

import numpy as np

from warp_softbody.body.making.lattice import Distance, Filled, stuff
from warp_softbody.body.making.solid import Solid
from warp_softbody.body.mesh_geometry import face_parts, surface_triangles, tet_volumes
from warp_softbody.errors import MeshError

TETS_PER_CUBE = 12.0
"""Tets of the lattice in one of its cubes."""

CLOSE_ENOUGH = 0.1
"""Share by which the number of tets may differ from the one asked for before the search ends."""

MOST_TRIES = 8
"""Spacings tried."""

LEAST_VOLUME = 0.9
"""Share of the solid's volume below which the lattice has missed some of its limbs."""

MOST_GROWTH = 8.0
"""Times the tets asked for that a body with thin limbs may get."""

MOST_MOVED = 0.25
"""Share of the spacing by which the surface may be moved outwards, so that a lattice whose faces
cut corners keeps the volume."""

SAMPLES = 40
"""Samples along the longest side of the box by which a solid's volume is estimated."""


def fill(solid: Solid, tets: int) -> Filled:
    """Fill a solid with about ``tets`` tets; more where its limbs are too thin for so few.

    Raises:
        MeshError: nothing is inside, it is of several pieces, or its limbs are too thin by far.
    """
    volume = _volume(solid)
    spacing = (TETS_PER_CUBE * volume / tets) ** (1.0 / 3.0)
    least, fullest = np.inf, 0.0
    best: Filled | None = None
    for _ in range(MOST_TRIES):
        filled = _filled(solid, spacing, volume)
        count = len(filled.tets)
        kept = float(tet_volumes(filled.points, filled.tets).sum()) / volume
        fullest = max(fullest, kept)
        if kept < LEAST_VOLUME:
            least = min(least, spacing)
            spacing *= 0.85
            if TETS_PER_CUBE * volume / spacing**3 > MOST_GROWTH * tets:
                break
            continue
        if best is None or abs(count - tets) < abs(len(best.tets) - tets):
            best = filled
        if abs(count - tets) <= CLOSE_ENOUGH * tets or (spacing < least < np.inf):
            break
        spacing = min(spacing * (count / tets) ** (1.0 / 3.0), least)
    if best is None:
        share = f"only {fullest:.0%}" if fullest >= 0.005 else "less than 1%"
        raise MeshError(
            f"{solid.source}: {tets} tets hold {share} of the body in one piece: it "
            "has parts that do not touch, or limbs too thin for so few; ask for more tets"
        )
    return best


def _volume(solid: Solid) -> float:
    """Volume of what is inside, m^3, by samples."""
    low, high = solid.bounds
    step = float((high - low).max()) / SAMPLES
    axes = [np.arange(low[k] + 0.5 * step, high[k] + 0.5 * step, step) for k in range(3)]
    places = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    # A sample is as full as its cube is inside of the surface that passes through it.
    share = np.clip(solid.distance(places) / step + 0.5, 0.0, 1.0)
    if not share.any():
        raise MeshError(f"{solid.source}: the surface encloses no volume")
    return float(share.sum()) * step**3


def _filled(solid: Solid, spacing: float, volume: float) -> Filled:
    """The largest piece of the solid at a spacing, moved out so far that it keeps the volume."""
    out = 0.0
    low, high = solid.bounds
    for _ in range(3):
        lattice_low, lattice_high = low - out, high + out
        moved = out
        filled = stuff(_moved(solid, moved), lattice_low, lattice_high, spacing)
        if not len(filled.tets):
            return filled
        filled = _largest(filled)
        lacking = volume - float(tet_volumes(filled.points, filled.tets).sum())
        out = float(np.clip(out + lacking / _area(filled), 0.0, MOST_MOVED * spacing))
        if abs(lacking) < 0.005 * volume or out == moved:
            break
    return filled


def _moved(solid: Solid, out: float) -> Distance:
    """Distance to the surface moved outwards, m."""
    return lambda places: solid.distance(places) + out


def _largest(filled: Filled) -> Filled:
    """The largest piece that hangs together through faces."""
    part = face_parts(filled.tets)
    tets = filled.tets[part == np.bincount(part).argmax()]
    used, tets = np.unique(tets, return_inverse=True)
    return Filled(filled.points[used], tets.reshape(-1, 4).astype(np.int32))


def _area(filled: Filled) -> float:
    a, b, c = (filled.points[corner] for corner in surface_triangles(filled.tets).T)
    return float(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())
