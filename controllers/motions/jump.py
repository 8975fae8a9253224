"""Jumps: crouch, push off, lift, fly, land (docs/method.md section 4)."""

from __future__ import annotations

from enum import Enum

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.controllers import objectives
from warp_softbody.controllers.arguments import remembered
from warp_softbody.controllers.body_units import BodyUnits, in_si
from warp_softbody.controllers.controller import ActivationCost, Goals, seen, segments
from warp_softbody.controllers.motions.any_body import feet_of
from warp_softbody.controllers.motions.balance import Balance
from warp_softbody.controllers.motions.body_measures import (
    BASE_PATCHES,
    mean_weights,
    moments_of_inertia,
    region_mean,
)
from warp_softbody.controllers.motions.for_any_body.jumping import jump_gains
from warp_softbody.controllers.motions.held_sole import HeldSole
from warp_softbody.controllers.motions.jump_gains import JumpGains
from warp_softbody.controllers.motions.trajectories import eased_change, smooth_step
from warp_softbody.controllers.objectives import Objective
from warp_softbody.controllers.patches import ground_patches
from warp_softbody.inputs import checks, input_kinds
from warp_softbody.inputs.records import unchecked_copy
from warp_softbody.world.view import BodyView

NEARLY = 0.94
"""Share of the wanted rising speed from which on the base is lifted."""


class JumpPhase(Enum):
    """What a jumper is doing."""

    STAND = "stand"
    CROUCH = "crouch"
    PUSH = "push"
    LIFT = "lift"
    FLY = "fly"
    LAND = "land"


