"""What pushes a body from outside, as it can tell from its own momentum and from the ground."""

from __future__ import annotations

import math

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.world.view import BodyView

LEAST_PUSH = 0.05
"""g, of an acceleration along the ground that counts as a push."""


class OuterPush:
    """The part of the change of momentum that the ground's impulses do not account for.

    Muscles and elasticity change no momentum, so what is left is what somebody else did.

    Attributes:
        acceleration: (2,) m/s^2 along the ground, mean of the last step; zero where it is small.
        lasted: s, since such a push began; 0 without one.
    """

    def __init__(self) -> None:
        """One that has seen nothing."""
        self.acceleration = np.zeros(2)
        self.lasted = 0.0
        self._before: tuple[float, FloatArray] | None = None

    def see(self, view: BodyView) -> None:
        """Take the next step of a run into account.

        Views that do not follow one another by a step, or without the ground's impulses, tell
        nothing.
        """
        before, momentum = self._before, view.linear_momentum[:2]
        self._before = view.time, momentum
        self.acceleration = np.zeros(2)
        follows = before is not None and abs(view.time - before[0] - view.time_step) < (
            0.5 * view.time_step
        )
        if before is None or not follows or not len(view.impulses):
            self.lasted = 0.0
            return
        given = momentum - before[1] - view.impulses.sum(axis=0)[:2]
        found = given / (view.mass * view.time_step)
        if math.hypot(*found) <= LEAST_PUSH * view.gravity:
            self.lasted = 0.0
            return
        self.acceleration = found
        self.lasted += view.time_step

    def carried(self, way: FloatArray, speed: FloatArray, fall: float, lasts: float) -> FloatArray:
        """Where (2,) m the capture point will be once the push is over.

        Args:
            way: (2,) m, of the capture point from the middle of the base now.
            speed: (2,) m/s, of the centre of mass.
            fall: s, sqrt(h / g).
            lasts: s, for which the push goes on.
        """
        a = self.acceleration
        return np.asarray(way + lasts * (speed + fall * a) + 0.5 * lasts**2 * a)
