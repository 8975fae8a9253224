"""What a body did, from the places (f, n, 3) m of its nodes by frame and at rest (n, 3) m.

Nothing here knows where the places come from: charts take them from a run, benchmarks from a stage.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import BoolArray, FloatArray

LOWEST = 1e-6
"""m within which nodes are level at rest."""

CLEAR = 1e-3
"""m above the floor from which a node counts as in the air."""

MIDDLE = 0.07
"""m to either side of the middle of a lying body."""


def base(rest: FloatArray) -> BoolArray:
    """Mask of the nodes on which the body stands at rest."""
    return np.asarray(rest[:, 2] < LOWEST)


def spans(mask: BoolArray) -> list[tuple[int, int]]:
    """First and one past the last frame of each run of frames that a mask (f,) holds."""
    edges = np.diff(np.concatenate([[False], mask, [False]]).astype(int))
    return list(zip(np.flatnonzero(edges == 1), np.flatnonzero(edges == -1), strict=True))


def turned(
    rest: FloatArray, points: FloatArray, axis: int, weights: FloatArray | None = None
) -> FloatArray:
    """Degrees about x, y or z that the body has turned, by the rotation that fits best there.

    Nodes count by their weights (n,), or all alike.
    """
    shares = np.full(len(rest), 1.0 / len(rest)) if weights is None else weights / weights.sum()
    rest = shares[:, None] * (rest - shares @ rest)
    first, second = (axis + 1) % 3, (axis + 2) % 3
    moments = np.einsum("ni,fnj->fij", rest, points)
    across = moments[:, first, second] - moments[:, second, first]
    along = moments[:, first, first] + moments[:, second, second]
    return np.asarray(np.degrees(np.unwrap(np.arctan2(across, along))))


def turned_in_air(lowest: FloatArray, angle: FloatArray) -> float:
    """Degrees turned from when the lowest node first leaves the floor to when it is back for good.

    Of its height (f,) m and the angle (f,). Frames are too far apart to count whole: jump-t turns
    by 5 degrees in 1/60 s.
    """
    frames = np.flatnonzero(lowest > CLEAR)
    if not len(frames):
        return 0.0
    first, last = frames[0], frames[-1]
    before = _at_floor(lowest[first::-1], angle[first::-1], lowest[first : last + 1])
    after = _at_floor(lowest[last:], angle[last:], lowest[first : last + 1][::-1])
    return after - before


def _at_floor(lowest: FloatArray, angle: FloatArray, flight: FloatArray) -> float:
    """The angle where a body comes to the floor between the first of these frames and the next.

    That of the first where there is no other. The height goes on as the parabola through three
    frames of the flight, in the order in which they are before the floor, where it bends down.
    """
    if len(lowest) < 2:
        return float(angle[0])
    above = lowest[0] - CLEAR
    share = above / (lowest[0] - lowest[1])
    bend = flight[0] - 2.0 * flight[1] + flight[2] if len(flight) >= 3 else 0.0
    if bend < 0.0:
        slope = flight[0] - flight[1] + 0.5 * bend
        share = min(1.0, 2.0 * above / (np.sqrt(slope**2 - 2.0 * bend * above) - slope))
    return float(angle[0] + share * (angle[1] - angle[0]))


def turned_back(angle: FloatArray) -> float:
    """Degrees of a turn (f,) from the furthest forward to the furthest back after it."""
    furthest = int(angle.argmax())
    return float(angle[furthest] - angle[furthest:].min())


def backward(way: FloatArray) -> float:
    """Sum of all steps backward along a way (f,), m."""
    return -float(np.minimum(np.diff(way), 0.0).sum())


def belly_middle(rest: FloatArray, points: FloatArray) -> FloatArray:
    """Height of the lowest node under the middle of a lying body, (f,) m."""
    middle = base(rest) & (np.abs(rest[:, 0]) < MIDDLE)
    return np.asarray(points[:, middle, 2].min(axis=1))


def lowest(points: FloatArray, regions: list[npt.NDArray[np.int32]]) -> FloatArray:
    """Height of the lowest node of each region, (f, k) m."""
    return np.stack([points[:, nodes, 2].min(axis=1) for nodes in regions], axis=1)
