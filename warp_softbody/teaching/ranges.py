"""Where gains are looked for, around the usual ones of a motion."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.motions.for_any_body.taught import number_at

TINY = 1e-9
"""Below which a usual number is none that a range could be laid around."""


@dataclass(frozen=True)
class Range:
    """Where a number is drawn from: evenly, or evenly by its logarithm."""

    low: float
    high: float
    log: bool = False

    def number(self, share: float) -> float:
        """The number at a share of the way from the low end to the high one."""
        share = min(max(share, 0.0), 1.0)
        if self.log:
            return float(self.low * (self.high / self.low) ** share)
        return self.low + (self.high - self.low) * share

    def share(self, number: float) -> float:
        """The share at which a number stands; 0 or 1 where it is beyond an end."""
        value, low, high = number, self.low, self.high
        if self.log:
            value, low, high = (math.log(max(one, TINY)) for one in (value, low, high))
        return min(max((value - low) / (high - low), 0.0), 1.0)


def around(factor: float) -> tuple[float, None]:
    """A range from the usual number over a factor to that number times it."""
    return factor, None


Wanted = Mapping[str, "tuple[float, float | None]"]
"""By path: low and high end, or a factor and None for a range around the usual number."""

COSTS: Wanted = {"activation.effort": around(4.0), "activation.change": around(5.0)}
STEPS: Wanted = {
    "stride": around(2.5),
    "step": around(2.0),
    "stand": (0.0, 0.8),
    "lift": (0.0, 0.06),
    "margin": (0.0, 0.8),
    "capture": (0.0, 2.0),
    "position": around(3.0),
    "velocity": around(3.0),
    "turn": around(4.0),
    "spin": around(3.0),
    "momentum_weight": around(4.0),
    "spin_weight": around(4.0),
    "foot_position": around(3.0),
    "foot_velocity": around(3.0),
    "foot_weight": around(6.0),
    **COSTS,
}
ROLLS: Wanted = {
    "cruise": around(2.0),
    "speedup": around(2.5),
    "follow": around(3.0),
    "acceleration": around(2.5),
    "tilt_gain": around(2.5),
    "shape_follow": around(2.5),
    "steadiness": around(4.0),
    "roll_weight": around(4.0),
    "steady_weight": around(10.0),
    "tilt_weight": around(5.0),
    "squash_weight": around(5.0),
    "steer": around(2.0),
    "steer_rate": around(2.0),
    "course": around(4.0),
    "steer_follow": around(3.0),
    "lean": around(3.0),
    "lean_decay": around(3.0),
    "steer_weight": around(5.0),
    "lean_weight": around(5.0),
    **COSTS,
}
HOPS: Wanted = {
    "launch.0": (-0.05, 0.3),
    "launch.2": around(1.5),
    "way.0": (0.0, 0.3),
    "depth": around(1.6),
    "crouch_time": around(1.8),
    "rise": around(1.6),
    "push": around(2.0),
    "spin_weight": around(6.0),
    "play": (0.0, 0.2),
    "height": around(1.15),
    "reach_weight": around(5.0),
    "rest_time": around(3.0),
    "landing.momentum_weight": around(5.0),
    "landing.upright_weight": around(5.0),
    "landing.spin_weight": around(5.0),
    **COSTS,
}
WANTED = {"walk": STEPS, "crawl": STEPS, "roll": ROLLS, "hop": HOPS}
"""What is looked for of each motion that can be taught."""


class Field:
    """The ranges of a search around the usual gains, as a cube of sides 1.

    Attributes:
        ranges: by path; numbers that have no range around them, as zero has none, are left.
    """

    def __init__(self, usual: Any, wanted: Wanted) -> None:
        """Lay the ranges around the usual gains."""
        self.ranges: dict[str, Range] = {}
        self._usual = usual
        for path, (low, high) in wanted.items():
            number = number_at(usual, path)
            if high is not None:
                self.ranges[path] = Range(low, high)
            elif number > TINY:
                self.ranges[path] = Range(number / low, number * low, log=True)

    @property
    def start(self) -> FloatArray:
        """Where the usual gains stand, (n,)."""
        return np.array([own.share(number_at(self._usual, p)) for p, own in self.ranges.items()])

    def numbers(self, point: FloatArray) -> dict[str, float]:
        """The gains at a point (n,) of the cube, by path."""
        pairs = zip(self.ranges.items(), point, strict=True)
        return {path: own.number(float(share)) for (path, own), share in pairs}
