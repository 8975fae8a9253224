"""A solid is filled with about as many tets as are asked for."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.body.making.coverage import Coverage, Unreached
from warp_softbody.body.making.grading import reaching, total_volume
from warp_softbody.body.making.lattice import Filled, IntArray
from warp_softbody.body.making.octree import Octree
from warp_softbody.body.making.solid import Solid
from warp_softbody.errors import MeshError

TETS_PER_CUBE = 12.0
"""Tets of the lattice in one of its cubes."""

CLOSE_ENOUGH = 0.1
"""Share by which the number of tets may differ from the one asked for before the search ends."""

EVEN_TRIES = 8
"""Spacings tried with cubes of one size."""

LESS = 0.85
"""Share of a spacing that loses limbs which is tried after it."""

GRADED_STEPS = (1.0, None, None, 1.15, 1.32, 0.93, 0.87, 0.76)
"""Spacings tried with cubes of several sizes, as shares of the first; None: as the number of tets
suggests. Which limbs a lattice meets is a matter of chance, so that more spacing may take more
tets."""

MOST_EVEN = 2.5
"""Times the tets asked for up to which cubes of one size are preferred: a chair walks with 3,100 of
them and not with 1,300 in small cubes about its legs, which are a single one across."""

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
        tree: in whose cubes they are.
    """

    points: FloatArray
    tets: IntArray
    missed: FloatArray | None
    tree: Octree


def fill(solid: Solid, tets: int) -> Filling:
    """Fill a solid with about ``tets`` tets; more where its limbs are too thin for so few.

    Raises:
        MeshError: nothing is inside, it is of several pieces, or its limbs are too thin by far.
    """
    search = _Search(Coverage(solid), tets)
    _try_even(solid, search)
    if search.error > MOST_EVEN - 1.0:
        _try_graded(solid, search)
    if search.best is None:
        raise MeshError(f"{solid.source}: {search.too_few}")
    best = search.best
    if best.missed is None:
        beyond = search.coverage.beyond(Filled(best.points, best.tets), best.tree)
        best = best._replace(missed=beyond)
    return best


def _try_even(solid: Solid, search: _Search) -> None:
    """Fill with cubes of one size, smaller ones where limbs were missed."""
    spacing, fails = search.first, np.inf
    for _ in range(EVEN_TRIES):
        filled, unreached = reaching(solid, spacing, search.coverage, search.most, rounds=0)
        if search.judge(filled, unreached):
            if search.error <= CLOSE_ENOUGH or spacing < fails < np.inf:
                return
            spacing = min(spacing * search.excess(filled) ** (1.0 / 3.0), fails)
            continue
        fails = min(fails, spacing)
        spacing *= LESS
        if spacing**3 < search.first**3 / MOST_EVEN:
            return


def _try_graded(solid: Solid, search: _Search) -> None:
    """Fill with small cubes where limbs are thin."""
    spacing = search.first
    for factor in GRADED_STEPS:
        spacing = spacing if factor is None else factor * search.first
        most = search.most
        filled, unreached = reaching(solid, spacing, search.coverage, most)
        holds = search.judge(filled, unreached)
        if search.error <= CLOSE_ENOUGH:
            return
        if not holds and search.best is None and len(filled.tets) <= most:
            # cubes an eighth as large miss limbs as well
            return
        if len(filled.tets):
            spacing *= search.excess(filled) ** (1.0 / 3.0)


class _Search:
    """What was found so far.

    Attributes:
        coverage: of the solid.
        first: spacing, m, that would give as many tets as are asked for, were there no surface.
        best: the filling that is closest to what is asked for, of those that miss no limb.
    """

    def __init__(self, coverage: Coverage, tets: int) -> None:
        """Begin a search for so many tets."""
        self.coverage = coverage
        self.first: float = (TETS_PER_CUBE * coverage.volume / tets) ** (1.0 / 3.0)
        self.best: Filling | None = None
        self._tets = tets
        self._fullest = 0.0
        self._enough: int | None = None

    @property
    def most(self) -> int:
        """Tets from which on a filling is of no use."""
        if self.best is None:
            return MOST_GROWTH * self._tets
        return max(len(self.best.tets), 2 * self._tets)

    @property
    def error(self) -> float:
        """Share by which the best filling is off the number asked for."""
        return np.inf if self.best is None else abs(len(self.best.tets) / self._tets - 1.0)

    def excess(self, filled: Filled) -> float:
        """Tets of a filling over those asked for."""
        return len(filled.tets) / self._tets

    def judge(self, filled: Filled, unreached: Unreached) -> bool:
        """Keep a filling if it is closer than the best so far; return whether it has all limbs."""
        kept, count = total_volume(filled) / self.coverage.volume, len(filled.tets)
        self._fullest = max(self._fullest, min(kept, 1.0 - unreached.share))
        whole = kept >= LEAST_VOLUME and unreached.little
        if whole and count > self.most:
            self._enough = min(self._enough or count, count)
        elif whole and abs(self.excess(filled) - 1.0) < self.error:
            missed = unreached.farthest if unreached.distance > 0.0 else None
            self.best = Filling(filled.points, filled.tets, missed, unreached.tree)
        return whole

    @property
    def too_few(self) -> str:
        """Why so many tets do not do."""
        if self._enough is not None:
            return (
                f"its limbs are too thin for {self._tets} tets; ask for {self._enough}, which "
                "hold them"
            )
        share = f"only {min(self._fullest, 0.99):.0%}"
        if self._fullest < 0.005:
            share = "less than 1%"
        return (
            f"{self._tets} tets hold {share} of the body in one piece: it has parts that do not "
            "touch, or limbs too thin for so few; ask for more tets"
        )
