"""Cubes of a grid, some of them split into eight, and those again: small where limbs are thin.

Cubes that touch differ by one level at most, as the lattice of Labelle and Shewchuk ("Isosurface
Stuffing", ACM TOG 26(3), 2007) needs it, here across edges and corners too.
"""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import BoolArray, FloatArray

Numbers = npt.NDArray[np.int64]

LEVELS = 3
"""Times that a cube may be split."""

UNIT = 2 << LEVELS
"""Edge of a cube that is not split, in units in which all corners and centres are whole."""

AROUND = np.array(list(itertools.product((-1, 0, 1), repeat=3)))
"""The cubes around one, and itself, as steps (27, 3)."""

CHILDREN = np.array(list(itertools.product((0, 1), repeat=3)))


class Leaves(NamedTuple):
    """Cubes that are not split.

    Attributes:
        cubes: (k, 3), by level, counted in cubes of that level.
        counts: (3,) cubes of the grid, at level 0.
    """

    cubes: tuple[Numbers, ...]
    counts: Numbers

    def among(self, level: int, cubes: Numbers) -> BoolArray:
        """Which of the cubes (k, 3) of a level are leaves."""
        return contains(self.cubes[level], cubes)


class Octree:
    """A grid of cubes of which some are split.

    Attributes:
        origin: (3,) m, the grid's lowest corner.
        spacing: edge of its cubes, m.
        counts: (3,) cubes along each axis.
    """

    def __init__(self, origin: FloatArray, spacing: float, counts: Numbers) -> None:
        """A grid of which no cube is split."""
        self.origin = origin
        self.spacing = spacing
        self.counts = counts
        self._split: list[Numbers] = [np.zeros((0, 3), dtype=np.int64) for _ in range(LEVELS)]

    @classmethod
    def around(cls, low: FloatArray, high: FloatArray, spacing: float) -> Octree:
        """A grid around a box, with one cube to spare on each side, centred on it but in height.

        A layer of cubes begins at the box's floor, so that flat soles come out flat.
        """
        counts = np.ceil((high - low) / spacing).astype(np.int64) + 2
        origin = 0.5 * (low + high) - 0.5 * spacing * counts
        origin[2] = low[2] - spacing
        return cls(origin, spacing, counts)

    def moved_to(self, low: FloatArray, high: FloatArray) -> Octree:
        """The same cubes split of a grid around another box of about the same size."""
        other = Octree.around(low, high, self.spacing)
        other.refine(
            *(
                self.origin + (cubes + 0.5) * self.spacing / 2**level
                for level, cubes in enumerate(self._split)
            )
        )
        return other

    @property
    def least_edge(self) -> float:
        """Edge of the smallest cubes, m."""
        return self.spacing / 2.0 ** sum(len(split) > 0 for split in self._split)

    def levels(self, places: FloatArray) -> Numbers:
        """Level of the leaf that each place (k, 3) m lies in."""
        found = np.zeros(len(places), dtype=np.int64)
        for level, split in enumerate(self._split):
            found[contains(split, self._cubes(places, level))] = level + 1
        return found

    def refine(self, *places: FloatArray) -> None:
        """Split the cubes of level 0, 1, ... that hold places (k, 3) m, and what touches them."""
        for level, holding in enumerate(places):
            cubes = self._inside(self._cubes(holding, level), level)
            self._split[level] = unique(np.concatenate([self._split[level], cubes]))
        for level in range(LEVELS - 1, 0, -1):
            touched = (self._split[level][:, None] + AROUND).reshape(-1, 3)
            parents = self._inside(touched, level) >> 1
            self._split[level - 1] = unique(np.concatenate([self._split[level - 1], parents]))

    def split(self, level: int, cubes: Numbers) -> BoolArray:
        """Which of the cubes (k, 3) of a level are split."""
        return (
            np.zeros(len(cubes), bool) if level == LEVELS else contains(self._split[level], cubes)
        )

    def leaves(self) -> Leaves:
        """The cubes that are not split."""
        x, y, z = (np.arange(count, dtype=np.int64) for count in self.counts)
        grid = np.stack(np.meshgrid(x, y, z, indexing="ij"), axis=-1).reshape(-1, 3)
        cubes = [grid[~self.split(0, grid)]]
        for level in range(1, LEVELS + 1):
            children = (2 * self._split[level - 1][:, None] + CHILDREN).reshape(-1, 3)
            cubes.append(children[~self.split(level, children)])
        return Leaves(tuple(cubes), self.counts)

    def _cubes(self, places: FloatArray, level: int) -> Numbers:
        steps = (places - self.origin) / (self.spacing / 2**level)
        cubes: Numbers = np.floor(steps).astype(np.int64)
        return cubes

    def _inside(self, cubes: Numbers, level: int) -> Numbers:
        kept: Numbers = cubes[((cubes >= 0) & (cubes < self.counts << level)).all(axis=1)]
        return kept


def codes(cubes: Numbers) -> Numbers:
    """A number for each triple (k, 3) of whole numbers between -2^20 and 2^20."""
    x, y, z = (cubes + (1 << 20)).T
    coded: Numbers = (x << 42) + (y << 21) + z
    return coded


def contains(cubes: Numbers, asked: Numbers) -> BoolArray:
    """Which of those asked for (k, 3) are among the cubes (m, 3)."""
    return np.isin(codes(asked), codes(cubes))


def unique(cubes: Numbers) -> Numbers:
    """Each of the cubes (k, 3) once, in order."""
    _, first = np.unique(codes(cubes), return_index=True)
    kept: Numbers = cubes[first]
    return kept
