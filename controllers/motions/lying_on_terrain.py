"""How high a crawling body carries its ends and its middle over ground that is not level."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.motions.ground_below import GroundBelow
from warp_softbody.world.view import BodyView

REACH = 0.12
"""L, how far ahead and behind an end is lifted over what stands up there."""

TREND = 0.3
"""L, ahead and behind, over which the ground's slope is taken: along it nothing stands up."""

MARGIN = 0.35
"""By how much more than a bump is high a part is lifted over it: its nodes are apart, and what is
between them hangs through."""

JUST_BEHIND, JUST_AHEAD, EDGE_SAMPLES = 0.02, 0.05, 9
"""L, from where to where an edge is that a node is lifted over, and places that are looked at: a
node that is held by the face of a step is already over it."""

LEAST_EDGE, STEEP, EDGE_MARGIN = 0.025, 1.0, 0.008
"""L, rise over that way from which on it is an edge; how steep it is at its steepest, a slope; and
L, what a node is lifted above it."""

SAMPLES = 25
"""Places at which the ground is looked at, from behind to ahead."""


class Rise(NamedTuple):
    """A height, m, to be kept at a place, and how it changes with the way along x.

    Attributes:
        height: m.
        slope: m/m.
        bump: m, how much of the height is for what stands up nearby.
    """

    height: float
    slope: float
    bump: float = 0.0


class LyingOnTerrain:
    """Heights over ground for parts of a body that goes along x, told from how it lay at first."""

    def __init__(self, below: GroundBelow, length: float) -> None:
        """Look at the ground on the scale of a body's length, m."""
        self._below, self._length = below, length
        self._offsets = TREND * length * np.linspace(-1.0, 1.0, SAMPLES)
        self._within = np.abs(self._offsets) <= REACH * length
        self._step = 0.5 * (self._offsets[1] - self._offsets[0])

    @classmethod
    def of(cls, view: BodyView, length: float) -> LyingOnTerrain | None:
        """On the ground of a view; None where that is level."""
        below = GroundBelow.of(view)
        return None if below is None else cls(below, length)

    def over(self, place: FloatArray) -> Rise:
        """What clears all that stands up near a place (3,) m against the slope there."""
        (behind, low), (ahead, high) = (self._near(place, way) for way in (-self._step, self._step))
        bump = 0.5 * (low + high)
        height = 0.5 * (behind + ahead) + MARGIN * bump
        return Rise(height, 0.5 * (ahead - behind) / self._step, bump)

    def along(self, place: FloatArray) -> Rise:
        """The plane that fits best around a place (3,) m, as the middle of a body lies on it."""
        heights = self._heights(place, 0.0)
        slope = float(self._offsets @ heights / (self._offsets @ self._offsets))
        return Rise(float(heights.mean()), slope)

    def lacking(self, places: FloatArray) -> tuple[FloatArray, FloatArray]:
        """By how much (k,) m places (k, 3) m are below an edge just ahead of them, and how near.

        Zero where there is none; nearness (k,) goes from 0 to 1.
        """
        offsets = np.linspace(-JUST_BEHIND, JUST_AHEAD, EDGE_SAMPLES) * self._length
        x = places[:, :1] + offsets
        y = np.broadcast_to(places[:, 1:2], x.shape)
        ways = np.column_stack([x.ravel(), y.ravel()])
        heights = self._below.heights(ways, float(places[:, 2].mean())).reshape(x.shape)
        is_edge = np.ptp(heights, axis=1) > LEAST_EDGE * self._length
        is_edge &= np.diff(heights, axis=1).max(axis=1) > STEEP * (offsets[1] - offsets[0])
        wanted = heights.max(axis=1) + EDGE_MARGIN * self._length
        lacks = np.where(is_edge, np.maximum(wanted - places[:, 2], 0.0), 0.0)
        above = heights > places[:, 2:]
        free = np.where(above.any(axis=1), above.argmax(axis=1), EDGE_SAMPLES)
        return lacks, 1.0 - free / (EDGE_SAMPLES + 1.0)

    def _near(self, place: FloatArray, shift: float) -> tuple[float, float]:
        """The highest that stands up within reach, and by how much over the lowest, m."""
        heights = self._heights(place, shift)
        slope = self._offsets @ heights / (self._offsets @ self._offsets)
        stands = (heights - slope * self._offsets)[self._within]
        return float(stands.max()), float(np.ptp(stands))

    def _heights(self, place: FloatArray, shift: float) -> FloatArray:
        x = place[0] + shift + self._offsets
        ways = np.column_stack([x, np.full(SAMPLES, place[1])])
        return self._below.heights(ways, float(place[2]))
