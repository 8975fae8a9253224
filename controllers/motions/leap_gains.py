"""Gains of leaps, in units of the body."""

from __future__ import annotations

from dataclasses import dataclass, field

from warp_softbody.controllers.body_units import dimension
from warp_softbody.controllers.controller import ActivationCost
from warp_softbody.controllers.motions.balance_gains import LETTER, BalanceGains
from warp_softbody.controllers.motions.recovery_gains import RecoveryGains
from warp_softbody.inputs import checks


@dataclass(frozen=True, kw_only=True)
class LeapGains:
    """Gains of leaps of a body that lets itself fall, in units of the body (`BodyUnits`).

    Attributes:
        acceleration: g, of the centre of mass forward that is asked for as the body leans.
        velocity: sqrt(g/L), decay of its momentum upward and aside meanwhile.
        spin: sqrt(g/L), decay of angular momentum meanwhile.
        momentum_weight: of the linear momentum, in units of m g dt.
        spin_weight: of the angular momentum, in units of m g L dt.
        lean: of the way to the edge of the sole, where the capture point is as it bows.
        lean_time: sqrt(L/g), after which it bows at the latest.
        activation: cost of effort and change meanwhile.
        bow: of what draws base and centre of mass together (`gather_...`), until it pushes off; the
            capture point is not to be caught there (`settle` of 0).
        leap: of push and flight.
        landing: of the balance before and after, with the hops that it may take to stop.
        rest_time: sqrt(L/g), for which it stands again, and then has finished.
    """

    acceleration: float = 0.4
    velocity: float = field(default=2.6, metadata=dimension(time=-1.0))
    spin: float = field(default=5.0, metadata=dimension(time=-1.0))
    momentum_weight: float = 1.0
    spin_weight: float = 0.1
    lean: float = 0.5
    lean_time: float = field(default=1.25, metadata=dimension(time=1.0))
    activation: ActivationCost = field(
        default_factory=lambda: ActivationCost(effort=0.1, change=0.028)
    )
    bow: RecoveryGains = field(default_factory=lambda: RecoveryGains(settle=0.0))
    leap: RecoveryGains = field(default_factory=RecoveryGains)
    landing: BalanceGains = field(default_factory=lambda: LETTER)
    rest_time: float = field(default=3.0, metadata=dimension(time=1.0))

    def __post_init__(self) -> None:
        """Refuse gains that are not finite or out of their range."""
        checks.settle(
            self,
            positive=("lean_time",),
            not_negative=(
                *("acceleration", "velocity", "spin", "momentum_weight", "spin_weight"),
                *("lean", "rest_time"),
            ),
        )
        checks.instance("LeapGains.activation", self.activation, ActivationCost)
        checks.instance("LeapGains.bow", self.bow, RecoveryGains)
        checks.instance("LeapGains.leap", self.leap, RecoveryGains)
        checks.instance("LeapGains.landing", self.landing, BalanceGains)
