"""Where a walk is to go: speeds that may change with time, a trail of points, or a function.

Speeds are those of the plan, in the directions of the body: `forward` is the heading of the walk,
which turns with the body, `aside` is to its left.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.errors import InputError
from warp_softbody.inputs import array_checks, checks
from warp_softbody.inputs.records import Value
from warp_softbody.world.view import BodyView

LOOK_AHEAD = 0.3
"""L, along a trail from the body to the point it turns to. Nearer ones are overshot, since a foot
that is in the air comes down where it was to; farther ones cut corners."""

ARRIVED = 0.02
"""L before the end of a trail at which the body stops."""


@dataclass(frozen=True, kw_only=True)
class Steering:
    """How fast to go which way, from some time on.

    Attributes:
        forward: m/s; None is the speed for which the gains are made, or what going aside and
            turning leave of it.
        aside: m/s, to the left.
        turning: rad/s about the vertical, to the left.
        start: s, from which on this holds.
    """

    forward: float | None = None
    aside: float = 0.0
    turning: float = 0.0
    start: float = 0.0

    def __post_init__(self) -> None:
        """Refuse what is not finite."""
        checks.settle(self, not_negative=("start",), finite=("aside", "turning"))
        if self.forward is not None:
            forward = checks.number("Steering.forward", self.forward, unit="m/s")
            checks.keep(self, forward=forward)


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Trail(Value):
    """Points to go through one after the other, and a speed.

    The body turns to a point of the trail some way ahead of it, on the circle through both (pure
    pursuit; Coulter, Implementation of the pure pursuit path tracking algorithm, 1992).

    Attributes:
        points: (k, 2) m, x and y; the body stops at the last.
        forward: m/s; None is the speed for which the gains are made.
    """

    points: FloatArray
    forward: float | None = None

    def __post_init__(self) -> None:
        """Refuse trails without a length."""
        points = array_checks.array("Trail.points", self.points, (None, 2))
        if len(points) < 2:
            raise InputError(f"Trail.points must be two points or more, got {len(points)}")
        ways = np.hypot(*np.diff(points, axis=0).T)
        if not ways.all():
            again = int(np.argmin(ways))
            raise InputError(f"Trail.points[{again}] and [{again + 1}] are the same point")
        checks.keep(self, points=points)
        if self.forward is not None:
            forward = checks.number("Trail.forward", self.forward, above=0.0, unit="m/s")
            checks.keep(self, forward=forward)

    @cached_property
    def _arcs(self) -> FloatArray:
        """Way (k,) m along the trail to each point."""
        ways = np.hypot(*np.diff(self.points, axis=0).T)
        return np.concatenate([[0.0], np.cumsum(ways)])

    @property
    def length(self) -> float:
        """Of the whole trail, m."""
        return float(self._arcs[-1])

    def point(self, arc: float) -> FloatArray:
        """The point (2,) m after a way along the trail, m; beyond its end straight on."""
        inner = [float(np.interp(arc, self._arcs, self.points[:, axis])) for axis in (0, 1)]
        last = (self.points[-1] - self.points[-2]) / (self._arcs[-1] - self._arcs[-2])
        return np.asarray(np.array(inner) + max(0.0, arc - self.length) * last)

    def nearest(self, place: FloatArray, low: float, high: float) -> float:
        """The way along the trail, m, between two ways, at which it comes nearest to a place."""
        arcs, (x, y) = self._arcs, self.points.T
        lengths, across, up = np.diff(arcs), np.diff(x), np.diff(y)
        along = ((place[0] - x[:-1]) * across + (place[1] - y[:-1]) * up) / lengths
        along = arcs[:-1] + np.minimum(np.maximum(along, 0.0), lengths)
        along = np.minimum(np.maximum(along, low), min(high, self.length))
        far = np.hypot(np.interp(along, arcs, x) - place[0], np.interp(along, arcs, y) - place[1])
        return float(along[int(np.argmin(far))])


@dataclass(frozen=True, kw_only=True)
class SteeringShares:
    """How fast to go which way, of what the feet can do: 1 is as fast as they can, -1 backwards.

    What is too much together is made less in the same proportions.
    """

    forward: float = 0.0
    aside: float = 0.0
    turning: float = 0.0

    def __post_init__(self) -> None:
        """Refuse shares beyond one."""
        for name in ("forward", "aside", "turning"):
            share = checks.number(f"{name} of a steering", getattr(self, name), low=-1.0, high=1.0)
            checks.keep(self, **{name: share})


Guide = SteeringShares | Steering | tuple[Steering, ...] | Trail | Callable[[BodyView], Steering]
"""What tells where to go; a function is asked in every step."""


def checked_guide(label: str, value: object) -> Guide:
    """A guide that was given as an argument."""
    wanted = "a Steering, several of them, a Trail or a function of the view"
    if isinstance(value, Steering | SteeringShares | Trail):
        return value
    if callable(value):
        return checks.called_with(label, value, 1, wanted)
    if isinstance(value, (str, bytes)):
        checks.refuse(label, wanted, value)
    found = checks.items(label, checks.several(label, value, wanted), Steering)
    if not found:
        checks.refuse(label, wanted, value)
    for i, (before, after) in enumerate(itertools.pairwise(found)):
        if after.start <= before.start:
            raise InputError(
                f"{label}[{i + 1}].start must be after the {before.start:g} s of the one before, "
                f"got {after.start:g} s"
            )
    return found


def told(guide: Guide | None, view: BodyView) -> Steering:
    """What a guide that is no trail says of the step from ``view`` on; without one: straight on."""
    if callable(guide):
        found = guide(view)
        if not isinstance(found, Steering):
            raise InputError(f"a steering function must give a Steering, not {checks.shown(found)}")
        return found
    if isinstance(guide, tuple):
        begun = [each for each in guide if each.start <= view.time + 1e-9]
        return begun[-1] if begun else Steering(forward=0.0)
    return guide if isinstance(guide, Steering) else Steering()


class TrailFollower:
    """Follows a trail; for one run.

    Attributes:
        arrived: whether it has come to the last point.
    """

    def __init__(self, trail: Trail, length: float) -> None:
        """``length`` is L, m, of the body."""
        self._trail = trail
        self._ahead, self._near = LOOK_AHEAD * length, ARRIVED * length
        self._arc = 0.0
        self.arrived = False

    def steering(self, place: FloatArray, yaw: float, speed: float) -> Steering:
        """How to go on from a place (2,) m, facing a direction, rad, at a speed, m/s."""
        self._arc = self._trail.nearest(place, self._arc, self._arc + 2.0 * self._ahead)
        left = self._trail.length - self._arc
        if left < self._near:
            self.arrived = True
            return Steering(forward=0.0)
        to = self._trail.point(self._arc + self._ahead) - place
        far = max(math.hypot(*to), self._near)
        aside = math.remainder(math.atan2(to[1], to[0]) - yaw, math.tau)
        # what lies behind is first turned to
        forward = speed * max(0.0, math.cos(aside)) * min(1.0, left / self._ahead)
        turning = 2.0 * speed * math.sin(aside) / far
        if abs(aside) > math.pi / 2.0:
            turning = math.copysign(2.0 * speed / far, aside)
        return Steering(forward=forward, turning=turning)
