"""What a motion did, from its stage alone: one number, or one a frame, for each thing asked."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from warp_softbody.accuracy.cases import body_motion
from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.stage_exports.measures import Measures
from warp_softbody.stage_exports.usd.reader import Take

LEAST_FLIGHT = 0.1 - 1e-9
"""s, of a flight that counts as a leap."""


def base(take: Take) -> npt.NDArray[np.bool_]:
    """Mask of the nodes on which the body stands at rest."""
    return body_motion.base(take.rest)


def base_path(take: Take) -> FloatArray:
    """Middle of the base, (f, 3) m."""
    return np.asarray(take.tet_points[:, base(take)].mean(axis=1))


def region_path(take: Take, character: Character, name: str) -> FloatArray:
    """Mean of a region's nodes, (f, 3) m."""
    return np.asarray(take.tet_points[:, character.region(name)].mean(axis=1))


def airborne(take: Take) -> npt.NDArray[np.bool_]:
    """Frames in which no node is near the floor."""
    return np.asarray(take.tet_points[:, :, 2].min(axis=1) > body_motion.CLEAR)


def flights(take: Take) -> list[float]:
    """Lengths in s of the times in the air."""
    return [(end - begin) / take.fps for begin, end in body_motion.spans(airborne(take))]


def leaps(take: Take) -> list[float]:
    """Way in m along the ground of the base in each flight, from where it stood to where it lands.

    Between the last frame on the floor before and the first one after; of flights from 0.1 s on.
    """
    path, last = base_path(take)[:, :2], len(take.tet_points) - 1
    return [
        float(np.hypot(*(path[min(end, last)] - path[max(begin - 1, 0)])))
        for begin, end in body_motion.spans(airborne(take))
        if end - begin >= LEAST_FLIGHT * take.fps
    ]


def turned(take: Take, axis: int) -> FloatArray:
    """Degrees about x, y or z that the body has turned, by the rotation that fits best there."""
    return body_motion.turned(take.rest, take.tet_points, axis)


def turned_in_air(take: Take) -> float:
    """Degrees about the vertical in the air, either way."""
    return abs(body_motion.turned_in_air(take.tet_points[:, :, 2].min(axis=1), turned(take, 2)))


def flipped_in_air(take: Take) -> float:
    """Degrees about y, forward, from when the body leaves the floor to when it is back for good."""
    lowest = take.tet_points[:, :, 2].min(axis=1)
    first = body_motion.spans(lowest > body_motion.CLEAR)
    longest = max(first, key=lambda span: span[1] - span[0], default=(0, 0))
    own = slice(max(longest[0] - 1, 0), longest[1] + 1)
    return body_motion.turned_in_air(lowest[own], turned(take, 1)[own])


def rolled_back(take: Take) -> float:
    """Degrees about y from the furthest forward to the furthest back after it."""
    return body_motion.turned_back(turned(take, 1))


def leaning(take: Take, head: float) -> FloatArray:
    """Degrees by which what is above ``head`` m at rest has turned over the base towards +x."""
    top = take.rest[:, 2] > head - body_motion.LOWEST
    ways = (take.tet_points[:, top].mean(axis=1) - base_path(take))[:, [0, 2]]
    rest = (take.rest[top].mean(axis=0) - take.rest[base(take)].mean(axis=0))[[0, 2]]
    return np.asarray(np.degrees(np.arctan2(*ways.T) - np.arctan2(*rest)))


def lifted(take: Take) -> float:
    """Largest share of the base's nodes that is off the floor at once."""
    return float((take.tet_points[:, base(take), 2] > body_motion.CLEAR).mean(axis=1).max())


def speed(take: Take, measures: Measures) -> FloatArray:
    """Of the centre of mass, (f,) m/s, by central differences."""
    path = np.gradient(measures.centre_of_mass, measures.times, axis=0)
    return np.asarray(np.linalg.norm(path, axis=1))


def height(measures: Measures) -> FloatArray:
    """Of the centre of mass, (f,), over that of the first frame."""
    return np.asarray(measures.centre_of_mass[:, 2] / measures.centre_of_mass[0, 2])


def slip(way: FloatArray) -> float:
    """Steps backward over what is gained in the end; infinite where nothing is gained."""
    gained = float(way[-1] - way[0])
    return body_motion.backward(way) / gained if gained > 0.0 else np.inf


def belly_middle(take: Take) -> FloatArray:
    """Height of the lowest node under the middle of a lying body, (f,) m."""
    return body_motion.belly_middle(take.rest, take.tet_points)


def lowest_of_regions(take: Take, character: Character, names: tuple[str, ...]) -> FloatArray:
    """Height of the lowest node of each region, (f, k) m."""
    return body_motion.lowest(take.tet_points, [character.region(name) for name in names])


def lifts(heights: FloatArray, clear: float) -> list[float]:
    """How high a foot (f,) came each time that it was lifted and put down again, m."""
    return [
        float(heights[begin:end].max())
        for begin, end in body_motion.spans(heights > clear)
        if end < len(heights)
    ]
