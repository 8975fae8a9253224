"""The axle of a body that rolls along x: how it leans and heads, and how it is steered.

A wheel that stands is held by what sticks below it; one that rolls puts down a new rim all the
time, so that a small lean grows. Turned into the lean, its contact comes below it again, as a
bicycle's does (Meijaard et al., Proc. R. Soc. A 463, 2007).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.body_units import BodyUnits
from warp_softbody.controllers.motions.roll_gains import RollGains
from warp_softbody.controllers.objectives import Objective
from warp_softbody.world.view import BodyView

FULL = 0.2
"""sqrt(g/L), of rolling, from which on it is steered in full: one that stands goes nowhere."""

MOST_TURNING = 2.0
"""sqrt(g/L), that is asked for."""


class Axle(NamedTuple):
    """The direction that was y at rest, as a mean over the whole body.

    Attributes:
        heading: rad, of the way ahead, from x towards y.
        lean: rad, of the top towards y.
        turning: rad/s, rate of the heading.
        leaning: rad/s, rate of the lean.
        shares: (n,) 1/m, with which nodes count: the mean of their places by them is the axle.
    """

    heading: float
    lean: float
    turning: float
    leaning: float
    shares: FloatArray

    @classmethod
    def of(cls, view: BodyView) -> Axle:
        """That of a body that leans and heads off by little."""
        shares = view.kept("shares of the axle", lambda: _shares(view))
        axle, rate = shares @ view.positions, shares @ view.velocities
        return cls(-float(axle[0]), -float(axle[2]), -float(rate[0]), -float(rate[2]), shares)

    def steering(self, gains: RollGains, speed: float, units: BodyUnits) -> float:
        """Rate of the heading, rad/s, that brings the contact below a lean, and the way back to x.

        To head back it has to lean first, and so is steered away from there.

        Args:
            gains: in SI.
            speed: of rolling, rad/s; negative against x.
            units: of the body.
        """
        along = float(np.clip(speed * units.time / FULL, -1.0, 1.0))
        off = self.lean + along * gains.course * self.heading
        wanted = along * (gains.steer * off + gains.steer_rate * self.leaning)
        most = MOST_TURNING / units.time
        return float(np.clip(wanted, -most, most))

    def objective(self, view: BodyView, gains: RollGains, speed: float) -> Objective:
        """``|rate - rate*|^2`` of heading and lean, over sqrt(g / L); gains are in SI."""
        units = BodyUnits.of(view)
        wanted = self.steering(gains, speed, units)
        turning = self.turning + view.horizon * gains.steer_follow * (wanted - self.turning)
        righted = gains.lean * self.lean + gains.lean_decay * self.leaning
        rows = np.zeros((2, view.node_count, 3))
        rows[0, :, 0], rows[1, :, 2] = -self.shares, -self.shares
        target = np.array([turning, self.leaning - view.horizon * righted])
        return Objective(
            name="axle",
            rows=units.time * rows.reshape(2, -1),
            target=units.time * target,
            weight=np.array([gains.steer_weight, gains.lean_weight]) / view.horizon,
        )


def _shares(view: BodyView) -> FloatArray:
    across = view.scene.character.mesh.points[:, 1]
    masses = view.masses[: len(across)]
    loads = masses * (across - masses @ across / masses.sum())
    shares = np.zeros(view.node_count)
    shares[: len(across)] = loads / (loads @ across)
    return shares
