"""A solid is filled with about as many tets as are asked for."""

from __future__ import annotations

from typing import NamedTuple

from warp_softbody.arrays import FloatArray
from warp_softbody.body.making.coverage import Coverage
from warp_softbody.body.making.grading import reaching, total_volume
from warp_softbody.body.making.lattice import IntArray
from warp_softbody.body.making.solid import Solid
from warp_softbody.errors import MeshError

TETS_PER_CUBE = 12.0
"""Tets of the lattice in one of its cubes."""

CLOSE_ENOUGH, CLOSE = 0.1, 0.2
"""Shares by which the number of tets may differ from the one asked for: where the search ends, and
where it ends once it has followed the number."""

STEPS = (None, 1.15, 1.32, 0.87, 0.76)
"""Spacings tried after the first, as shares of it; None: as the number of tets suggests. Which
limbs a lattice meets is a matter of chance, so that more spacing may take more tets."""

LEAST_VOLUME = 0.9
"""Share of the solid's volume below which the lattice has missed some of its limbs."""

MOST_GROWTH = 10
"""Times the tets asked for that a body with thin limbs may get."""


class Filling(NamedTuple):
    """Tets that fill a solid.

    Attributes:
        points: (n, 3) m.
        tets: (m, 4).
        missed: place (3,) m of a part too thin for them, which its skin carries along; None where
            there is none.
    """

    points: FloatArray
    tets: IntArray
    missed: FloatArray | None


def fill(solid: Solid, tets: int) -> Filling:
    """Fill a solid with about ``tets`` tets; more where its limbs are too thin for so few.

    Raises:
        MeshError: nothing is inside, it is of several pieces, or its limbs are too thin by far.
    """
    coverage = Coverage(solid)
    first = spacing = (TETS_PER_CUBE * coverage.volume / tets) ** (1.0 / 3.0)
    most, fullest, enough = MOST_GROWTH * tets, 0.0, None
    best: Filling | None = None
    for factor in (*STEPS, 1.0):
        filled, unreached = reaching(solid, spacing, coverage, most)
        kept = total_volume(filled) / coverage.volume
        fullest = max(fullest, min(kept, 1.0 - unreached.share))
        excess = len(filled.tets) / tets
        if kept >= LEAST_VOLUME and unreached.little:
            if len(filled.tets) > most:
                enough = min(enough or len(filled.tets), len(filled.tets))
            elif best is None or abs(excess - 1.0) < abs(len(best.tets) / tets - 1.0):
                missed = unreached.farthest if unreached.distance > 0.0 else None
                best = Filling(filled.points, filled.tets, missed)
                most = max(len(best.tets), 2 * tets)
        elif len(filled.tets) <= most and best is None:
            # cubes an eighth as large miss limbs as well
            break
        if best is not None:
            error = abs(len(best.tets) / tets - 1.0)
            if error <= (CLOSE_ENOUGH if factor is None else CLOSE):
                break
        if factor is not None:
            spacing = factor * first
        elif excess > 0.0:
            spacing *= excess ** (1.0 / 3.0)
    if best is None:
        raise MeshError(f"{solid.source}: {_too_few(tets, fullest, enough)}")
    return best


def _too_few(tets: int, fullest: float, enough: int | None) -> str:
    """Why so many tets do not do, which hold at best a share of the body."""
    if enough is not None:
        return f"its limbs are too thin for {tets} tets; ask for {enough}, which hold them"
    share = f"only {min(fullest, 0.99):.0%}" if fullest >= 0.005 else "less than 1%"
    return (
        f"{tets} tets hold {share} of the body in one piece: it has parts that do not touch, or "
        "limbs too thin for so few; ask for more tets"
    )
