"""Gains, weights and timing of cartwheels (docs/method.md section 4)."""

from __future__ import annotations

from dataclasses import dataclass, field

from warp_softbody.controllers.body_units import dimension
from warp_softbody.controllers.controller import ActivationCost
from warp_softbody.inputs import checks


@dataclass(frozen=True, kw_only=True)
class CartwheelGains:
    """Gains, weights and timing of a cartwheel along x, in units of the body (`BodyUnits`).

    Attributes:
        cruise: sqrt(g/L), at which the plan turns, rad in that time.
        speedup: g/L, with which the plan's speed comes up and falls again.
        lead: rad, by which the plan may be ahead of the body; it waits for one that is late.
        height: of the centre of mass as it turns, over that with which it began. Less than one:
            fibres only shorten, so that a body has something to rise with.
        position: Kp, g/L, of the centre of mass on its path.
        velocity: Kd, sqrt(g/L), of the same.
        turn: g/L, how strongly the body is turned to the plan's angle, and back where it tips.
        spin: sqrt(g/L), how fast angular momentum comes to the plan's.
        learning: sqrt(L/g), within which it is learnt what momentum a plan misses.
        momentum_weight: of the linear momentum, in units of m g dt.
        spin_weight: of the angular momentum, in units of m g L dt.
        limb_rate: sqrt(g/L), how fast feet come to their places on the turned body.
        limb_weight: of that velocity, in units of g dt.
        rest_time: sqrt(L/g), that it stands until it has finished.
        activation: cost of effort and change.
    """

    cruise: float = field(default=0.6, metadata=dimension(time=-1.0))
    speedup: float = field(default=0.2, metadata=dimension(time=-2.0))
    lead: float = 0.5
    height: float = 0.96
    position: float = field(default=8.0, metadata=dimension(time=-2.0))
    velocity: float = field(default=5.0, metadata=dimension(time=-1.0))
    turn: float = field(default=12.0, metadata=dimension(time=-2.0))
    spin: float = field(default=5.0, metadata=dimension(time=-1.0))
    learning: float = field(default=0.6, metadata=dimension(time=1.0))
    momentum_weight: float = 0.3
    spin_weight: float = 3.0
    limb_rate: float = field(default=4.0, metadata=dimension(time=-1.0))
    limb_weight: float = 0.001
    rest_time: float = field(default=3.0, metadata=dimension(time=1.0))
    activation: ActivationCost = field(
        default_factory=lambda: ActivationCost(effort=0.05, change=0.06)
    )

    def __post_init__(self) -> None:
        """Refuse gains that are not finite or out of their range."""
        checks.settle(
            self,
            positive=("cruise", "speedup", "lead", "height"),
            not_negative=(
                *("position", "velocity", "turn", "spin", "learning"),
                *("momentum_weight", "spin_weight", "limb_rate", "limb_weight", "rest_time"),
            ),
        )
        checks.instance("CartwheelGains.activation", self.activation, ActivationCost)
