"""Triangles of a surface that intersect each other are found and counted."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray

Numbers = npt.NDArray[np.int64]

MOST_PAIRS = 10_000_000
"""Pairs of triangles near each other up to which crossings are looked for, a gigabyte."""

INSIDE = 1e-9
"""How far within both triangles a crossing must lie, relative to them: touching is none."""

EDGES = ((0, 1), (1, 2), (2, 0))


def crossing_triangles(
    points: FloatArray, faces: Numbers, *, most_pairs: int = MOST_PAIRS
) -> tuple[Numbers, FloatArray]:
    """Pairs (k, 2) of triangles that cross, and a place (k, 3) in m on both of each pair.

    Neighbours across an edge and triangles that overlap in one plane are not found, and none where
    more than ``most_pairs`` are near each other, as in a fan of thousands of triangles.
    """
    corners = points[faces]
    pairs = _astride(corners, _near_pairs(corners, most_pairs))
    shared = (faces[pairs[:, 0]][:, :, None] == faces[pairs[:, 1]][:, None]).sum(axis=(1, 2))
    pairs = pairs[shared < 2]
    pairs = pairs[np.lexsort(np.sort(pairs, axis=1).T)]
    found: list[Numbers] = []
    places: list[FloatArray] = []
    for one, other in (pairs.T, pairs.T[::-1]):
        for start, end in EDGES:
            hit, place = _pierced(corners[one, start], corners[one, end], corners[other])
            found.append(pairs[hit])
            places.append(place[hit])
    return np.concatenate(found), np.concatenate(places)


def _astride(corners: FloatArray, pairs: Numbers) -> Numbers:
    """The pairs of which each triangle has corners on both sides of the other one's plane."""
    a, u, v = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normal = np.cross(u, v)
    for one, other in ((0, 1), (1, 0)):
        plane, third = pairs[:, one], pairs[:, other]
        offset = np.einsum("ij,ij->i", normal, a)[plane]
        heights = [np.einsum("ij,ij->i", normal[plane], corners[third, k]) for k in range(3)]
        above, below = np.maximum.reduce(heights), np.minimum.reduce(heights)
        pairs = pairs[(above > offset) & (below < offset)]
    return pairs


def _pierced(
    start: FloatArray, end: FloatArray, triangle: FloatArray
) -> tuple[npt.NDArray[np.bool_], FloatArray]:
    """Whether segments (k, 3) pass through triangles (k, 3, 3), and where they meet the planes."""
    a, u, v = triangle[:, 0], triangle[:, 1] - triangle[:, 0], triangle[:, 2] - triangle[:, 0]
    normal = np.cross(u, v)
    along = end - start
    with np.errstate(divide="ignore", invalid="ignore"):
        t = np.einsum("ij,ij->i", a - start, normal) / np.einsum("ij,ij->i", along, normal)
        place = start + t[:, None] * along
        square = np.einsum("ij,ij->i", normal, normal)
        r = np.einsum("ij,ij->i", np.cross(place - a, v), normal) / square
        s = np.einsum("ij,ij->i", np.cross(u, place - a), normal) / square
        least = np.minimum.reduce([t, 1.0 - t, r, s, 1.0 - r - s])
        return least > INSIDE, place


def _near_pairs(corners: FloatArray, most_pairs: int) -> Numbers:
    """Pairs (k, 2) of triangles whose boxes overlap, by a tree of boxes; none where too many."""
    low, high = corners.min(axis=1), corners.max(axis=1)
    order = _along_a_curve(0.5 * (low + high))
    levels = [(low[order], high[order])]
    while len(levels[-1][0]) > 1:
        levels.append(_joined(*levels[-1]))
    pairs = np.zeros((1, 2), dtype=np.int64)
    for lows, highs in levels[-2::-1]:
        halves = 2 * pairs[:, None] + np.array([[0, 0], [0, 1], [1, 0], [1, 1]])
        pairs = halves.reshape(-1, 2)
        pairs = pairs[(pairs[:, 0] <= pairs[:, 1]) & (pairs[:, 1] < len(lows))]
        for axis in range(3):
            low, high, (one, other) = lows[:, axis], highs[:, axis], pairs.T
            pairs = pairs[(low[one] <= high[other]) & (low[other] <= high[one])]
        if len(pairs) > most_pairs:
            return np.zeros((0, 2), dtype=np.int64)
    return order[pairs[pairs[:, 0] < pairs[:, 1]]]


def _joined(low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Boxes around each two neighbouring boxes; the last stays alone where their number is odd."""
    starts = np.arange(0, len(low), 2)
    return np.minimum.reduceat(low, starts), np.maximum.reduceat(high, starts)


def _along_a_curve(centres: FloatArray) -> Numbers:
    """Order of points along a Morton curve, so that neighbours in it are near each other."""
    span = np.ptp(centres, axis=0).max() or 1.0
    cells = np.minimum((centres - centres.min(axis=0)) / span * 2**20, 2**20 - 1).astype(np.uint64)
    key = np.zeros(len(centres), dtype=np.uint64)
    for bit in range(20):
        for axis in range(3):
            picked = (cells[:, axis] >> np.uint64(bit)) & np.uint64(1)
            key |= picked << np.uint64(3 * bit + axis)
    return np.argsort(key, kind="stable").astype(np.int64)
