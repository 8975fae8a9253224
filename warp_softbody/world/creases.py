"""Which edges of a grid of heights are sharp and convex, so that they could poke into a body."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray

SHARP = 0.95
"""Cosine between the normals of two faces below which the edge between them is sharp."""

ALONG_X, ALONG_Y, DIAGONAL = 1, 2, 4
"""Bits of the edges that begin at a vertex: to the next one along x, along y, and along both."""


def creases(heights: FloatArray, spacing: tuple[float, float]) -> npt.NDArray[np.int32]:
    """(rows, columns) bits of the sharp convex edges that begin at each vertex.

    Args:
        heights: (rows, columns) m; a cell has two triangles, on either side of its diagonal.
        spacing: m, of the grid along x and y.
    """
    rows, columns = heights.shape
    found = np.zeros((rows, columns), dtype=np.int32)
    dx, dy = spacing
    h = heights
    # slopes of the triangles below and above the diagonals
    below = np.stack([(h[1:, :-1] - h[:-1, :-1]) / dx, (h[1:, 1:] - h[1:, :-1]) / dy], axis=-1)
    above = np.stack([(h[1:, 1:] - h[:-1, 1:]) / dx, (h[:-1, 1:] - h[:-1, :-1]) / dy], axis=-1)
    # of an edge, its faces in the direction across it in which convex slopes fall off
    found[:-1, 1:-1] |= ALONG_X * _bends(above[:, :-1], below[:, 1:], (0.0, 1.0))
    found[1:-1, :-1] |= ALONG_Y * _bends(below[:-1], above[1:], (1.0, 0.0))
    found[:-1, :-1] |= DIAGONAL * _bends(above, below, (dy, -dx))
    return found


def _bends(
    first: FloatArray, second: FloatArray, across: tuple[float, float]
) -> npt.NDArray[np.int32]:
    """Whether slopes (..., 2) fall off sharply from a face to the next one in a direction."""
    sizes = np.sqrt((1.0 + (first**2).sum(axis=-1)) * (1.0 + (second**2).sum(axis=-1)))
    sharp = 1.0 + (first * second).sum(axis=-1) < SHARP * sizes
    falls = ((second - first) * np.array(across)).sum(axis=-1) < 0.0
    return np.asarray(sharp & falls, dtype=np.int32)
