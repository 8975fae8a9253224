"""Grounds whose friction differs from place to place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.errors import InputError
from warp_softbody.inputs import array_checks, checks
from warp_softbody.inputs.records import FrozenValue


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class FrictionMap(FrozenValue):
    """Factors on a ground's coefficient of friction, one for each cell of a grid seen from above.

    A node that slides or sticks has the coefficient of the cell above or below which it is when a
    step begins. Beyond the grid the outermost cells go on, so that one of a single column has
    stripes across the whole ground.

    Attributes:
        factors: (rows, columns), >= 0; cell (i, j) goes from x = origin[0] + i * spacing[0] and
            y = origin[1] + j * spacing[1] to where the next one begins.
        spacing: m, of the cells along x and y.
        origin: m, x and y of the first cell's corner.
    """

    factors: FloatArray
    spacing: tuple[float, float] = (1.0, 1.0)
    origin: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        """Check shape and numbers; keep an own copy of the factors."""
        label = "FrictionMap.factors"
        factors = np.array(array_checks.array(label, self.factors, (None, None)))
        if not factors.size:
            raise InputError(
                f"{label} must hold a row and a column at least, not be of shape {factors.shape}"
            )
        if factors.min() < 0.0:
            raise InputError(f"{label} must not be negative, the least is {factors.min():g}")
        spacing = checks.vector("FrictionMap.spacing", self.spacing, 2, unit="m")
        if min(spacing) <= 0.0:
            raise InputError(f"FrictionMap.spacing must be positive, not {spacing}")
        factors.setflags(write=False)
        origin = checks.vector("FrictionMap.origin", self.origin, 2, unit="m")
        checks.keep(self, factors=factors, spacing=spacing, origin=origin)

    @classmethod
    def stripes(
        cls, factors: Sequence[float], width: float = 1.0, start: float = 0.0
    ) -> FrictionMap:
        """Stripes across x, each ``width`` m wide, the first from x = ``start`` m on."""
        label = "factors of FrictionMap.stripes"
        column = array_checks.array(label, factors, (None,))[:, None]
        wide = checks.number("width of FrictionMap.stripes", width, above=0.0, unit="m")
        begin = checks.number("start of FrictionMap.stripes", start, unit="m")
        return cls(factors=column, spacing=(wide, 1.0), origin=(begin, 0.0))

    def at(self, points: FloatArray) -> FloatArray:
        """Factors (k,) at the x and y of points (k, 2 or more) m.

        Raises:
            InputError: these are no points.
        """
        label = "points of FrictionMap.at"
        given = array_checks.array(label, points, (None, None), finite=False, unit="m")
        if given.shape[1] < 2:
            raise InputError(f"{label} must have x and y at least, not be of shape {given.shape}")
        last = np.array(self.factors.shape) - 1
        # cells so small that a point has no finite number are beyond the last one
        with np.errstate(over="ignore"):
            cell = np.floor((given[:, :2] - self.origin) / self.spacing)
        rows, columns = np.clip(np.nan_to_num(cell), 0, last).astype(int).T
        return np.asarray(self.factors[rows, columns])


def checked_map(label: str, given: object) -> FrictionMap | None:
    """A map, or None where friction is the same everywhere."""
    return None if given is None else checks.instance(label, given, FrictionMap)


def map_of(ground: object) -> FrictionMap | None:
    """The map of a ground; None for one of another package that has none."""
    found: FrictionMap | None = getattr(ground, "friction_map", None)
    return found
