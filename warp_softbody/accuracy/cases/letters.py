"""Single numbers of controlled motions: what a letter was asked for, and how far it came."""

from __future__ import annotations

import numpy as np

from warp_softbody.accuracy.cases import body_motion
from warp_softbody.accuracy.cases.track import Track
from warp_softbody.arrays import FloatArray
from warp_softbody.scenes import exercise_h

UPRIGHT = 5.0
"""Degrees from the vertical below which a body is upright."""

ASTRAY = 0.1
"""Of the amplitude, the largest distance from its path that is no failure of an exercise."""

LIFTED = 0.0076
"""m, 2 % of the height of letter X, from which on a foot counts as swung."""

FEET = ("foot_0", "foot_1", "foot_2", "foot_3")


def _rotations(track: Track) -> FloatArray:
    """Rotations (f, 3, 3) from rest that fit all nodes best (Kabsch)."""
    weights = track.masses / track.masses.sum()
    rest = track.scene.whole.mesh.points
    rest = rest - weights @ rest
    moved = track.points - (weights @ track.points)[:, None]
    left, _, right = np.linalg.svd(np.einsum("n,fni,nj->fij", weights, moved, rest))
    left[:, :, 2] *= np.sign(np.linalg.det(left @ right))[:, None]
    return np.asarray(left @ right)


def tilts(track: Track) -> FloatArray:
    """Degrees between the body's own vertical and the world's, by frame."""
    axis = _rotations(track)[:, :, 2]
    return np.degrees(np.arctan2(np.hypot(axis[:, 0], axis[:, 1]), axis[:, 2]))


def largest_tilt(track: Track) -> float:
    """Degrees."""
    return float(tilts(track).max())


def last_tilt(track: Track) -> float:
    """Degrees."""
    return float(tilts(track)[-1])


def upright_again(track: Track) -> float:
    """When the body leans for the last time, s; linear between two frames."""
    angles = tilts(track)
    leaning = np.flatnonzero(angles > UPRIGHT)
    if not len(leaning):
        return 0.0
    last = int(leaning[-1])
    if last + 1 == len(angles):
        return float(track.times[-1])
    share = (angles[last] - UPRIGHT) / (angles[last] - angles[last + 1])
    return float(track.times[last] + share * (track.times[last + 1] - track.times[last]))


def sway_error(track: Track) -> float:
    """Largest distance from the wanted path after its first half period, over the amplitude."""
    path, start = exercise_h.path_in_si(track.scene)
    moved = track.centers[:, 0] - track.centers[0, 0]
    times = track.times - start
    wanted = np.array([path.at(max(0.0, float(time)))[0] for time in times])
    apart = np.abs(moved - wanted)[times > 0.5 * path.period - 1e-6]
    return float(apart.max(initial=0.0) / path.amplitude)


def swing(track: Track) -> float:
    """Half the way of the centre of mass to and fro along x, m."""
    return 0.5 * float(np.ptp(track.centers[:, 0]))


def slipped(track: Track) -> float:
    """Sum of the steps of the centre of mass back along x, frame by frame, m."""
    return body_motion.backward(track.centers[:, 0])


def arch(track: Track) -> float:
    """Mean over its arches of the largest height under the middle of a lying body, m.

    The height is that of the lowest node; an arch is higher than half of the highest.
    """
    height = body_motion.belly_middle(_rest(track), track.points)
    return _mean_top([height], 0.5 * float(height.max()))


def swing_height(track: Track) -> float:
    """Mean over all swings of all feet of the largest height of a foot's lowest node, m.

    A swing that the run cuts off is none. How high single feet come is something else: where the
    body leans, one foot is higher by what another one lacks, and the lean is measured by itself.
    """
    character = track.scene.character
    feet = body_motion.lowest(track.points, [character.region(name) for name in FEET])
    return _mean_top(list(feet.T), LIFTED)


def _mean_top(heights: list[FloatArray], clear: float) -> float:
    """Mean of the largest heights of all times above ``clear`` that end; 0 where there are none."""
    tops = [
        float(height[begin:end].max())
        for height in heights
        for begin, end in body_motion.spans(height > clear)
        if end < len(height)
    ]
    return float(np.mean(tops)) if tops else 0.0


def turned_in_air(track: Track) -> float:
    """Degrees about the vertical in the air."""
    return body_motion.turned_in_air(track.points[:, :, 2].min(axis=1), _turned(track, 2))


def take_off_speed(track: Track) -> float:
    """Largest speed at which the centre of mass rises, m/s, by central differences."""
    return float(np.gradient(track.centers[:, 2], track.times).max())


def rolled(track: Track) -> float:
    """Degrees about y at the end."""
    return float(_turned(track, 1)[-1])


def rolled_furthest(track: Track) -> float:
    """Largest number of degrees about y."""
    return float(_turned(track, 1).max())


def rolled_back(track: Track) -> float:
    """Degrees about y from the furthest forward to the furthest back after it."""
    return body_motion.turned_back(_turned(track, 1))


def _rest(track: Track) -> FloatArray:
    return track.scene.character.mesh.points


def _turned(track: Track, axis: int) -> FloatArray:
    return body_motion.turned(_rest(track), track.points, axis, track.masses)
