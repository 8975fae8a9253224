"""Gains with which a body that cannot stay on its base leaves it, in units of the body."""

from __future__ import annotations

from dataclasses import dataclass, field

from warp_softbody.controllers.body_units import dimension
from warp_softbody.controllers.controller import ActivationCost
from warp_softbody.inputs import checks


@dataclass(frozen=True, kw_only=True)
class RecoveryGains:
    """Gains of hops after a push, in units of the body (`BodyUnits`).

    The defaults are those of the letter that balances, found by evolution (CMA-ES): how far over it
    still was, 0.5 s after the start of pushes of 0.75 and 0.8 body weights, of 0.7 at twice the
    step, and of 0.72 with two iterations.

    Attributes:
        leave: of the way to the edge of the sole, how far the capture point is to be carried, so
            that the body leaves its base; 0: it never does.
        expect: sqrt(L/g), for which a push is taken to last.
        still: sqrt(L/g), for which it is taken to go on at least.
        start: of the way to the edge, where the capture point is when recovery begins.
        settle: of the way to the edge, within which the capture point is caught, so that the body
            stays where it lands.
        brace: sqrt(L/g), for which it leans on its edge before it draws its base up.
        gather_time: sqrt(L/g), for which it draws the base up at least.
        gather_height: L, of the centre of mass over the base that it draws up.
        gather_ahead: of the capture point's way from the centre of mass, how far ahead the base is
            drawn.
        gather_tilt: rad, by which the base is raised towards that side.
        height: L, of the centre of mass over the base at landing.
        ahead: of the capture point's way from the centre of mass, how far ahead it lands.
        further: L, how much further, there and before.
        tilt: rad, by which the base is raised at landing.
        reach_rate: sqrt(g/L), how fast the base comes to its place.
        reach_weight: of that velocity, in units of sqrt(g L).
        level_weight: of the heights of its parts, over `reach_weight`.
        rise: sqrt(g L), wanted velocity upward at take-off.
        keep: share of the velocity along the ground that is to be left.
        spin: sqrt(g/L), at which the body is to turn back at take-off, at most.
        push: sqrt(g/L), how fast linear momentum comes to what is wanted.
        push_spin: sqrt(g/L), the same of angular momentum.
        push_time: sqrt(L/g), longest push.
        fly_time: sqrt(L/g), longest flight.
        rise_weight: of the linear momentum upward, in units of m g dt.
        way_weight: of that along the ground.
        spin_weight: of the angular momentum, in units of m g L dt.
        lean: L, by which the head is to lean back over the base in a push.
        lean_rate: sqrt(g/L), how fast.
        lean_weight: of that velocity, in units of g dt.
        activation: cost of effort and change meanwhile.
    """

    leave: float = 0.0
    expect: float = field(default=0.63, metadata=dimension(time=1.0))
    still: float = field(default=0.16, metadata=dimension(time=1.0))
    start: float = 0.155
    settle: float = 1.02
    brace: float = field(default=0.13, metadata=dimension(time=1.0))
    gather_time: float = field(default=0.133, metadata=dimension(time=1.0))
    gather_height: float = field(default=0.388, metadata=dimension(length=1.0))
    gather_ahead: float = 1.33
    gather_tilt: float = -0.299
    height: float = field(default=0.407, metadata=dimension(length=1.0))
    ahead: float = 0.64
    further: float = field(default=-0.0177, metadata=dimension(length=1.0))
    tilt: float = 0.178
    reach_rate: float = field(default=6.2, metadata=dimension(time=-1.0))
    reach_weight: float = 21.9
    level_weight: float = 0.89
    rise: float = field(default=0.402, metadata=dimension(length=1.0, time=-1.0))
    keep: float = 0.707
    spin: float = field(default=0.88, metadata=dimension(time=-1.0))
    push: float = field(default=14.1, metadata=dimension(time=-1.0))
    push_spin: float = field(default=15.1, metadata=dimension(time=-1.0))
    push_time: float = field(default=0.261, metadata=dimension(time=1.0))
    fly_time: float = field(default=0.841, metadata=dimension(time=1.0))
    rise_weight: float = 1.23
    way_weight: float = 0.004
    spin_weight: float = 29.3
    lean: float = field(default=0.474, metadata=dimension(length=1.0))
    lean_rate: float = field(default=3.94, metadata=dimension(time=-1.0))
    lean_weight: float = 0.0325
    activation: ActivationCost = field(
        default_factory=lambda: ActivationCost(effort=0.0711, change=0.0351)
    )

    def __post_init__(self) -> None:
        """Refuse gains that are not finite or out of their range."""
        checks.settle(
            self,
            positive=("gather_height", "height", "push_time", "fly_time"),
            not_negative=(
                *("leave", "expect", "still", "start", "settle", "brace", "gather_time"),
                *("reach_rate", "reach_weight", "level_weight", "rise", "spin", "push"),
                *("push_spin", "rise_weight", "way_weight", "spin_weight", "lean_rate"),
                "lean_weight",
            ),
            finite=("gather_ahead", "gather_tilt", "ahead", "further", "tilt", "keep", "lean"),
        )
        checks.instance("RecoveryGains.activation", self.activation, ActivationCost)
