"""Gains, weights and timing of walking (docs/method.md section 4)."""

from __future__ import annotations

from dataclasses import dataclass, field

from warp_softbody.controllers.body_units import dimension
from warp_softbody.controllers.controller import ActivationCost
from warp_softbody.inputs import checks


@dataclass(frozen=True, kw_only=True)
class WalkGains:
    """Gains, weights and timing of walking along x, in units of the body (`BodyUnits`).

    Attributes:
        stride: L, that the body goes on while every foot is swung once.
        swing: sqrt(L/g), from one lift-off to the next.
        lift: L, height of a swung foot's lowest node halfway.
        touch_down: share of the swing in which the plan counts on the ground below the foot again.
        sway: how far the centre of mass is moved away from the feet that are about to lift off, as
            a share of its distance from their middle.
        leash: L, how far the plan may run ahead of the body.
        position: Kp, g/L, of the centre of mass.
        velocity: Kd, sqrt(g/L), of the same.
        turn: g/L, how strongly the body is brought back to the orientation that it had at rest,
            but for the yaw of the plan; a walk that is to turn needs some.
        spin: sqrt(g/L), decay of angular momentum.
        learning: sqrt(L/g), within which it is learnt what momentum a plan misses.
        momentum_weight: of the linear momentum, in units of m g dt.
        spin_weight: of the angular momentum, in units of m g L dt.
        foot_position: sqrt(g/L), how fast a foot comes back to its path.
        foot_velocity: sqrt(g/L), how fast its velocity comes near the one that is wanted.
        foot_weight: in units of g dt, of a swung foot's velocity, and along z of that of one that
            stands, so that it stays down.
        activation: cost of effort and change.
        ease: by how much more than one a change costs at lift-off, as a factor, so that the other
            feet take over the load in several steps.
        ease_time: share of the swing after which it costs as usual.
    """

    stride: float = field(default=0.34, metadata=dimension(length=1.0))
    swing: float = field(default=2.004, metadata=dimension(time=1.0))
    lift: float = field(default=0.045, metadata=dimension(length=1.0))
    touch_down: float = 0.25
    sway: float = 0.22
    leash: float = field(default=0.25, metadata=dimension(length=1.0))
    position: float = field(default=9.174, metadata=dimension(time=-2.0))
    velocity: float = field(default=3.831, metadata=dimension(time=-1.0))
    turn: float = field(default=0.0, metadata=dimension(time=-2.0))
    spin: float = field(default=1.916, metadata=dimension(time=-1.0))
    learning: float = field(default=0.6, metadata=dimension(time=1.0))
    momentum_weight: float = 0.005
    spin_weight: float = 0.06
    foot_position: float = field(default=3.193, metadata=dimension(time=-1.0))
    foot_velocity: float = field(default=9.578, metadata=dimension(time=-1.0))
    foot_weight: float = 0.001
    activation: ActivationCost = field(
        default_factory=lambda: ActivationCost(effort=0.08, change=0.09396)
    )
    ease: float = 9.0
    ease_time: float = 0.25

    def __post_init__(self) -> None:
        """Refuse gains that are not finite or out of their range."""
        checks.settle(
            self,
            positive=("swing",),
            not_negative=(
                *("lift", "touch_down", "leash", "position", "velocity", "turn", "spin"),
                *("learning", "momentum_weight", "spin_weight", "foot_position", "foot_velocity"),
                *("foot_weight", "ease", "ease_time"),
            ),
            finite=("stride", "sway"),
        )
        checks.instance("WalkGains.activation", self.activation, ActivationCost)
