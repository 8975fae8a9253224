"""Leaps of a body that lets itself fall: lean, bow, leap, land (docs/method.md section 4)."""

from __future__ import annotations

import math
from enum import Enum

import numpy as np

from warp_softbody.controllers import objectives
from warp_softbody.controllers.arguments import remembered
from warp_softbody.controllers.body_units import BodyUnits, in_si
from warp_softbody.controllers.controller import Goals, seen
from warp_softbody.controllers.motions.balance import Balance
from warp_softbody.controllers.motions.body_measures import BASE_PATCHES
from warp_softbody.controllers.motions.leap_gains import LeapGains
from warp_softbody.controllers.motions.recovery import Recovery, Tipping
from warp_softbody.controllers.motions.recovery_gains import RecoveryGains
from warp_softbody.controllers.patches import ground_patches
from warp_softbody.inputs import checks, input_kinds
from warp_softbody.inputs.records import unchecked_copy
from warp_softbody.world.view import BodyView


class LeapPhase(Enum):
    """What a body that leaps is doing."""

    STAND = "stand"
    LEAN = "lean"
    BOW = "bow"
    LEAP = "leap"
    STOP = "stop"
    LAND = "land"


@remembered
class Leap:
    """Leans, bows as it falls, throws itself ahead, as often as is wanted, and stands.

    A body that stands cannot throw itself far: its centre of mass is over its base as it takes off.
    That of one that falls is ahead of its base, and what it is bent by it can straighten.
    """

    required_regions = ("base", "head")
    """Regions that it needs of a character."""

    keeps_upright = True
    """A run in which the body falls is said to be doubtful."""

    stays = False
    """It goes ahead."""

    def __init__(
        self,
        gains: LeapGains | None = None,
        *,
        leaps: int = 1,
        start: float = 0.94,
        heading: float = 0.0,
        base: str = "base",
        head: str = "head",
        patches: tuple[str, ...] = BASE_PATCHES,
    ) -> None:
        """Leap a number of times in a row, from ``start`` sqrt(L/g) on.

        Args:
            gains: None for those of a letter.
            leaps: how many.
            start: sqrt(L/g), when it begins to lean.
            heading: rad from +x towards +y, where it leaps.
            base: region on which it stands, and lands.
            head: region over it.
            patches: parts of the base, of contacts.
        """
        self._gains = checks.optional("gains of Leap", gains, LeapGains)
        self._leaps = checks.whole("leaps of Leap", leaps, low=1)
        self._wait = checks.number("start of Leap", start, low=0.0, unit="sqrt(L/g)")
        angle = checks.number("heading of Leap", heading, unit="rad")
        self._way = np.array([math.cos(angle), math.sin(angle)])
        base = input_kinds.name("base of Leap", base)
        head = input_kinds.name("head of Leap", head)
        self._patches = input_kinds.names("patches of Leap", patches)
        self._balance = Balance(self._gains.landing, base=base, head=head, patches=patches)
        self._hops = Recovery(base, head, self._patches)
        self.phase = LeapPhase.STAND
        self._since = 0.0
        self._rested = False
        self._units: BodyUnits | None = None

    @property
    def interruptible(self) -> bool:
        """Whether it stands, before the leaps or after them."""
        return self.phase in (LeapPhase.STAND, LeapPhase.LAND) and self._balance.interruptible

    @property
    def finished(self) -> bool:
        """Whether it has stood for its time of rest after the leaps."""
        return self._rested

    def goals(self, view: BodyView) -> Goals:
        """Objectives of the step from ``view`` on."""
        view = seen(view)
        if self._units is None:
            self._units = BodyUnits.of(view)
            self._gains = in_si(self._gains, self._units)
            self._wait *= self._units.time
        fall = self._balance.tipping(view)
        self._advance(view, fall)
        if self.phase is LeapPhase.LEAN:
            return self._lean(view)
        if self.phase in (LeapPhase.BOW, LeapPhase.LEAP, LeapPhase.STOP):
            goals = self._hops.goals(view, self._hopping, fall)
            if goals is not None:
                return goals
            self._enter(LeapPhase.LAND, view)
        return self._balance.goals(view)

    @property
    def _hopping(self) -> RecoveryGains:
        """Gains of the present hop."""
        g = self._gains
        if self.phase is LeapPhase.LEAP:
            last = self._hops.hops >= self._leaps
            return g.leap if last else unchecked_copy(g.leap, settle=0.0)
        return g.bow if self.phase is LeapPhase.BOW else g.landing.recovery

    def _advance(self, view: BodyView, fall: Tipping) -> None:
        g, elapsed = self._gains, view.time - self._since
        if self.phase is LeapPhase.STAND:
            if elapsed >= self._wait:
                self._enter(LeapPhase.LEAN, view)
        elif self.phase is LeapPhase.LEAN:
            leans = fall.ahead @ self._way > 0.0 and fall.share(fall.ahead) > g.lean
            if leans or elapsed >= g.lean_time:
                self._hops.leave(view)
                self._enter(LeapPhase.BOW, view)
        elif self.phase is LeapPhase.BOW:
            if self._hops.hops >= 1:
                self._enter(LeapPhase.LEAP, view)
        elif self.phase is LeapPhase.LEAP:
            if self._hops.hops > self._leaps:
                self._enter(LeapPhase.STOP, view)
        elif self.phase is LeapPhase.LAND:
            self._rested = elapsed >= g.rest_time

    def _enter(self, phase: LeapPhase, view: BodyView) -> None:
        self.phase = phase
        self._since = view.time

    def _lean(self, view: BodyView) -> Goals:
        """The centre of mass is to be as fast forward as the sole bears."""
        g = self._gains
        x, y = self._way
        forward = view.mass * view.gravity * g.acceleration * np.array([x, y, 0.0])
        # what goes forward is not to be slowed down
        beside = view.linear_momentum.copy()
        beside[:2] -= (beside[:2] @ self._way) * self._way
        return Goals(
            objectives=(
                objectives.linear_momentum(view, forward - g.velocity * beside, g.momentum_weight),
                objectives.angular_momentum(view, -g.spin * view.angular_momentum, g.spin_weight),
            ),
            patches=ground_patches(view, self._patches),
            activation=g.activation,
        )
