"""Gains of the balance controller, in units of the body."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from warp_softbody.controllers.body_units import dimension
from warp_softbody.controllers.controller import ActivationCost
from warp_softbody.controllers.motions.recovery_gains import RecoveryGains
from warp_softbody.inputs import checks


@dataclass(frozen=True, kw_only=True)
class BalanceGains:
    """Gains and weights of the balance controller, in units of the body (`BodyUnits`).

    Attributes:
        position: Kp, g/L, pull of the centre of mass towards its place above the base.
        velocity: Kd, sqrt(g/L), decay of linear momentum.
        spin: sqrt(g/L), decay of angular momentum.
        upright: sqrt(g/L), rate at which the head comes back to its place over the base.
        upright_weight: of the head's horizontal velocity against the base, in units of g dt; 0
            leaves the term out, and with it all from `follow` to `skip_from`.
        follow: share of the base's tilt that the head's place turns with; at 0 it is above the
            base, at 1 on the base's own axis.
        lean: by which share of the capture point's offset the head leans back against it.
        height_weight: of the head's height over the base, over `upright_weight`.
        height_rate: sqrt(g/L), rate at which the head comes to its height.
        height_acceleration: g, the largest of the head against the base that is asked for.
        height_within: L, offset of the capture point below which less than the whole way up to its
            height is asked of the head, none at all at 0.
        hold_within: share of the way to the edge of the sole up to which the capture point may come
            before the base is moved to come under the head; at 0 it always is. Feet are light, and
            a plan that brings the head over the base by them shuffles on for ever.
        squat: how much lower the head is wanted, as a share of the capture point's offset.
        least_height: share of the head's height at rest below which no squat goes.
        skip_from: L, offset of the capture point from which on the body shortens as fast as it
            can, so that the edge which it stands on comes off the ground and lands further on.
        crouch: how far the centre of mass is lowered, as a share of the capture point's offset.
        momentum_weight: of the linear momentum, in units of m g dt.
        spin_weight: of the angular momentum, in units of m g L dt.
        base_weight: of the base's relative growth, in units of sqrt(g/L); 0 leaves the term out.
        base_rate: sqrt(g/L)/L, wanted relative growth of the base over the capture point's offset.
        activation: cost of effort and change.
        relax: by how much more than one effort costs a body that stands well, as a factor, so that
            its own damping brings it to rest.
        relax_within: L, offset of the capture point from which on effort costs as usual.
        recovery: how the body leaves its base where it cannot stay on it; the default never does.
    """

    position: float = field(default=4.587, metadata=dimension(time=-2.0))
    velocity: float = field(default=2.235, metadata=dimension(time=-1.0))
    spin: float = field(default=2.554, metadata=dimension(time=-1.0))
    upright: float = field(default=3.0, metadata=dimension(time=-1.0))
    upright_weight: float = 0.0
    follow: float = 0.0
    lean: float = 0.0
    height_weight: float = 0.0
    height_rate: float = field(default=3.2, metadata=dimension(time=-1.0))
    height_acceleration: float = 3.0
    height_within: float = field(default=0.0, metadata=dimension(length=1.0))
    hold_within: float = 0.0
    squat: float = 0.0
    least_height: float = 0.75
    skip_from: float = field(default=1.0, metadata=dimension(length=1.0))
    crouch: float = 1.1
    momentum_weight: float = 1.0
    spin_weight: float = 38.0
    base_weight: float = 0.1766
    base_rate: float = field(default=1.277, metadata=dimension(length=-1.0, time=-1.0))
    activation: ActivationCost = field(
        default_factory=lambda: ActivationCost(effort=0.015, change=0.01096)
    )
    relax: float = 0.0
    relax_within: float = field(default=0.1, metadata=dimension(length=1.0))
    recovery: RecoveryGains = field(default_factory=RecoveryGains)

    def __post_init__(self) -> None:
        """Refuse gains that are not finite or out of their range."""
        checks.settle(
            self,
            positive=("relax_within", "skip_from"),
            not_negative=(
                "position",
                "velocity",
                "spin",
                "upright",
                "upright_weight",
                "height_weight",
                "height_rate",
                "height_acceleration",
                "height_within",
                "hold_within",
                "squat",
                "momentum_weight",
                "spin_weight",
                "base_weight",
                "relax",
            ),
            finite=("crouch", "base_rate", "follow", "lean", "least_height"),
        )
        checks.instance("BalanceGains.activation", self.activation, ActivationCost)
        checks.instance("BalanceGains.recovery", self.recovery, RecoveryGains)


LETTER = BalanceGains(
    position=2.0,  # g/L
    velocity=2.6,  # sqrt(g/L)
    spin=5.0,  # sqrt(g/L)
    upright=4.0,  # sqrt(g/L)
    upright_weight=0.1,  # of rows in g dt
    follow=0.3,  # of the base's tilt
    lean=0.2,  # of the offset
    height_weight=0.5,  # of upright_weight
    height_rate=3.2,  # sqrt(g/L)
    height_acceleration=3.0,  # g
    squat=2.0,  # of the offset
    least_height=0.75,  # of the height at rest
    skip_from=0.22,  # L
    crouch=0.1,  # of the offset
    momentum_weight=0.02,  # of rows in m g dt
    spin_weight=0.003,  # of rows in m g L dt
    base_weight=0.003,  # of rows in sqrt(g/L)
    base_rate=1.277,  # sqrt(g/L)/L
    activation=ActivationCost(effort=0.1, change=0.028),
    relax=20.0,
    relax_within=0.1,  # L
    recovery=RecoveryGains(leave=1.37),  # of the way to the edge
)
"""Of the letter that balances. By hand, after a search by
evolution at pushes of 0.5 to 0.52 with the step, twice and a quarter of it. Momenta count little: a
plan that asks more of them than contact at the edge of the base can give bends the body until it
falls."""

ANY_BODY = replace(
    LETTER,
    upright_weight=0.03,
    follow=0.0,
    lean=0.0,
    hold_within=0.6,
    squat=0.0,
    skip_from=1.0,
    activation=ActivationCost(effort=0.1, change=0.5),
    relax=0.0,
    recovery=RecoveryGains(),
)
"""Of a body that has none of its own: calmer, without what the letter's shape alone bears. A body
that leans back against a push over its heels falls over them."""
