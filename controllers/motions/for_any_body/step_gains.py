"""Gains of going step by step, in units of the body."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from warp_softbody.controllers.body_units import dimension
from warp_softbody.controllers.controller import ActivationCost
from warp_softbody.inputs import checks


@dataclass(frozen=True, kw_only=True)
class StepGains:
    """Gains, weights and timing of going step by step, in units of the body (`BodyUnits`).

    Attributes:
        stride: L, that the body goes on while every foot is moved once.
        step: sqrt(L/g), from one lift-off to the next.
        stand: share of a step in which the weight is taken off the feet that are to be lifted.
        lift: L, height of a foot's lowest node halfway; 0 for parts that are pushed along.
        touch_down: share of the swing in which the plan counts on the ground below the foot again.
        margin: share by which the area that bears is drawn together, before the centre of mass
            has to be over it.
        capture: by which share of the capture point's drift a foot is set down further on.
        position: Kp, g/L, of the centre of mass.
        velocity: Kd, sqrt(g/L), of the same.
        turn: g/L, how strongly the body is brought back to its first orientation.
        spin: sqrt(g/L), decay of angular momentum.
        momentum_weight: of the linear momentum, in units of m g dt.
        spin_weight: of the angular momentum, in units of m g L dt.
        settle: sqrt(g/L), how fast the plan follows feet that have slipped.
        leash: L, by which feet may be behind the plan before it follows them. What is pushed along
            is always some way behind; a plan that follows it there goes slower than it is asked.
        foot_position: sqrt(g/L), how fast a foot comes back to its path.
        foot_velocity: sqrt(g/L), how fast its velocity comes near the one that is wanted.
        foot_weight: in units of g dt, of a moving foot's velocity, and along z of that of one that
            stands.
        activation: cost of effort and change.
    """

    stride: float = field(default=0.12, metadata=dimension(length=1.0))
    step: float = field(default=0.45, metadata=dimension(time=1.0))
    stand: float = 0.585
    lift: float = field(default=0.013, metadata=dimension(length=1.0))
    touch_down: float = 0.254
    margin: float = 0.436
    capture: float = 1.0
    position: float = field(default=6.08, metadata=dimension(time=-2.0))
    velocity: float = field(default=2.83, metadata=dimension(time=-1.0))
    turn: float = field(default=2.95, metadata=dimension(time=-2.0))
    spin: float = field(default=9.18, metadata=dimension(time=-1.0))
    momentum_weight: float = 0.021
    spin_weight: float = 0.073
    settle: float = field(default=0.35, metadata=dimension(time=-1.0))
    leash: float = field(default=0.0, metadata=dimension(length=1.0))
    foot_position: float = field(default=2.15, metadata=dimension(time=-1.0))
    foot_velocity: float = field(default=5.3, metadata=dimension(time=-1.0))
    foot_weight: float = 0.0007
    activation: ActivationCost = field(
        default_factory=lambda: ActivationCost(effort=0.15, change=0.03)
    )

    def __post_init__(self) -> None:
        """Refuse gains that are not finite or out of their range."""
        checks.settle(
            self,
            positive=("step",),
            not_negative=(
                *("stride", "lift", "touch_down", "capture", "position", "velocity", "turn"),
                *("spin", "momentum_weight", "spin_weight", "settle", "leash", "foot_position"),
                *("foot_velocity", "foot_weight"),
            ),
        )
        for name, high in (("stand", 0.95), ("margin", 1.0)):
            value = checks.number(f"StepGains.{name}", getattr(self, name), low=0.0, high=high)
            checks.keep(self, **{name: value})
        checks.instance("StepGains.activation", self.activation, ActivationCost)


ON_FEET = StepGains()
"""Of a body on four feet or more. By a random search of sixty draws, then by hand, on a table and
two four-legged animals, by the way that they come in eight seconds. Slow steps and long strides
fall over more often than quick and short ones: what falls off two feet is caught by the next."""

ON_THREE_FEET = replace(ON_FEET, stride=0.16, step=0.4, stand=0.0, lift=0.0, capture=0.0)
"""Of a body on three feet, which are pushed along: two that are left would not bear it."""

ON_ONE_SOLE = replace(ON_FEET, stride=0.16, capture=0.0, turn=6.0)
"""Of a body that goes on parts of one sole, which no placing of feet can widen. With longer
strides, or held upright less, it falls over after some ten steps."""

LYING_ON_LIMBS = replace(ON_FEET, stride=0.16, stand=0.0, step=0.3, lift=0.03, momentum_weight=0.16)
"""Of a body that lies on its limbs, and needs no balance: those that stand have to carry it on
against the friction of its belly, and those that swing have to clear what the mesh has of bumps."""

LYING = replace(
    ON_FEET,
    stride=0.16,
    stand=0.0,
    lift=0.0,
    capture=0.0,
    step=0.4,
    leash=0.2,
    momentum_weight=0.06,
)
"""Of a body that lies on all its length."""
