"""The area over which a body stands, seen from above, and the way that brings a point over it."""

from __future__ import annotations

import numpy as np

from warp_softbody.arrays import FloatArray


def hull(points: FloatArray) -> FloatArray:
    """Corners (h, 2) of the convex hull of points (n, 2), counterclockwise (Andrew 1979)."""
    ordered = np.unique(points, axis=0)
    if len(ordered) < 3:
        return ordered
    sides = [_half(ordered), _half(ordered[::-1])]
    return np.concatenate([side[:-1] for side in sides])


def _half(ordered: FloatArray) -> FloatArray:
    kept: list[FloatArray] = []
    for point in ordered:
        while len(kept) > 1 and _cross(kept[-1] - kept[-2], point - kept[-1]) <= 0.0:
            kept.pop()
        kept.append(point)
    return np.array(kept)


def _cross(one: FloatArray, other: FloatArray) -> float:
    return float(one[0] * other[1] - one[1] * other[0])


def nearest_in(corners: FloatArray, point: FloatArray) -> FloatArray:
    """The point (2,) of a convex polygon with corners (h, 2), counterclockwise, that is nearest."""
    ahead = np.roll(corners, -1, axis=0)
    sides = ahead - corners
    if len(corners) > 2 and all(
        _cross(side, point - corner) >= 0.0 for corner, side in zip(corners, sides, strict=True)
    ):
        return np.array(point)
    lengths = np.square(sides).sum(axis=1)
    along = np.einsum("ij,ij->i", point - corners, sides) / np.where(lengths > 0.0, lengths, 1.0)
    places = corners + np.clip(along, 0.0, 1.0)[:, None] * sides
    return np.asarray(places[np.square(places - point).sum(axis=1).argmin()])


def drawn_together(corners: FloatArray, margin: float) -> FloatArray:
    """Corners (h, 2) nearer to their mean by a share ``margin``."""
    middle = corners.mean(axis=0)
    return np.asarray(middle + (1.0 - margin) * (corners - middle))


def reach(corners: FloatArray, way: FloatArray) -> float:
    """How far the edge of a convex polygon is from the origin along a way (2,).

    Infinite along no way at all, and 0 of a polygon that is but a line or a point.

    Args:
        corners: (h, 2), counterclockwise, around the origin.
        way: (2,) of any length.
    """
    size = float(np.linalg.norm(way))
    if size == 0.0:
        return float("inf")
    if len(corners) < 3:
        return 0.0
    sides = np.roll(corners, -1, axis=0) - corners
    outwards = np.stack([sides[:, 1], -sides[:, 0]], axis=1)
    rises = outwards @ (way / size)
    ahead = rises > 1e-12 * np.linalg.norm(outwards, axis=1)
    distances = np.einsum("ij,ij->i", outwards, corners)[ahead] / rises[ahead]
    return max(float(distances.min(initial=np.inf)), 0.0)


def room(sole: FloatArray, middle: FloatArray) -> float:
    """How far a centre of mass is from tipping over an edge of a sole, over its height above it.

    That is the least distance, seen from above, to the lines through the sides of the sole's hull;
    negative outside of it, and 0 on a sole of a line or a point.

    Args:
        sole: (n, 3) m, its nodes.
        middle: (3,) m, the centre of mass.
    """
    corners = hull(sole[:, :2])
    if len(corners) < 3:
        return 0.0
    sides = np.roll(corners, -1, axis=0) - corners
    arms = middle[:2] - corners
    inwards = sides[:, 0] * arms[:, 1] - sides[:, 1] * arms[:, 0]
    height = max(float(middle[2] - sole[:, 2].min()), 1e-12)
    return float((inwards / np.linalg.norm(sides, axis=1)).min()) / height
