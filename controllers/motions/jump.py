"""Jumps: crouch, push off, fly, land (docs/method.md section 4)."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from enum import Enum

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers import objectives
from warp_softbody.controllers.body_units import BodyUnits, dimension, in_si
from warp_softbody.controllers.controller import ActivationCost, Goals, seen
from warp_softbody.controllers.motions.balance import Balance, BalanceGains
from warp_softbody.controllers.motions.body_measures import BASE_PATCHES, mean_weights, region_mean
from warp_softbody.controllers.motions.trajectories import eased_change, smooth_step
from warp_softbody.controllers.objectives import Objective
from warp_softbody.controllers.patches import ground_patches
from warp_softbody.inputs import checks, input_kinds
from warp_softbody.world.view import BodyView

Vector = tuple[float, float, float]


class JumpPhase(Enum):
    """What a jumper is doing."""

    STAND = "stand"
    CROUCH = "crouch"
    PUSH = "push"
    FLY = "fly"
    LAND = "land"


@dataclass(frozen=True, kw_only=True)
class JumpGains:
    """Gains, weights and timing of a jump, in units of the body (`BodyUnits`).

    Attributes:
        depth: L, how far the centre of mass is lowered before the jump.
        lean: (x, y) L, how far it is shifted from the middle of the base meanwhile.
        pitch: rad, by which the body is tipped forward meanwhile.
        wind: rad, by which it is turned about the vertical meanwhile.
        crouch_time: sqrt(L/g).
        launch: sqrt(g L), wanted velocity of the centre of mass at take-off.
        push: sqrt(g/L), how fast momentum is to come near that of the launch.
        rise: sqrt(L/g), in which the wanted velocity comes up to that of the launch; 0 for at once.
        push_time: sqrt(L/g), longest push; then the jump counts as failed and the body balances.
        position: Kp, g/L, of the centre of mass while crouching.
        velocity: Kd, sqrt(g/L), of the same.
        spin: sqrt(g/L), decay of angular momentum.
        turn: m g L, rate of angular momentum about the vertical wanted in the push.
        momentum_weight: of the linear momentum, in units of m g dt.
        spin_weight: of the angular momentum, in units of m g L dt.
        reach: (x, y, z) L, base relative to the centre of mass wanted in the air; z below.
        reach_rate: sqrt(g/L), how fast it is to come there.
        reach_weight: of that velocity, in units of sqrt(g L).
        rest_time: sqrt(L/g), between landing and the next jump.
        activation: cost of effort and change while jumping.
        landing: gains of the balance before and after it.
        ease: by how much more than one a change costs at landing, as a factor.
        ease_time: sqrt(L/g), after which it costs as usual.
    """

    depth: float = field(default=0.12, metadata=dimension(length=1.0))
    lean: tuple[float, float] = field(default=(0.0, 0.0), metadata=dimension(length=1.0))
    pitch: float = 0.0
    wind: float = 0.0
    crouch_time: float = field(default=1.566, metadata=dimension(time=1.0))
    launch: Vector = field(default=(0.0, 0.0, 0.6386), metadata=dimension(length=1.0, time=-1.0))
    push: float = field(default=6.386, metadata=dimension(time=-1.0))
    rise: float = field(default=0.0, metadata=dimension(time=1.0))
    push_time: float = field(default=1.566, metadata=dimension(time=1.0))
    position: float = field(default=4.587, metadata=dimension(time=-2.0))
    velocity: float = field(default=2.873, metadata=dimension(time=-1.0))
    spin: float = field(default=2.554, metadata=dimension(time=-1.0))
    turn: float = field(default=0.0, metadata=dimension(length=1.0))
    momentum_weight: float = 1.0
    spin_weight: float = 20.0
    reach: Vector = field(default=(0.0, 0.0, -0.49), metadata=dimension(length=1.0))
    reach_rate: float = field(default=2.554, metadata=dimension(time=-1.0))
    reach_weight: float = 9.81
    rest_time: float = field(default=3.132, metadata=dimension(time=1.0))
    activation: ActivationCost = field(
        default_factory=lambda: ActivationCost(effort=0.015, change=0.006264)
    )
    landing: BalanceGains = field(default_factory=BalanceGains)
    ease: float = 0.0
    ease_time: float = field(default=0.9396, metadata=dimension(time=1.0))

    def __post_init__(self) -> None:
        """Refuse gains that are not finite or out of their range."""
        checks.settle(
            self,
            positive=("crouch_time", "push_time"),
            not_negative=(
                *("push", "rise", "position", "velocity", "spin", "reach_rate"),
                *("momentum_weight", "spin_weight", "reach_weight"),
                *("rest_time", "ease", "ease_time"),
            ),
            finite=("depth", "pitch", "wind", "turn"),
            vectors=("launch", "reach"),
        )
        checks.keep(self, lean=checks.vector("JumpGains.lean", self.lean, 2, unit="L"))
        checks.instance("JumpGains.activation", self.activation, ActivationCost)
        checks.instance("JumpGains.landing", self.landing, BalanceGains)


class Jump:
    """Jumps a number of times and keeps its balance before, between and after."""

    def __init__(
        self,
        gains: JumpGains | None = None,
        *,
        jumps: int = 1,
        start: float = 1.566,
        base: str = "base",
        patches: tuple[str, ...] = BASE_PATCHES,
    ) -> None:
        """Jump from a base region, ``start`` sqrt(L/g) after the run begins."""
        self._gains = checks.optional("gains of Jump", gains, JumpGains)
        self._jumps = checks.whole("jumps of Jump", jumps)
        self._base = input_kinds.name("base of Jump", base)
        self._patches = input_kinds.names("patches of Jump", patches)
        self._balance = Balance(self._gains.landing, base=base, patches=patches)
        self.phase = JumpPhase.STAND
        self._since = 0.0
        self._wait = checks.number("start of Jump", start, low=0.0, unit="sqrt(L/g)")
        self._done = 0
        self._units: BodyUnits | None = None
        self._height: float | None = None

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
        self._advance(view)
        if self.phase is JumpPhase.CROUCH:
            return self._wanted(view, self._crouch(view, base), grounded=True)
        if self.phase is JumpPhase.PUSH:
            return self._wanted(view, self._push(view), grounded=True)
        if self.phase is JumpPhase.FLY:
            return self._wanted(view, self._fly(view), grounded=False)
        goals = self._balance.goals(view)
        return replace(goals, activation=self._eased(view.time, goals.activation))

    def _eased(self, time: float, usual: ActivationCost) -> ActivationCost:
        g, elapsed = self._gains, time - self._since
        if self.phase is not JumpPhase.LAND or elapsed >= g.ease_time:
            return usual
        return eased_change(usual, g.ease, elapsed / g.ease_time)

    def _advance(self, view: BodyView) -> None:
        g, elapsed = self._gains, view.time - self._since
        airborne = not view.touching.any()
        if self.phase in (JumpPhase.STAND, JumpPhase.LAND):
            if elapsed >= self._wait and self._done < self._jumps:
                self._enter(JumpPhase.CROUCH, view)
        elif self.phase is JumpPhase.CROUCH:
            if elapsed >= g.crouch_time:
                self._enter(JumpPhase.PUSH, view)
        elif self.phase is JumpPhase.PUSH:
            if airborne:
                self._enter(JumpPhase.FLY, view)
            elif elapsed >= g.push_time:
                self._land(view)
        elif not airborne and view.linear_momentum[2] < 0.0:
            self._land(view)

    def _enter(self, phase: JumpPhase, view: BodyView) -> None:
        self.phase = phase
        self._since = view.time

    def _land(self, view: BodyView) -> None:
        self._enter(JumpPhase.LAND, view)
        self._wait = self._gains.rest_time
        self._done += 1

    def _wanted(self, view: BodyView, wanted: tuple[Objective, ...], *, grounded: bool) -> Goals:
        patches = ground_patches(view, self._patches) if grounded else ()
        return Goals(objectives=wanted, patches=patches, activation=self._gains.activation)

    def _crouch(self, view: BodyView, base: FloatArray) -> tuple[Objective, ...]:
        """The centre of mass goes down and ahead on a planned way."""
        g = self._gains
        assert self._height is not None
        step, rate, bend = smooth_step((view.time - self._since) / g.crouch_time)
        rate, bend = rate / g.crouch_time, bend / g.crouch_time**2
        way = np.array([*g.lean, -g.depth])
        goal = base + np.array([0.0, 0.0, self._height]) + step * way
        pull = bend * way + g.position * (goal - view.center_of_mass)
        linear = view.mass * (pull + g.velocity * rate * way) - g.velocity * view.linear_momentum
        turning = _inertias(view) * np.array([0.0, g.pitch, g.wind])
        angular = turning * (bend + g.spin * rate) - g.spin * view.angular_momentum
        return self._momenta(view, linear, angular)

    def _push(self, view: BodyView) -> tuple[Objective, ...]:
        g = self._gains
        share = (view.time - self._since) / g.rise if g.rise > 0.0 else 1.0
        step, rate, _ = smooth_step(share)
        launch = view.mass * np.array(g.launch)
        hastening = rate / g.rise * launch if g.rise > 0.0 else 0.0
        momentum = hastening + g.push * (step * launch - view.linear_momentum)
        spin = -g.spin * view.angular_momentum
        spin[2] = step * g.turn * view.weight
        return self._momenta(view, momentum, spin)

    def _momenta(
        self, view: BodyView, linear: FloatArray, angular: FloatArray
    ) -> tuple[Objective, ...]:
        g = self._gains
        return (
            objectives.linear_momentum(view, linear, g.momentum_weight),
            objectives.angular_momentum(view, angular, g.spin_weight),
        )

    def _fly(self, view: BodyView) -> tuple[Objective, ...]:
        g = self._gains
        weights = mean_weights(view, (self._base,)) - view.masses / view.mass
        way = g.reach_rate * (np.array(g.reach) - weights @ view.positions)
        return (objectives.velocity(view, weights, way, g.reach_weight),)


def _inertias(view: BodyView) -> FloatArray:
    """(3,) kg m^2: moments of inertia about the axes through the centre of mass."""
    squares = (view.positions - view.center_of_mass) ** 2
    return np.asarray(view.masses @ (squares.sum(axis=1, keepdims=True) - squares))
