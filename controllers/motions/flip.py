"""Somersaults: crouch, let go, tuck in the air, land (docs/method.md section 4)."""

from __future__ import annotations

import math
from enum import Enum

import numpy as np

from warp_softbody.controllers import objectives
from warp_softbody.controllers.arguments import remembered
from warp_softbody.controllers.body_units import BodyUnits, in_si
from warp_softbody.controllers.controller import ActivationCost, Goals, seen, segments
from warp_softbody.controllers.motions.balance import Balance
from warp_softbody.controllers.motions.body_measures import (
    BASE_PATCHES,
    angle_turned,
    mean_weights,
    moments_of_inertia,
    region_mean,
)
from warp_softbody.controllers.motions.flip_gains import FlipGains, TakeOff
from warp_softbody.controllers.motions.muscle_quarters import muscle_quarters
from warp_softbody.controllers.objectives import Objective
from warp_softbody.controllers.patches import ground_patches
from warp_softbody.inputs import checks, input_kinds
from warp_softbody.world.view import BodyView

LEAST_WAY = 0.05
"""rad, of the rest of a turn, for which a length of the body is still reckoned."""

INERTIAS = (0.2, 3.0)
"""Least and greatest inertia that is wanted within a step, over the present one."""


class FlipPhase(Enum):
    """What a body that turns a somersault is doing."""

    STAND = "stand"
    PUSH = "push"
    FLY = "fly"
    ARREST = "arrest"
    LAND = "land"


