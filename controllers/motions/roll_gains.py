"""What is asked of a body that rolls: gains, weights and the legs of its way."""

from __future__ import annotations

from dataclasses import dataclass, field

from warp_softbody.controllers.body_units import dimension
from warp_softbody.controllers.controller import ActivationCost
from warp_softbody.inputs import checks


@dataclass(frozen=True, kw_only=True)
class RollGains:
    """Gains and weights of rolling along x, in units of the body (`BodyUnits`).

    Attributes:
        cruise: sqrt(g/L), greatest speed of rolling that is wanted.
        speedup: g/L, with which that speed comes up.
        brake: g/L, with which it falls towards the end of a leg.
        closing: sqrt(g/L), how fast the last bit of the way decays.
        follow: sqrt(g/L), how fast a speed that is off is to come back.
        acceleration: g/L, greatest acceleration that is asked for, either way.
        tilt_gain: tilt of the body over the one that turns a rigid ellipse so fast.
        shape_follow: sqrt(g/L), how fast tilt and squash are to come.
        steadiness: sqrt(g/L), decay of the momenta that do not belong to rolling.
        hold: sqrt(L/g), for which the body has to be still at the end of a leg.
        release: sqrt(L/g), time constant in which muscles let go after the last leg.
        roll_weight: of the momentum of rolling about the contact, in units of m g L dt.
        steady_weight: of the momenta that do not belong to rolling, in units of m g dt and m g L
            dt.
        tilt_weight: sqrt(L/g), of the tilt's rate over sqrt(g/L); it is divided by the time step.
        squash_weight: sqrt(L/g), of the squash's, likewise.
        steer: sqrt(g/L), turning of the heading for each rad of lean, into it.
        steer_rate: turning for each rad/s of leaning.
        course: rad of lean for each rad that the heading is off, with which it comes back.
        steer_follow: sqrt(g/L), how fast the turning is to come.
        lean: g/L, with which the lean itself is to come back.
        lean_decay: sqrt(g/L), decay of leaning.
        steer_weight: sqrt(L/g), of the turning over sqrt(g/L); 0 does not steer, and asks all
            momenta across to decay; where it steers, only those that it does not need.
        lean_weight: sqrt(L/g), of the leaning over sqrt(g/L).
        activation: cost of effort and change. Without much effort a body whose plan has no better
            answer draws all of itself together, and stays so.
    """

    cruise: float = field(default=0.41, metadata=dimension(time=-1.0))
    speedup: float = field(default=0.08, metadata=dimension(time=-2.0))
    brake: float = field(default=0.056, metadata=dimension(time=-2.0))
    closing: float = field(default=1.1, metadata=dimension(time=-1.0))
    follow: float = field(default=0.96, metadata=dimension(time=-1.0))
    acceleration: float = field(default=0.1, metadata=dimension(time=-2.0))
    tilt_gain: float = 2.0
    shape_follow: float = field(default=2.5, metadata=dimension(time=-1.0))
    steadiness: float = field(default=1.6, metadata=dimension(time=-1.0))
    hold: float = field(default=1.0, metadata=dimension(time=1.0))
    release: float = field(default=0.94, metadata=dimension(time=1.0))
    roll_weight: float = 2.0
    steady_weight: float = 0.03
    tilt_weight: float = field(default=0.08, metadata=dimension(time=1.0))
    squash_weight: float = field(default=0.1, metadata=dimension(time=1.0))
    steer: float = field(default=0.0, metadata=dimension(time=-1.0))
    steer_rate: float = 0.0
    course: float = 0.0
    steer_follow: float = field(default=0.0, metadata=dimension(time=-1.0))
    lean: float = field(default=0.0, metadata=dimension(time=-2.0))
    lean_decay: float = field(default=0.0, metadata=dimension(time=-1.0))
    steer_weight: float = field(default=0.0, metadata=dimension(time=1.0))
    lean_weight: float = field(default=0.0, metadata=dimension(time=1.0))
    activation: ActivationCost = field(
        default_factory=lambda: ActivationCost(effort=0.8, change=1.5)
    )

    def __post_init__(self) -> None:
        """Refuse gains that are not finite or out of their range."""
        checks.settle(
            self,
            positive=("cruise", "speedup", "brake", "closing", "follow", "acceleration"),
            not_negative=(
                *("tilt_gain", "shape_follow", "steadiness", "hold", "release"),
                *("roll_weight", "steady_weight", "tilt_weight", "squash_weight"),
                *("steer", "steer_rate", "course", "steer_follow"),
                *("lean", "lean_decay", "steer_weight", "lean_weight"),
            ),
        )
        checks.instance("RollGains.activation", self.activation, ActivationCost)


@dataclass(frozen=True, kw_only=True)
class Leg:
    """Rolls one way by an angle, and stops there.

    Attributes:
        direction: +1 or -1, along x.
        turn: rad.
        longest: sqrt(L/g), after which the leg is over even if the body has not got there.
    """

    direction: float
    turn: float
    longest: float = field(default=60.0, metadata=dimension(time=1.0))

    def __post_init__(self) -> None:
        """Refuse a direction other than 1 and -1, and a turn or time that is not positive."""
        checks.settle(self, positive=("turn", "longest"), finite=("direction",))
        if abs(self.direction) != 1.0:
            checks.refuse("Leg.direction", "1 or -1", self.direction)


ANY_BODY = RollGains(
    cruise=0.6,
    tilt_gain=2.4,
    steer=4.1,
    steer_rate=7.9,
    course=0.06,
    steer_follow=5.4,
    lean=2.0,
    lean_decay=0.74,
    steer_weight=0.13,
    lean_weight=0.015,
    activation=ActivationCost(effort=0.1, change=0.2),
)
"""Of a body that has none of its own. Its muscles are weaker than those of the letter that rolls,
so that effort has to count less; and it is narrower, so that it is steered. By a search over three
rings, one of them round in section and the others with flat rims."""
