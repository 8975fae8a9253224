"""The frame in which a walking body's feet have their places; it goes and turns as it is steered.

A frame has a place on the ground and a yaw, the angle by which it has turned about the vertical.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from warp_softbody.arrays import FloatArray


class Rates(NamedTuple):
    """Speeds forward and aside, m/s, and of turning, rad/s."""

    forward: float = 0.0
    aside: float = 0.0
    turning: float = 0.0

    def times(self, factor: float) -> Rates:
        """Each times a number."""
        return Rates(*(factor * rate for rate in self))


class MovingFrame(NamedTuple):
    """A frame as it is at some time.

    Attributes:
        place: (2,) m.
        yaw: rad, by which it has turned.
        rates: at which it goes on.
    """

    place: FloatArray
    yaw: float = 0.0
    rates: Rates = Rates()

    def at(self, place: FloatArray) -> FloatArray:
        """Where a place of the frame (2,) m is on the ground."""
        return self.place + turned(place, self.yaw)

    def velocity(self, heading: float) -> FloatArray:
        """At which it goes on, (2,) m/s; ``heading``, rad, is what is forward in it."""
        return turned(np.array(self.rates[:2]), self.yaw + heading)

    def on(self, seconds: float, heading: float) -> MovingFrame:
        """The frame after some time, or before it, at the rates that it has: along an arc."""
        half = 0.5 * seconds * self.rates.turning
        # the chord of an arc
        share = math.sin(half) / half if abs(half) > 1e-9 else 1.0
        way = turned(np.array(self.rates[:2]), self.yaw + half + heading)
        return self._replace(place=self.place + seconds * share * way, yaw=self.yaw + 2.0 * half)

    def steered(
        self, seconds: float, wanted: Rates, hastening: Rates, heading: float
    ) -> MovingFrame:
        """The frame after some time in which its rates come to those that are wanted.

        Each rate changes evenly, by ``hastening`` in a second, until it is there. Where they
        change, the frame goes along the arc of their means.
        """
        if self.rates == wanted:
            return self.on(seconds, heading)
        means, ends = [], []
        for now, goal, most in zip(self.rates, wanted, hastening, strict=True):
            lasts = abs(goal - now) / most
            end = goal if lasts <= seconds else now + math.copysign(most * seconds, goal - now)
            means.append(_mean(now, end, min(1.0, lasts / seconds) if seconds > 0.0 else 1.0))
            ends.append(end)
        return self._replace(rates=Rates(*means)).on(seconds, heading)._replace(rates=Rates(*ends))


def _mean(now: float, end: float, share: float) -> float:
    """Mean of a rate that changes evenly over a share of the time and then stays."""
    return end + share * (now - end) / 2.0


def turned(way: FloatArray, angle: float) -> FloatArray:
    """A way (2,) turned by an angle, rad, from x towards y."""
    c, s = math.cos(angle), math.sin(angle)
    x, y = way.tolist()
    return np.array([c * x - s * y, s * x + c * y])
