"""Gains, weights and timing of jumps (docs/method.md section 4)."""

from __future__ import annotations

from dataclasses import dataclass, field

from warp_softbody.controllers.body_units import dimension
from warp_softbody.controllers.controller import ActivationCost
from warp_softbody.controllers.motions.balance import BalanceGains
from warp_softbody.inputs import checks

Vector = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class JumpGains:
    """Gains, weights and timing of a jump, in units of the body (`BodyUnits`).

    Attributes:
        depth: L, how far the centre of mass is lowered before the jump.
        wind: rad, by which the body is turned about the vertical meanwhile.
        crouch_time: sqrt(L/g), of the whole way down.
        crouch_share: of that time, after which the body pushes, as it still brakes its fall.
        launch: sqrt(g L), wanted velocity of the centre of mass at take-off, within reach.
        turn: rad, by which the body is to turn about the vertical in the air.
        rise: sqrt(L/g), in which both momenta come up to those of take-off.
        push: sqrt(g/L), how fast linear momentum returns to its course in the push.
        push_spin: sqrt(g/L), the same of angular momentum.
        push_time: sqrt(L/g), longest push; then the jump counts as failed and the body balances.
        position: Kp, g/L, of the centre of mass while crouching.
        velocity: Kd, sqrt(g/L), of the same.
        spin: sqrt(g/L), decay of angular momentum while crouching.
        momentum_weight: of the linear momentum, in units of m g dt.
        spin_weight: of the angular momentum, in units of m g L dt.
        sole_weight: of the sole's velocities along the ground, in units of g dt; 0 leaves them out.
        sole_rate: sqrt(g/L), how fast the sole is to come to rest where it stands.
        way: (x, y) L, how far the base is to land from where the last jump was to end.
        play: L, how far from the capture point the base may land for that.
        height: L, of the centre of mass above the base at landing.
        reach_rate: sqrt(g/L), how fast the base comes to where it is to land.
        reach_weight: of that velocity, in units of sqrt(g L).
        rest_time: sqrt(L/g), between landing and the next jump.
        activation: cost of effort and change while jumping.
        landing: gains of the balance before and after it.
        ease: by how much more than one a change costs at landing, as a factor.
        ease_time: sqrt(L/g), after which it costs as usual.
    """

    depth: float = field(default=0.19, metadata=dimension(length=1.0))
    wind: float = 0.0
    crouch_time: float = field(default=1.9, metadata=dimension(time=1.0))
    crouch_share: float = 1.0
    launch: Vector = field(default=(0.0, 0.0, 0.38), metadata=dimension(length=1.0, time=-1.0))
    turn: float = 0.0
    rise: float = field(default=0.44, metadata=dimension(time=1.0))
    push: float = field(default=9.4, metadata=dimension(time=-1.0))
    push_spin: float = field(default=6.3, metadata=dimension(time=-1.0))
    push_time: float = field(default=1.6, metadata=dimension(time=1.0))
    position: float = field(default=4.6, metadata=dimension(time=-2.0))
    velocity: float = field(default=2.9, metadata=dimension(time=-1.0))
    spin: float = field(default=2.6, metadata=dimension(time=-1.0))
    momentum_weight: float = 1.0
    spin_weight: float = 5.0
    sole_weight: float = 0.0
    sole_rate: float = field(default=12.0, metadata=dimension(time=-1.0))
    way: tuple[float, float] = field(default=(0.0, 0.0), metadata=dimension(length=1.0))
    play: float = field(default=0.06, metadata=dimension(length=1.0))
    height: float = field(default=0.43, metadata=dimension(length=1.0))
    reach_rate: float = field(default=3.8, metadata=dimension(time=-1.0))
    reach_weight: float = 10.0
    rest_time: float = field(default=3.0, metadata=dimension(time=1.0))
    activation: ActivationCost = field(
        default_factory=lambda: ActivationCost(effort=0.02, change=0.016)
    )
    landing: BalanceGains = field(default_factory=BalanceGains)
    ease: float = 0.0
    ease_time: float = field(default=0.94, metadata=dimension(time=1.0))

    def __post_init__(self) -> None:
        """Refuse gains that are not finite or out of their range."""
        checks.settle(
            self,
            positive=("crouch_time", "crouch_share", "push_time", "rise", "height"),
            not_negative=(
                *("push", "push_spin", "position", "velocity", "spin", "reach_rate", "play"),
                *("momentum_weight", "spin_weight", "reach_weight"),
                *("sole_weight", "sole_rate"),
                *("rest_time", "ease", "ease_time"),
            ),
            finite=("depth", "wind", "turn"),
            vectors=("launch",),
        )
        checks.keep(self, way=checks.vector("JumpGains.way", self.way, 2, unit="L"))
        checks.instance("JumpGains.activation", self.activation, ActivationCost)
        checks.instance("JumpGains.landing", self.landing, BalanceGains)