@remembered
class Jump:
    """Jumps a number of times and keeps its balance before, between and after."""

    required_regions = ("base",)
    """Regions that `for_` needs of a character."""

    keeps_upright = True
    """A run in which the body falls is said to be doubtful."""

    def __init__(
        self,
        gains: JumpGains | None = None,
        *,
        jumps: int = 1,
        start: float = 1.566,
        base: str = "base",
        patches: tuple[str, ...] = BASE_PATCHES,
        resting: tuple[int, ...] = (),
    ) -> None:
        """Jump from a base region, ``start`` sqrt(L/g) after the run begins.

        The ``resting`` segments do not contract in crouch and push, so that the sole stays flat.
        """
        self._gains = checks.optional("gains of Jump", gains, JumpGains)
        self._jumps = checks.whole("jumps of Jump", jumps, low=1)
        self._base = input_kinds.name("base of Jump", base)
        self._patches = input_kinds.names("patches of Jump", patches)
        self._resting = segments("resting of Jump", resting)
        self._balance = Balance(self._gains.landing, base=base, patches=patches)
        self.phase = JumpPhase.STAND
        self._since = 0.0
        self._wait = checks.number("start of Jump", start, low=0.0, unit="sqrt(L/g)")
        self._done = 0
        self._rested = False
        self._units: BodyUnits | None = None
        self._height: float | None = None
        self._first = np.zeros(3)
        self._ground = 0.0
        self._above = 0.0
        self._sole = HeldSole(self._base, self._patches)

    @classmethod
    def for_(
        cls,
        character: Character,
        *,
        height: float = 0.08,
        way: float = 0.0,
        jumps: int = 1,
        gains: JumpGains | None = None,
    ) -> Jump:
        """Jumps of any body that stands.

        Args:
            character: has a region `base`; it stands as in `Balance.for_`.
            height: m, to which its base is to come off the ground on Earth.
            way: m along x, by which each jump goes ahead.
            jumps: number of them.
            gains: None for those of a body of its height; ``height`` and ``way`` are theirs then.

        Raises:
            InputError: the body lies, or lacks a region or muscles.
        """
        found = jump_gains(character, height, way)
        gains = found if gains is None else gains
        return cls(gains, jumps=jumps, patches=feet_of(character))

    @property
    def interruptible(self) -> bool:
        """Whether it stands, before a jump or after one."""
        return self.phase in (JumpPhase.STAND, JumpPhase.LAND)

    @property
    def stays(self) -> bool:
        """Whether it jumps on the spot."""
        return not any((*self._gains.way, *self._gains.launch[:2]))

    @property
    def finished(self) -> bool:
        """Whether it has stood for its time of rest after the last jump."""
        return self._rested

    def goals(self, view: BodyView) -> Goals:
        """Objectives of the step from ``view`` on."""
        view = seen(view)
        if self._units is None:
            self._units = BodyUnits.of(view)
            self._gains = in_si(self._gains, self._units)
            self._wait *= self._units.time
        base = region_mean(view, view.positions, self._base)
        if self._height is None:
            self._height = float(view.center_of_mass[2] - base[2])
        self._advance(view, base)
        if self.phase is JumpPhase.CROUCH:
            return self._wanted(view, self._crouch(view, base), grounded=True)
        if self.phase is JumpPhase.PUSH:
            return self._wanted(view, self._push(view), grounded=True)
        if self.phase in (JumpPhase.LIFT, JumpPhase.FLY):
            return self._wanted(view, self._fly(view), grounded=False)
        goals = self._balance.goals(view)
        return unchecked_copy(
            goals,
            objectives=(*goals.objectives, *self._held(view)),
            activation=self._eased(view.time, goals.activation),
        )

    def _eased(self, time: float, usual: ActivationCost) -> ActivationCost:
        g, elapsed = self._gains, time - self._since
        if self.phase is not JumpPhase.LAND or elapsed >= g.ease_time:
            return usual
        return eased_change(usual, g.ease, elapsed / g.ease_time)

    def _advance(self, view: BodyView, base: FloatArray) -> None:
        g, elapsed = self._gains, view.time - self._since
        airborne = not view.touching.any()
        if self.phase in (JumpPhase.STAND, JumpPhase.LAND):
            self._rested = elapsed >= self._wait and self._done == self._jumps
            if elapsed >= self._wait and self._done < self._jumps:
                self._begin(view, base)
        elif self.phase is JumpPhase.CROUCH:
            if elapsed >= g.crouch_share * g.crouch_time:
                self._enter(JumpPhase.PUSH, view)
        elif self.phase in (JumpPhase.PUSH, JumpPhase.LIFT):
            if airborne:
                self._enter(JumpPhase.FLY, view)
            elif elapsed >= g.push_time:
                self._land(view)
            elif self.phase is JumpPhase.PUSH and self._launched(view):
                self._enter(JumpPhase.LIFT, view)
        elif not airborne and view.linear_momentum[2] < 0.0:
            self._land(view)

    def _begin(self, view: BodyView, base: FloatArray) -> None:
        """Begin a jump; ways count from where the first one began."""
        if self._done == 0:
            self._first = base
        self._ground = float(base[2])
        self._above = float(view.center_of_mass[2] - base[2])
        self._enter(JumpPhase.CROUCH, view)

    def _enter(self, phase: JumpPhase, view: BodyView) -> None:
        self.phase = phase
        self._since = view.time

    def _land(self, view: BodyView) -> None:
        self._enter(JumpPhase.LAND, view)
        self._wait = self._gains.rest_time
        self._done += 1

    def _launched(self, view: BodyView) -> bool:
        """Whether the body rises about as fast as it is to take off, or was to by now."""
        g, due = self._gains, view.time + 0.5 * view.horizon - self._since
        # what is planned for longer than the step comes about that much later, on the mean
        later = 0.5 * (view.horizon - view.time_step)
        speed = float(view.linear_momentum[2] / view.mass) + later * g.launch[2] / g.rise
        return due >= g.rise or speed >= NEARLY * g.launch[2]

    def _wanted(self, view: BodyView, wanted: tuple[Objective, ...], *, grounded: bool) -> Goals:
        return Goals(
            objectives=(*wanted, *self._held(view)) if grounded else wanted,
            patches=ground_patches(view, self._patches) if grounded else (),
            activation=self._gains.activation,
            resting=self._resting if grounded else (),
        )

    def _held(self, view: BodyView) -> tuple[Objective, ...]:
        return self._sole.objectives(view, self._gains.sole_rate, self._gains.sole_weight)

    def _crouch(self, view: BodyView, base: FloatArray) -> tuple[Objective, ...]:
        """The centre of mass goes down from where it is, and the body winds up, as planned."""
        g = self._gains
        assert self._height is not None
        step, rate, bend = smooth_step((view.time - self._since) / g.crouch_time)
        rate, bend = rate / g.crouch_time, bend / g.crouch_time**2
        way = np.array([0.0, 0.0, self._height - g.depth - self._above])
        goal = base + np.array([0.0, 0.0, self._above]) + step * way
        pull = bend * way + g.position * (goal - view.center_of_mass)
        linear = view.mass * (pull + g.velocity * rate * way) - g.velocity * view.linear_momentum
        turning = moments_of_inertia(view) * np.array([0.0, 0.0, g.wind])
        angular = turning * (bend + g.spin * rate) - g.spin * view.angular_momentum
        return self._momenta(view, linear, angular)

    def _push(self, view: BodyView) -> tuple[Objective, ...]:
        """Both momenta rise evenly to those wanted at take-off."""
        g, elapsed = self._gains, view.time - self._since
        share = min(1.0, elapsed / g.rise)
        hastening = (min(1.0, (elapsed + view.horizon) / g.rise) - share) / view.horizon
        linear = view.mass * np.array(g.launch)
        rate = g.turn / self._airtime(view, g.launch[2])
        angular = np.array([0.0, 0.0, moments_of_inertia(view)[2] * rate])
        return self._momenta(
            view,
            hastening * linear + g.push * (share * linear - view.linear_momentum),
            hastening * angular + g.push_spin * (share * angular - view.angular_momentum),
        )

    def _momenta(
        self, view: BodyView, linear: FloatArray, angular: FloatArray
    ) -> tuple[Objective, ...]:
        g = self._gains
        return (
            objectives.linear_momentum(view, linear, g.momentum_weight),
            objectives.angular_momentum(view, angular, g.spin_weight),
        )

    def _airtime(self, view: BodyView, speed: float) -> float:
        """Seconds until a body that rises at a speed, m/s, lands at its landing height."""
        gravity = objectives.weight_of(view) / view.mass
        drop = float(view.center_of_mass[2]) - self._ground - self._gains.height
        return (speed + float(np.sqrt(max(speed**2 + 2.0 * gravity * drop, 0.0)))) / gravity

    def _fly(self, view: BodyView) -> tuple[Objective, ...]:
        """The base comes, level, to where it is to land as seen from the centre of mass."""
        g, middle = self._gains, view.masses / view.mass
        reach = self._reach(view)
        across = mean_weights(view, (self._base,)) - middle
        parts = [(across, axis) for axis in (0, 1)]
        parts += [(mean_weights(view, (name,)) - middle, 2) for name in self._patches]
        rows, target = np.zeros((len(parts), view.node_count, 3)), np.zeros(len(parts))
        for number, (weights, axis) in enumerate(parts):
            rows[number, :, axis] = weights
            target[number] = g.reach_rate * (reach[axis] - weights @ view.positions[:, axis])
        share = 1.0 / BodyUnits.of(view).speed
        return (
            Objective(
                name="reach",
                rows=share * rows.reshape(len(parts), -1),
                target=share * target,
                weight=np.asarray(g.reach_weight),
            ),
        )

    def _reach(self, view: BodyView) -> FloatArray:
        """Base relative to the centre of mass at landing, (3,) m.

        It lands the wanted way ahead, but within play of the capture point.
        """
        g, speed = self._gains, view.linear_momentum / view.mass
        landing = view.center_of_mass + self._airtime(view, float(speed[2])) * speed
        wanted = self._first[:2] + (self._done + 1) * np.array(g.way) - landing[:2]
        capture = np.sqrt(g.height * view.mass / objectives.weight_of(view)) * speed[:2]
        near = np.clip(wanted, capture - g.play, capture + g.play)
        return np.array([*near, -g.height])
