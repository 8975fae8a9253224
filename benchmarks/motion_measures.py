"""What a motion did, from its stage alone: one number, or one a frame, for each thing asked."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from warp_softbody.character import Character
from warp_softbody.stage_exports.measures import Measures
from warp_softbody.stage_exports.reader import Take

FloatArray = npt.NDArray[np.float64]

CLEAR = 1e-3
"""m above the floor from which a node counts as in the air."""

LOWEST = 1e-6
"""m within which nodes are level at rest."""


def base(take: Take) -> npt.NDArray[np.bool_]:
    """Mask of the nodes on which the body stands at rest."""
    return np.asarray(take.rest[:, 2] < LOWEST)


def base_path(take: Take) -> FloatArray:
    """Middle of the base, (f, 3) m."""
    return np.asarray(take.tet_points[:, base(take)].mean(axis=1))


def region_path(take: Take, character: Character, name: str) -> FloatArray:
    """Mean of a region's nodes, (f, 3) m."""
    return np.asarray(take.tet_points[:, character.region(name)].mean(axis=1))


def spans(mask: npt.NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First and one past the last frame of each run of frames that a mask (f,) holds."""
    edges = np.diff(np.concatenate([[False], mask, [False]]).astype(int))
    return list(zip(np.flatnonzero(edges == 1), np.flatnonzero(edges == -1), strict=True))


def airborne(take: Take) -> npt.NDArray[np.bool_]:
    """Frames in which no node is near the floor."""
    return np.asarray(take.tet_points[:, :, 2].min(axis=1) > CLEAR)


def flights(take: Take) -> list[float]:
    """Lengths in s of the times in the air."""
    return [(end - begin) / take.fps for begin, end in spans(airborne(take))]


def turned(take: Take, axis: int) -> FloatArray:
    """Degrees about x, y or z that the body has turned, by the rotation that fits best there."""
    rest = take.rest - take.rest.mean(axis=0)
    first, second = (axis + 1) % 3, (axis + 2) % 3
    angles = []
    for points in take.tet_points:
        moments = rest.T @ (points - points.mean(axis=0))
        across = moments[first, second] - moments[second, first]
        angles.append(np.arctan2(across, moments[first, first] + moments[second, second]))
    return np.degrees(np.unwrap(angles))


def turned_in_air(take: Take) -> float:
    """Degrees about the vertical from the first frame in the air to the last, either way."""
    frames = np.flatnonzero(airborne(take))
    if not len(frames):
        return 0.0
    yaw = turned(take, 2)
    return float(abs(yaw[frames[-1]] - yaw[frames[0]]))


def rolled_back(take: Take) -> float:
    """Degrees about y from the furthest forward to the furthest back after it."""
    angle = turned(take, 1)
    furthest = int(angle.argmax())
    return float(angle[furthest] - angle[furthest:].min())


def leaning(take: Take, head: float) -> FloatArray:
    """Degrees by which what is above ``head`` m at rest has turned over the base towards +x."""
    top = take.rest[:, 2] > head - LOWEST
    ways = (take.tet_points[:, top].mean(axis=1) - base_path(take))[:, [0, 2]]
    rest = (take.rest[top].mean(axis=0) - take.rest[base(take)].mean(axis=0))[[0, 2]]
    return np.asarray(np.degrees(np.arctan2(*ways.T) - np.arctan2(*rest)))


def lifted(take: Take) -> float:
    """Largest share of the base's nodes that is off the floor at once."""
    return float((take.tet_points[:, base(take), 2] > CLEAR).mean(axis=1).max())


def speed(take: Take, measures: Measures) -> FloatArray:
    """Of the centre of mass, (f,) m/s, by central differences."""
    path = np.gradient(measures.centre_of_mass, measures.times, axis=0)
    return np.asarray(np.linalg.norm(path, axis=1))


def height(measures: Measures) -> FloatArray:
    """Of the centre of mass, (f,), over that of the first frame."""
    return np.asarray(measures.centre_of_mass[:, 2] / measures.centre_of_mass[0, 2])


def backward(way: FloatArray) -> float:
    """Sum of all steps backward along a way (f,), m."""
    return -float(np.minimum(np.diff(way), 0.0).sum())


def slip(way: FloatArray) -> float:
    """Steps backward over what is gained in the end; infinite where nothing is gained."""
    gained = float(way[-1] - way[0])
    return backward(way) / gained if gained > 0.0 else np.inf


def belly_middle(take: Take) -> FloatArray:
    """Height of the lowest node under the middle of a lying body, (f,) m."""
    middle = base(take) & (np.abs(take.rest[:, 0]) < 0.07)
    return np.asarray(take.tet_points[:, middle, 2].min(axis=1))


def lowest_of_regions(take: Take, character: Character, names: tuple[str, ...]) -> FloatArray:
    """Height of the lowest node of each region, (f, k) m."""
    regions = [character.region(name) for name in names]
    return np.stack([take.tet_points[:, nodes, 2].min(axis=1) for nodes in regions], axis=1)


def lifts(heights: FloatArray, clear: float) -> list[float]:
    """How high a foot (f,) came each time that it was lifted and put down again, m."""
    return [
        float(heights[begin:end].max())
        for begin, end in spans(heights > clear)
        if end < len(heights)
    ]
