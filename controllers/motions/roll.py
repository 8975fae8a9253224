"""Rolling: fall ahead of the contact, over and over (docs/method.md section 4)."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers import objectives
from warp_softbody.controllers.body_units import BodyUnits, dimension, in_si
from warp_softbody.controllers.controller import ActivationCost, Goals, seen
from warp_softbody.controllers.motions.body_measures import angle_turned, contact_point
from warp_softbody.controllers.patch_clusters import clustered_patches
from warp_softbody.controllers.patches import Patch
from warp_softbody.inputs import checks, input_kinds
from warp_softbody.world.view import BodyView

LET_GO = 5.0
"""Time constants of the letting go after which muscles are slack for good: less than a hundredth
of the contraction is left."""

STILL = 0.016
"""sqrt(g L), of the centre of mass, below which a body that rolls out counts as still."""

STILL_TIME = 1.566
"""sqrt(L/g) that it has to be still: longer than it stands at the end of a swing back."""


@dataclass(frozen=True, kw_only=True)
class RollGains:
    """Gains and weights of rolling along x, in units of the body (`BodyUnits`).

    Attributes:
        lead: L, how far ahead of the contact the centre of mass is wanted.
        position: Kp, g/L, of the centre of mass.
        velocity: Kd, sqrt(g/L), of linear momentum.
        spin: m g L, wanted rate of angular momentum about the axis.
        steadiness: sqrt(g/L), decay of angular momentum about the other axes.
        top_speed: sqrt(g L), of the centre of mass, at which the wanted rate has fallen to zero.
        follow: sqrt(L/g), time in which the plan follows a contact that moves along the rim.
        ease: sqrt(L/g), in which lead and spin come up at the start of a leg.
        release: sqrt(L/g), time constant in which muscles let go at the end of a leg.
        spin_weight: of the angular momentum, in units of m g L dt.
        momentum_weight: of the linear momentum, in units of m g dt.
        activation: cost of effort and change.
    """

    lead: float = field(default=0.1, metadata=dimension(length=1.0))
    position: float = field(default=1.529, metadata=dimension(time=-2.0))
    velocity: float = field(default=1.596, metadata=dimension(time=-1.0))
    spin: float = field(default=0.1, metadata=dimension(length=1.0))
    steadiness: float = field(default=1.596, metadata=dimension(time=-1.0))
    top_speed: float = field(default=0.4789, metadata=dimension(length=1.0, time=-1.0))
    follow: float = field(default=0.1566, metadata=dimension(time=1.0))
    ease: float = field(default=0.9396, metadata=dimension(time=1.0))
    release: float = field(default=0.3132, metadata=dimension(time=1.0))
    spin_weight: float = 5.0
    momentum_weight: float = 1.0
    activation: ActivationCost = field(
        default_factory=lambda: ActivationCost(effort=0.02, change=0.1566)
    )

    def __post_init__(self) -> None:
        """Refuse gains that are not finite or out of their range."""
        checks.settle(
            self,
            positive=("top_speed",),
            not_negative=(
                *("position", "velocity", "steadiness", "follow", "ease", "release"),
                *("spin_weight", "momentum_weight"),
            ),
            finite=("lead", "spin"),
        )
        checks.instance("RollGains.activation", self.activation, ActivationCost)


@dataclass(frozen=True, kw_only=True)
class Leg:
    """Rolls one way until the body has turned, then lets go and rolls out until it is still.

    Attributes:
        direction: +1 or -1, along x.
        turn: rad, by which it is driven.
        longest: sqrt(L/g), longest time in which it is driven.
    """

    direction: float
    turn: float
    longest: float = field(default=10.96, metadata=dimension(time=1.0))

    def __post_init__(self) -> None:
        """Refuse a direction other than 1 and -1, and a turn or time that is not positive."""
        checks.settle(self, positive=("turn", "longest"), finite=("direction",))
        if abs(self.direction) != 1.0:
            checks.refuse("Leg.direction", "1 or -1", self.direction)


class Roll:
    """Rolls leg by leg; afterwards passive."""

    def __init__(
        self,
        gains: RollGains | None = None,
        *,
        legs: tuple[Leg, ...],
        rim: str,
        patches: int = 6,
        parts: int = 64,
    ) -> None:
        """Roll on the nodes of a region ``rim``, divided into ``parts``, on so many patches."""
        self._gains = checks.optional("gains of Roll", gains, RollGains)
        self._legs = list(checks.items("legs of Roll", legs, Leg))
        self._rim = input_kinds.name("rim of Roll", rim)
        self._count = checks.whole("patches of Roll", patches, low=4, high=8)
        self._parts = checks.whole("parts of Roll", parts, low=self._count, high=2**16)
        self._last: tuple[Patch, ...] = ()
        self._units: BodyUnits | None = None
        self._height: float | None = None
        self._behind: FloatArray | None = None
        self._heading = 0.0
        self._angle = 0.0
        self._from = 0.0
        self._begun = 0.0
        self._released = None if self._legs else 0.0
        self._moved = 0.0

    def goals(self, view: BodyView) -> Goals | None:
        """Objectives of the step from ``view`` on; None where the body rolls out."""
        view = seen(view)
        if self._units is None:
            self._units = BodyUnits.of(view)
            self._gains = in_si(self._gains, self._units)
            self._legs = [in_si(leg, self._units) for leg in self._legs]
        self._advance(view, self._units)
        if self._released is not None:
            return self._let_go(view, self._units, view.time - self._released)
        g = self._gains
        goal = self._goal(view, self._headed(view, self._legs[0].direction))
        pull = view.mass * g.position * (goal - view.center_of_mass)
        rate = pull - g.velocity * view.linear_momentum
        return Goals(
            objectives=(
                objectives.linear_momentum(view, rate, g.momentum_weight),
                objectives.angular_momentum(view, self._spin(view), g.spin_weight),
            ),
            patches=self._patches(view),
            activation=g.activation,
        )

    def _advance(self, view: BodyView, units: BodyUnits) -> None:
        """Let go where the body has turned enough, take the next leg where it is still."""
        turned = np.angle(np.exp(1j * (angle_turned(view, 2, 0) - self._angle)))
        self._angle += float(turned)
        if abs(view.linear_momentum[0]) > STILL * units.speed * view.mass:
            self._moved = view.time
        if self._released is None:
            leg = self._legs[0]
            turned_enough = abs(self._angle - self._from) >= leg.turn
            if turned_enough or view.time - self._begun >= leg.longest:
                self._released = self._moved = view.time
                self._heading = 0.0
                del self._legs[0]
        elif self._legs and view.time - self._moved >= STILL_TIME * units.time:
            self._released, self._behind = None, None
            self._from, self._begun = self._angle, view.time

    def _let_go(self, view: BodyView, units: BodyUnits, since: float) -> Goals | None:
        release = self._gains.release
        if since >= LET_GO * release:
            return None
        # Without objectives a step takes a share dt / (dt + release) of the contraction away.
        return Goals(
            objectives=(),
            patches=self._patches(view),
            activation=ActivationCost(effort=1.0, change=release / units.time),
        )

    def _headed(self, view: BodyView, direction: float) -> float:
        """The direction, come up from that of the leg before."""
        ease = self._gains.ease
        step = view.time_step / ease if ease > 0.0 else 2.0
        self._heading += float(np.clip(direction - self._heading, -step, step))
        return self._heading

    def _goal(self, view: BodyView, heading: float) -> FloatArray:
        """Where the centre of mass is wanted, m: ahead of the contact, at its first height."""
        g = self._gains
        middle = contact_point(view, self._rim)
        if self._height is None:
            self._height = float(view.center_of_mass[2] - middle[2])
        behind = middle - view.center_of_mass
        if self._behind is None:
            self._behind = behind
        self._behind += (behind - self._behind) * view.time_step / (view.time_step + g.follow)
        ahead = np.array([heading * g.lead, 0.0, self._height])
        return np.asarray(view.center_of_mass + self._behind + ahead)

    def _spin(self, view: BodyView) -> FloatArray:
        """Wanted rate of angular momentum, N m."""
        g, heading = self._gains, self._heading
        spin = -g.steadiness * view.angular_momentum
        speed = float(np.sign(heading) * view.linear_momentum[0] / view.mass)
        eager = float(np.clip(1.0 - speed / g.top_speed, -1.0, 1.0))
        spin[1] = heading * eager * g.spin * view.weight
        return np.asarray(spin)

    def _patches(self, view: BodyView) -> tuple[Patch, ...]:
        self._last = clustered_patches(
            view, count=self._count, region=self._rim, parts=self._parts, last=self._last
        )
        return self._last
