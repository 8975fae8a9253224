"""What a walk is told to do in a step, within what its feet can do."""

from __future__ import annotations

import math

import numpy as np

from warp_softbody.controllers.motions.moving_frame import MovingFrame, Rates
from warp_softbody.controllers.motions.steering import (
    Guide,
    Steering,
    SteeringShares,
    Trail,
    TrailFollower,
    told,
)
from warp_softbody.errors import InputError
from warp_softbody.world.view import BodyView


class Feet:
    """How far and how fast the feet of a gait go, in SI units.

    Attributes:
        length: L, m, of the body.
        reach: m, from the middle to the farthest foot.
        cycle: s, in which every foot is moved once.
        usual: m/s, the speed for which the gains are made.
        most: m/s, the largest mean speed of a foot over the ground.
        hastening: by how much each rate changes in a second at most: to the usual one in a cycle.
    """

    def __init__(
        self, *, length: float, reach: float, cycle: float, stride: float, most_stride: float
    ) -> None:
        """Strides, m, are what the body goes on in a cycle, as usual and at most."""
        self.length, self.reach, self.cycle = length, reach, cycle
        self.usual = stride / cycle
        self.most = max(most_stride, abs(stride)) / cycle
        speed = max(abs(self.usual), 0.1 * length / cycle)
        self.hastening = Rates(speed, speed, speed / reach).times(1.0 / cycle)

    def speed(self, rates: Rates) -> float:
        """The largest mean speed over the ground, m/s, of a foot."""
        return math.hypot(rates.forward, rates.aside) + self.reach * abs(rates.turning)


class Guidance:
    """Asks a guide in every step; for one run."""

    def __init__(self, guide: Guide | None, feet: Feet, heading: float) -> None:
        """``heading`` is in rad, of what is forward in the frame."""
        self._feet, self._heading = feet, heading
        self._drift = np.zeros(2)
        self.follow(guide)

    def follow(self, guide: Guide | None) -> None:
        """Ask this guide from now on.

        Raises:
            InputError: it asks for more than the feet can do.
        """
        for known in guide if isinstance(guide, tuple) else (guide,):
            if isinstance(known, Steering):
                self._possible(known)
            elif isinstance(known, Trail):
                self._possible(Steering(forward=known.forward))
        self._guide = guide
        trail = guide if isinstance(guide, Trail) else None
        self._follower = None if trail is None else TrailFollower(trail, self._feet.length)

    @property
    def arrived(self) -> bool:
        """Whether a trail was followed to its end."""
        return self._follower is not None and self._follower.arrived

    def rates(self, view: BodyView, frame: MovingFrame) -> Rates:
        """What is wanted of the step from ``view`` on, in which the frame is there.

        Raises:
            InputError: it is more than the feet can do.
        """
        # the body sways within a cycle; what is behind that is learnt
        share = min(1.0, view.time_step / self._feet.cycle)
        self._drift += share * (view.center_of_mass[:2] - frame.place - self._drift)
        if isinstance(self._guide, SteeringShares):
            return self._shared(self._guide)
        if self._follower is None:
            return self._possible(told(self._guide, view))
        assert isinstance(self._guide, Trail)
        forward = self._guide.forward
        speed = self._possible(Steering(forward=forward)).forward
        yaw = frame.yaw + self._heading
        asked = self._follower.steering(frame.place + self._drift, yaw, speed)
        return self._within(Rates(asked.forward or 0.0, asked.aside, asked.turning))

    def _shared(self, asked: SteeringShares) -> Rates:
        most = self._feet.most
        turning = asked.turning * most / self._feet.reach
        return self._within(Rates(asked.forward * most, asked.aside * most, turning))

    def _within(self, rates: Rates) -> Rates:
        """Rates, or what the feet can do of them in the same proportions."""
        speed = self._feet.speed(rates)
        return rates if speed <= self._feet.most else rates.times(self._feet.most / speed)

    def _possible(self, asked: Steering) -> Rates:
        feet = self._feet
        forward = asked.forward
        if forward is None:
            room = feet.most - feet.reach * abs(asked.turning)
            left = math.sqrt(max(0.0, room * abs(room) - asked.aside**2))
            forward = math.copysign(min(abs(feet.usual), left), feet.usual)
        rates = Rates(forward, asked.aside, asked.turning)
        speed = feet.speed(rates)
        if speed > feet.most * (1.0 + 1e-9):
            raise InputError(
                f"this walk moves its feet by at most {feet.most:.3g} m/s, but it is steered at "
                f"{forward:.3g} m/s forward, {asked.aside:.3g} m/s aside and {asked.turning:.3g} "
                f"rad/s, which takes {speed:.3g} m/s"
            )
        return rates
