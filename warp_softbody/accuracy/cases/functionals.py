"""Single numbers that say what a motion came to, measured from the frames of a run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from warp_softbody.accuracy.cases import letters
from warp_softbody.accuracy.cases.track import Track
from warp_softbody.arrays import FloatArray


@dataclass(frozen=True, kw_only=True)
class Functional:
    """A number of a motion.

    Attributes:
        unit: of it.
        text: what it is, for people.
        scale: what an error is relative to; None for the reference's own value. Of a number that
            is to be small, as an error or a tilt at the end is, the most that is allowed of it.
        limit: for what has to stay small and is no outcome: the most that a motion may have of it,
            to be offered; such a number is no part of an error.
        of: measures it.
    """

    unit: str
    text: str
    scale: float | None = None
    limit: float | None = None
    of: Callable[[Track], float]


def _tip_fall(track: Track) -> float:
    tip = track.scene.character.region("tip")
    return float(np.max(track.points[0, tip, 2].mean() - track.points[:, tip, 2].mean(axis=1)))


def _end_turn(track: Track) -> float:
    end = track.scene.character.region("end")
    rest = track.scene.character.mesh.points[end, 1:]
    now = track.points[:, end, 1:]
    now = now - now.mean(axis=1, keepdims=True)
    across = (rest[:, 0] * now[:, :, 1] - rest[:, 1] * now[:, :, 0]).sum(axis=1)
    along = (rest * now).sum(axis=(1, 2))
    return float(np.degrees(np.unwrap(np.arctan2(across, along))).max())


def _way(track: Track) -> float:
    return float(np.linalg.norm(track.centers[-1] - track.centers[0]))


def _way_ahead(track: Track) -> float:
    return float(track.centers[-1, 0] - track.centers[0, 0])


def _rebound(track: Track) -> float:
    heights = track.centers[:, 2]
    return _peak(heights[int(heights[: len(heights) // 2].argmin()) :])


def _peak(heights: FloatArray) -> float:
    """Largest value of the parabola through the largest sample and its neighbours."""
    top = int(heights.argmax())
    if not 0 < top < len(heights) - 1:
        return float(heights[top])
    left, middle, right = heights[top - 1 : top + 2]
    bend = 2.0 * middle - left - right
    return float(middle + (right - left) ** 2 / (8.0 * bend)) if bend > 0.0 else float(middle)


def _top_height(track: Track) -> float:
    top = track.scene.parts[-1].nodes
    masses = track.masses[top]
    return float(masses @ track.points[-1, top, 2] / masses.sum())


FUNCTIONALS = {
    "tip_fall": Functional(unit="m", text="largest fall of the tip face", of=_tip_fall),
    "end_turn": Functional(unit="degrees", text="largest turn of the end face", of=_end_turn),
    "way": Functional(unit="m", text="way of the centre of mass", of=_way),
    "way_ahead": Functional(
        unit="m", text="way of the centre of mass along x", scale=1.0, of=_way_ahead
    ),
    "rebound": Functional(unit="m", text="height of the centre after the bounce", of=_rebound),
    "top_height": Functional(unit="m", text="last height of the top body", of=_top_height),
    "gone": Functional(unit="m", text="way of the centre of mass along x", of=_way_ahead),
    "slipped": Functional(unit="m", text="way back", scale=1.0, of=letters.slipped),
    "largest_tilt": Functional(
        unit="degrees", text="largest tilt", scale=90.0, of=letters.largest_tilt
    ),
    "last_tilt": Functional(
        unit="degrees", text="tilt at the end", scale=letters.UPRIGHT, of=letters.last_tilt
    ),
    "upright_again": Functional(
        unit="s",
        text="time from which the tilt stays below 5 degrees",
        of=letters.upright_again,
    ),
    "sway_error": Functional(
        unit="of the amplitude",
        text="largest distance from the wanted path",
        scale=letters.ASTRAY,
        of=letters.sway_error,
    ),
    "swing": Functional(unit="m", text="half the way to and fro", of=letters.swing),
    "arch": Functional(
        unit="m", text="mean height of the arches of the belly's middle", of=letters.arch
    ),
    "swing_height": Functional(
        unit="m", text="mean height to which a foot is swung", of=letters.swing_height
    ),
    "turned_in_air": Functional(
        unit="degrees", text="turn about the vertical in the air", of=letters.turned_in_air
    ),
    "take_off_speed": Functional(
        unit="m/s",
        text="largest speed at which the centre of mass rises",
        of=letters.take_off_speed,
    ),
    "rolled": Functional(unit="degrees", text="angle rolled at the end", of=letters.rolled),
    "rolled_furthest": Functional(
        unit="degrees", text="largest angle rolled", of=letters.rolled_furthest
    ),
    "rolled_back": Functional(unit="degrees", text="angle rolled back", of=letters.rolled_back),
    "volume": Functional(
        unit="",
        text="largest change of the volume, as a share",
        limit=0.03,
        of=lambda track: track.soundness.volume,
    ),
    "reversals": Functional(
        unit="",
        text="share of accelerations that turn against those before",
        limit=0.1,
        of=lambda track: track.soundness.reversals,
    ),
}
