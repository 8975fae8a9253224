"""The take-off of a somersault, and gains of its flight and landing (docs/method.md section 4)."""

from __future__ import annotations

from dataclasses import dataclass, field

from warp_softbody.controllers.body_units import dimension
from warp_softbody.controllers.controller import ActivationCost
from warp_softbody.controllers.motions.balance_gains import BalanceGains
from warp_softbody.inputs import checks

Levels = tuple[float, float, float, float]


@dataclass(frozen=True, kw_only=True)
class TakeOff:
    """Activations with which a body crouches and lets go, by quarters of its muscles.

    Quarters are those behind (x below the centre of mass at rest) and ahead of it, each below and
    above it. Activations go evenly from slack to the first levels and from these to the next;
    after the last all muscles are slack.

    Attributes:
        crouch: sqrt(L/g), in which the first levels are reached.
        interval: sqrt(L/g), from each of the others to the next.
        levels: activations of the quarters: behind below, behind above, ahead below, ahead above.
        weight: of a change against these, in sqrt(L/g).
    """

    crouch: float = field(default=2.0, metadata=dimension(time=1.0))
    interval: float = field(default=0.075, metadata=dimension(time=1.0))
    levels: tuple[Levels, ...] = ((0.5, 0.5, 0.7, 0.5), (0.55, 0.7, 0.5, 0.5))
    weight: float = 5.0

    def __post_init__(self) -> None:
        """Refuse times that are not positive, and levels that no muscle has."""
        checks.settle(self, positive=("crouch", "interval", "weight"))
        wanted = "tuples of four activations"
        rows = checks.several("TakeOff.levels", self.levels, wanted)
        levels = [checks.vector("one of TakeOff.levels", row, 4) for row in rows]
        if not levels or not all(0.5 <= level <= 1.0 for row in levels for level in row):
            checks.refuse("TakeOff.levels", f"{wanted} from 0.5 to 1", self.levels)
        checks.keep(self, levels=tuple(levels))

    @property
    def lasts(self) -> float:
        """Time from its beginning to the last levels."""
        return self.crouch + self.interval * (len(self.levels) - 1)


@dataclass(frozen=True, kw_only=True)
class FlipGains:
    """Gains, weights and timing of a somersault about y, in units of the body (`BodyUnits`).

    Attributes:
        lean: rad, by which the body is to lean back when it touches the ground again.
        landing_height: L, of the centre of mass then.
        open: sqrt(L/g), before that, in which the body is to be long again.
        least_length: of the tucked body, over its length at rest.
        tuck_rate: sqrt(g/L), how fast the body comes to the length that is wanted.
        tuck_weight: of the rate of its length, in units of sqrt(g L).
        straight_weight: of that of its bend, likewise.
        longest: sqrt(L/g), after the take-off's last levels, in which it has to be in the air; or
            the flip counts as failed and the body balances.
        arrest_time: sqrt(L/g), after touching the ground, in which momenta are braked at least.
        upright: rad, tilt from which on the body is left to the balance. A landing that fast takes
            more or less of the spin, and the body may come off the ground once more; leaning as
            it then does it cannot be balanced, but it can still be turned upright.
        longest_arrest: sqrt(L/g), in which it has to come that far upright, or balances as it is.
        height: L, of the centre of mass over the base that is wanted then.
        position: g/L, of that place.
        velocity: sqrt(g/L), decay of linear momentum.
        righting_velocity: the same from `arrest_time` on, when there is no fall left to be stopped
            and a plan of one step that stops every motion shakes the body.
        turn: g/L, with which the body is turned upright.
        spin: sqrt(g/L), decay of angular momentum.
        momentum_weight: of the linear momentum, in units of m g dt.
        spin_weight: of the angular momentum, in units of m g L dt.
        rest_time: sqrt(L/g), that it stands until it has finished.
        air: cost of effort and change in the air.
        arrest: the same while momenta are braked.
        righting: the same from `arrest_time` on.
        landing: gains of the balance before and after it.
    """

    lean: float = 1.0
    landing_height: float = field(default=0.38, metadata=dimension(length=1.0))
    open: float = field(default=0.17, metadata=dimension(time=1.0))
    least_length: float = 0.56
    tuck_rate: float = field(default=6.5, metadata=dimension(time=-1.0))
    tuck_weight: float = 1.0
    straight_weight: float = 0.3
    longest: float = field(default=1.0, metadata=dimension(time=1.0))
    arrest_time: float = field(default=0.3, metadata=dimension(time=1.0))
    upright: float = 0.12
    longest_arrest: float = field(default=4.7, metadata=dimension(time=1.0))
    height: float = field(default=0.35, metadata=dimension(length=1.0))
    position: float = field(default=4.6, metadata=dimension(time=-2.0))
    velocity: float = field(default=14.0, metadata=dimension(time=-1.0))
    righting_velocity: float = field(default=2.07, metadata=dimension(time=-1.0))
    turn: float = field(default=4.6, metadata=dimension(time=-2.0))
    spin: float = field(default=4.1, metadata=dimension(time=-1.0))
    momentum_weight: float = 0.037
    spin_weight: float = 22.0
    rest_time: float = field(default=3.0, metadata=dimension(time=1.0))
    air: ActivationCost = field(default_factory=lambda: ActivationCost(effort=0.005, change=0.005))
    arrest: ActivationCost = field(default_factory=lambda: ActivationCost(effort=0.02, change=0.14))
    righting: ActivationCost = field(default_factory=lambda: ActivationCost(effort=0.1, change=0.5))
    landing: BalanceGains = field(default_factory=BalanceGains)

    def __post_init__(self) -> None:
        """Refuse gains that are not finite or out of their range."""
        checks.settle(
            self,
            positive=("landing_height", "least_length", "height"),
            not_negative=(
                *("open", "tuck_rate", "tuck_weight", "straight_weight", "longest"),
                *("arrest_time", "upright", "longest_arrest"),
                *("position", "velocity", "righting_velocity", "turn", "spin"),
                *("momentum_weight", "spin_weight", "rest_time"),
            ),
            finite=("lean",),
        )
        for name in ("air", "arrest", "righting"):
            checks.instance(f"FlipGains.{name}", getattr(self, name), ActivationCost)
        checks.instance("FlipGains.landing", self.landing, BalanceGains)
