"""Where a walking body sets its feet and carries its middle over ground that is not level."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.motions.ground_below import GroundBelow
from warp_softbody.world.view import BodyView

SAMPLES = 9
"""Places at which the ground is looked at along a way."""


class FootingOnTerrain:
    """Heights of footholds, of humps between them, and of the middle over all feet.

    All are told from how the body stood at first, when each foot had some height over the ground.
    """

    def __init__(self, below: GroundBelow, lowest: FloatArray) -> None:
        """Remember how the feet (feet, 3) m stand."""
        self._below = below
        self._clear = lowest[:, 2] - below.heights(lowest, float(lowest[:, 2].mean()))
        self._level = float((lowest[:, 2] - self._clear).mean())

    @classmethod
    def of(cls, view: BodyView, lowest: FloatArray) -> FootingOnTerrain | None:
        """On the ground of a view; None where that is level."""
        below = GroundBelow.of(view)
        return None if below is None else cls(below, lowest)

    def foothold(self, foot: int, place: FloatArray) -> float:
        """Height, m, of a foot that stands at the x and y of a place (3,) m."""
        height = self._below.heights(place[None], float(place[2]))[0]
        return float(height + self._clear[foot])

    def hump(self, begin: FloatArray, end: FloatArray) -> float:
        """By how much, m, the ground stands above the straight way between two places (3,) m."""
        shares = np.linspace(0.0, 1.0, SAMPLES)
        way = begin + shares[:, None] * (end - begin)
        heights = self._below.heights(way, float(begin[2]))
        return max(0.0, float((heights - way[:, 2]).max()))

    def stance(self, middle: FloatArray, home: FloatArray, stride: FloatArray) -> Stance:
        """How the body stands where its centre of mass is over a middle (2 or more,) m.

        The ground is taken for the plane that fits it best under the feet and half a stride about
        them, so that the middle goes over edges without a jerk.

        Args:
            middle: x and y of the centre of mass.
            home: (feet, 3) m, places of the feet from it on level ground.
            stride: (2,) m, which way and how far it goes in a cycle.
        """
        along = np.linspace(-0.5, 0.5, SAMPLES)[:, None] * stride
        offsets = np.repeat(home[:, :2], SAMPLES, axis=0) + np.tile(along, (len(home), 1))
        heights = self._below.heights(middle[:2] + offsets, self._level)
        columns = np.column_stack([np.ones(len(offsets)), offsets])
        level, *slopes = np.linalg.lstsq(columns, heights, rcond=None)[0]
        normal = np.array([-slopes[0], -slopes[1], 1.0])
        normal /= np.linalg.norm(normal)
        up = -float((home[:, 2] - self._clear).mean())
        foot = -up * normal[:2]
        return Stance(
            height=float(level + foot @ slopes + up * normal[2]), home=home @ _turn_to(normal).T
        )


class Stance(NamedTuple):
    """The centre of mass's height, m, and places (feet, 3) m of the feet from it."""

    height: float
    home: FloatArray


def _turn_to(normal: FloatArray) -> FloatArray:
    """The least rotation (3, 3) that takes the vertical to a unit normal."""
    axis = np.array([-normal[1], normal[0], 0.0])
    cross = np.array([[0.0, 0.0, axis[1]], [0.0, 0.0, -axis[0]], [-axis[1], axis[0], 0.0]])
    return np.asarray(np.eye(3) + cross + cross @ cross / (1.0 + normal[2]))