@remembered
class Flip:
    """Turns a somersault forward, about y, and stands.

    The take-off is a course of activations. What it comes to differs from body to body; in the air
    the body is as long as lets it turn to where it is to land.
    """

    plans_single_steps = True
    """Its gains were found with plans of one step of 1/240 s, and its take-off is a course."""

    def __init__(
        self,
        gains: FlipGains | None = None,
        *,
        take_off: TakeOff | None = None,
        start: float = 0.1,
        base: str = "base",
        head: str = "head",
        patches: tuple[str, ...] = BASE_PATCHES,
        resting: tuple[int, ...] = (),
    ) -> None:
        """Turn once, from ``start`` sqrt(L/g) on.

        Args:
            gains: None for the usual ones.
            take_off: its activations, found for a body; None for those of no body in particular.
            start: sqrt(L/g), when it begins to crouch.
            base: region on which it stands, and lands.
            head: region that it draws towards the base as it tucks.
            patches: parts of the base, of contacts.
            resting: segments that do not contract in the take-off, so that the sole stays flat.
        """
        self._gains = checks.optional("gains of Flip", gains, FlipGains)
        self._take_off = checks.optional("take_off of Flip", take_off, TakeOff)
        self._wait = checks.number("start of Flip", start, low=0.0, unit="sqrt(L/g)")
        self._base = input_kinds.name("base of Flip", base)
        self._head = input_kinds.name("head of Flip", head)
        self._patches = input_kinds.names("patches of Flip", patches)
        self._resting = segments("resting of Flip", resting)
        self._balance = Balance(self._gains.landing, base=base, head=head, patches=patches)
        self.phase = FlipPhase.STAND
        self._since = self._angle = 0.0
        self._done = self._rested = False
        self._units: BodyUnits | None = None
        self._weights = np.zeros(0)
        self._length = 0.0
        self._quarters = np.zeros(0, dtype=np.intp)

    @property
    def angle(self) -> float:
        """By how much the body has turned forward, rad."""
        return self._angle

    @property
    def keeps_upright(self) -> bool:
        """Whether a body that lies now has fallen: not while it turns."""
        return self.phase not in (FlipPhase.FLY, FlipPhase.ARREST)

    @property
    def _tilt(self) -> float:
        """What is missing to whole turns, rad, negative where the body leans back."""
        return math.remainder(self._angle, 2.0 * math.pi)

    @property
    def interruptible(self) -> bool:
        """Whether it stands, before its turn or after it."""
        return self.phase in (FlipPhase.STAND, FlipPhase.LAND)

    @property
    def finished(self) -> bool:
        """Whether it has stood for its time of rest after the turn."""
        return self._rested

    def goals(self, view: BodyView) -> Goals:
        """Objectives of the step from ``view`` on."""
        view = seen(view)
        if self._units is None:
            self._begin(view, BodyUnits.of(view))
        self._angle += float(np.angle(np.exp(1j * (angle_turned(view, 2, 0) - self._angle))))
        self._advance(view)
        if self.phase is FlipPhase.PUSH:
            return self._push(view)
        if self.phase is FlipPhase.FLY:
            return Goals(objectives=(self._tuck(view),), activation=self._gains.air)
        if self.phase is FlipPhase.ARREST:
            return self._brake(view)
        return self._balance.goals(view)

    def _begin(self, view: BodyView, units: BodyUnits) -> None:
        """Take over the units of the body, and its length and muscles."""
        self._units = units
        self._gains = in_si(self._gains, units)
        self._take_off = in_si(self._take_off, units)
        self._wait *= units.time
        self._weights = mean_weights(view, (self._head,)) - mean_weights(view, (self._base,))
        rest = view.scene.character.mesh.points
        self._length = float(np.linalg.norm(self._weights[: len(rest)] @ rest))
        self._quarters = muscle_quarters(view)

    def _advance(self, view: BodyView) -> None:
        g, elapsed = self._gains, view.time - self._since
        airborne = not view.touching.any()
        if self.phase is FlipPhase.STAND:
            if elapsed >= self._wait:
                self._enter(FlipPhase.PUSH, view)
        elif self.phase is FlipPhase.PUSH:
            if airborne and elapsed > 0.5 * self._take_off.crouch:
                self._enter(FlipPhase.FLY, view)
            elif elapsed > self._take_off.lasts + g.longest:
                self._enter(FlipPhase.LAND, view)
        elif self.phase is FlipPhase.FLY:
            if not airborne and view.linear_momentum[2] < 0.0:
                self._enter(FlipPhase.ARREST, view)
        elif self.phase is FlipPhase.ARREST:
            upright = abs(self._tilt) <= g.upright or elapsed >= g.longest_arrest
            if elapsed >= g.arrest_time and upright:
                self._enter(FlipPhase.LAND, view)
        else:
            self._rested = elapsed >= g.rest_time

    def _enter(self, phase: FlipPhase, view: BodyView) -> None:
        self.phase = phase
        self._since = view.time

    def _push(self, view: BodyView) -> Goals:
        """The muscles keep to the activations of the take-off."""
        plan, elapsed = self._take_off, view.time - self._since
        times = plan.crouch + plan.interval * np.arange(-1, len(plan.levels))
        times[0] = 0.0
        levels = np.array([(1.0, 1.0, 1.0, 1.0), *plan.levels])
        now = [np.interp(elapsed, times, own) for own in levels.T]
        activations = np.ones(len(self._quarters))
        if elapsed <= times[-1]:
            activations = np.array(now)[self._quarters]
        # an index beyond the segments is told of where the goals are checked
        activations[[index for index in self._resting if index < len(activations)]] = 1.0
        return Goals(
            objectives=(),
            patches=ground_patches(view, self._patches),
            activation=ActivationCost(effort=0.0, change=plan.weight),
            resting=self._resting,
            nominal=tuple(activations.tolist()),
        )

    def _tuck(self, view: BodyView) -> Objective:
        """The body comes to the length with which it turns to where it is to land, and straight.

        Seen along and across it, as it will be turned in the middle of the step.
        """
        g, dt = self._gains, view.time_step
        inertia = float(moments_of_inertia(view)[1])
        spin = float(view.angular_momentum[1]) / inertia
        way = self._weights @ view.positions
        length = self._wanted_length(view, float(np.linalg.norm(way)), inertia)
        angle = self._angle + 0.5 * dt * spin
        c, s = math.cos(angle), math.sin(angle)
        axes = np.array([[s, 0.0, c], [c, 0.0, -s]])
        along, across = (axes @ way).tolist()
        speed = BodyUnits.of(view).speed
        target = [g.tuck_rate * (length - along), spin * along - g.tuck_rate * across]
        return Objective(
            name="tuck",
            rows=axes @ objectives.mean_rows(view, self._weights / speed),
            target=np.array(target) / speed,
            weight=np.array([g.tuck_weight, g.straight_weight]),
        )

    def _wanted_length(self, view: BodyView, now: float, inertia: float) -> float:
        """Of the body, m: its inertia is taken to go with the square of it."""
        g = self._gains
        left = self._airtime(view) - g.open
        if left <= 0.0:
            return self._length
        way = 2.0 * math.pi - g.lean - self._angle
        wanted = float(view.angular_momentum[1]) * left / max(way, LEAST_WAY)
        share = min(max(wanted / inertia, INERTIAS[0]), INERTIAS[1]) if way > 0.0 else INERTIAS[1]
        return min(max(now * math.sqrt(share), g.least_length * self._length), self._length)

    def _airtime(self, view: BodyView) -> float:
        """Seconds until the body comes down to its landing height."""
        speed = float(view.linear_momentum[2]) / view.mass
        drop = float(view.center_of_mass[2]) - self._gains.landing_height
        return (speed + math.sqrt(max(speed**2 + 2.0 * view.gravity * drop, 0.0))) / view.gravity

    def _brake(self, view: BodyView) -> Goals:
        """Momenta decay, the body comes upright and the centre of mass low over its base."""
        g = self._gains
        stopped = view.time - self._since >= g.arrest_time
        velocity, cost = (g.righting_velocity, g.righting) if stopped else (g.velocity, g.arrest)
        goal = region_mean(view, view.positions, self._base) + np.array([0.0, 0.0, g.height])
        linear = view.mass * g.position * (goal - view.center_of_mass)
        linear -= velocity * view.linear_momentum
        angular = -g.spin * view.angular_momentum
        angular[1] -= moments_of_inertia(view)[1] * g.turn * self._tilt
        return Goals(
            objectives=(
                objectives.linear_momentum(view, linear, g.momentum_weight),
                objectives.angular_momentum(view, angular, g.spin_weight),
            ),
            patches=ground_patches(view, self._patches),
            activation=cost,
        )
