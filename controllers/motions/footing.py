"""Where a walking body sets its feet and carries its middle over ground that is not level."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.motions.ground_below import GroundBelow
from warp_softbody.world.view import BodyView

SAMPLES = 9
"""Places at which the ground is looked at along a way."""

REACH, CANDIDATES = 1.5, 6
"""Half soles by which a foot is set down elsewhere, at most, and places tried on either side."""

ROOM, EDGE, SOLE = 0.3, 0.25, 7
"""Half soles of room around a sole, and by which the ground under it may differ from a plane, and
places along and across a sole at which that is looked at."""


class FootingOnTerrain:
    """Heights of footholds, of humps between them, and of the middle over all feet.

    All are told from how the body stood at first, when each foot had some height over the ground.
    """

    def __init__(self, below: GroundBelow, lowest: FloatArray, half: float = 0.0) -> None:
        """Remember how the feet (feet, 3) m stand, each so far, m, from its middle to its end."""
        self._below, self._half = below, half
        self._clear = lowest[:, 2] - below.heights(lowest, float(lowest[:, 2].mean()))
        self._level = float((lowest[:, 2] - self._clear).mean())

    @classmethod
    def of(
        cls, view: BodyView, lowest: FloatArray, feet: tuple[str, ...]
    ) -> FootingOnTerrain | None:
        """On the ground of a view, on regions that are feet; None where that is level."""
        below = GroundBelow.of(view)
        if below is None:
            return None
        points, region = view.scene.character.mesh.points, view.scene.character.region
        half = max(0.5 * float(np.ptp(points[region(name), :2], axis=0).max()) for name in feet)
        return cls(below, lowest, half)

    def foothold(self, foot: int, place: FloatArray) -> float:
        """Height, m, of a foot that stands at the x and y of a place (3,) m."""
        height = self._below.heights(place[None], float(place[2]))[0]
        return float(height + self._clear[foot])

    def beside_edge(self, place: FloatArray, way: FloatArray) -> FloatArray:
        """By how much (2,) m a foot is set down before or beyond a place (3,) m, off any edge.

        The least that leaves the whole sole and some room around it on ground that is nearly flat;
        where there is none, the flattest within reach.

        Args:
            place: wanted.
            way: (2,), unit, along which a foot may be moved.
        """
        room = (1.0 + ROOM) * self._half
        offsets = np.linspace(-REACH, REACH, 2 * CANDIDATES + 1) * self._half
        offsets = offsets[np.argsort(np.abs(offsets), kind="stable")]
        across = np.array([-way[1], way[0]])
        along, aside = np.meshgrid(*2 * (room * np.linspace(-1.0, 1.0, SOLE),), indexing="ij")
        sole = np.outer(along.ravel(), way) + np.outer(aside.ravel(), across)
        places = place[:2] + offsets[:, None, None] * way + sole
        flat = places.reshape(-1, 2)
        heights = self._below.heights(flat, float(place[2])).reshape(len(offsets), -1)
        columns = np.column_stack([np.ones(len(sole)), sole])
        fit = columns @ np.linalg.pinv(columns)
        off = np.ptp(heights - heights @ fit.T, axis=1)
        fine = np.flatnonzero(off <= EDGE * self._half)
        best = int(fine[0]) if len(fine) else int(off.argmin())
        return np.asarray(offsets[best] * way)

    def hump(self, begin: FloatArray, end: FloatArray) -> float:
        """By how much, m, the ground stands above the straight way between two places (3,) m.

        The end of the sole goes ahead of its middle.
        """
        beyond = self._half / max(float(np.linalg.norm((end - begin)[:2])), self._half, 1e-9)
        shares = np.linspace(0.0, 1.0 + beyond, SAMPLES)
        way = begin + shares[:, None] * (end - begin)
        heights = self._below.heights(way, float(begin[2]))
        return max(0.0, float((heights - way[:, 2]).max()))

    def highest(self, foot: int, begin: FloatArray, end: FloatArray) -> float:
        """Height, m, of a foot's lowest node on the highest ground from one place to another."""
        beyond = self._half / max(float(np.linalg.norm((end - begin)[:2])), self._half, 1e-9)
        shares = np.linspace(-beyond, 1.0 + beyond, 2 * SAMPLES)
        way = begin + shares[:, None] * (end - begin)
        heights = self._below.heights(way, float(begin[2]))
        return float(heights.max() + self._clear[foot])

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
