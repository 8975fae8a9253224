"""Places as whole numbers of two bytes on a grid that moves with what it covers."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray

Grid = npt.NDArray[np.uint16]
CELLS = 65535
ROOM = 1.5
"""By how much a body may grow beyond its start pose before the grid becomes coarser."""


class MovingGrid:
    """A grid whose cells keep their size while what it covers fits into it.

    Attributes:
        scale: m, of a cell; places are off by at most half of it.
    """

    def __init__(self, points: FloatArray) -> None:
        """A grid for points (k, 3) m and what becomes of them."""
        self.scale = max(_width(points), 1e-6) * ROOM / CELLS

    def place(self, points: FloatArray) -> tuple[FloatArray, Grid]:
        """Lowest corner (3,) m of the grid, and the numbers (k, 3) of points (k, 3) m on it."""
        while _width(points) > self.scale * (CELLS - 1):
            self.scale *= 2.0
        low = points.min(axis=0) if len(points) else np.zeros(3)
        # on multiples of a cell, so that what stands still keeps its numbers
        origin = np.floor(low / self.scale) * self.scale
        cells = np.rint((points - origin) / self.scale)
        return origin, np.clip(cells, 0, CELLS).astype(np.uint16)


def _width(points: FloatArray) -> float:
    """Of the largest side of the box around points, m."""
    return float(np.ptp(points, axis=0).max()) if len(points) else 0.0
