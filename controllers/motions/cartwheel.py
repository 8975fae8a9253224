"""Cartwheels: turning about y over limbs that stand in turn (docs/method.md section 4)."""

from __future__ import annotations

import math

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.controllers import objectives
from warp_softbody.controllers.arguments import remembered
from warp_softbody.controllers.body_units import BodyUnits, in_si
from warp_softbody.controllers.controller import Goals, seen
from warp_softbody.controllers.motions.any_body import require_muscles
from warp_softbody.controllers.motions.body_measures import (
    angle_turned,
    mean_weights,
    moments_of_inertia,
)
from warp_softbody.controllers.motions.cartwheel_gains import CartwheelGains
from warp_softbody.controllers.motions.for_any_body.support import hull
from warp_softbody.controllers.motions.limb_feet import FEET, Feet, checked_feet, feet_around
from warp_softbody.controllers.motions.tracking import MissingRate, following
from warp_softbody.controllers.objectives import Objective
from warp_softbody.controllers.patches import Patch, ground_patches
from warp_softbody.inputs import checks
from warp_softbody.world.view import BodyView

THERE = 0.1
"""rad from the end of the turn within which the body has arrived."""

WAITING = 6.0
"""How much faster than it comes up the plan's speed may fall, where it waits for the body."""

STANDING = 2
"""Feet that a plan may use at a time: those that are lowest."""


@remembered
class Cartwheel:
    """Turns over its limbs along x by given turns, and stands.

    A plan turns at a speed that comes up and falls evenly, and waits for a body that is late. With
    its angle go the place of the centre of mass, on by what the body's hull rolls off, and those of
    all feet around it.
    """

    def __init__(
        self,
        gains: CartwheelGains | None = None,
        *,
        turns: int = 1,
        direction: float = 1.0,
        start: float = 1.0,
        feet: Feet = FEET,
    ) -> None:
        """Turn a number of times, from ``start`` sqrt(L/g) on.

        Args:
            gains: None for the usual ones.
            turns: whole ones, so that it stands in the end as it stood.
            direction: 1 along x, -1 against it.
            start: sqrt(L/g), when the plan begins to turn.
            feet: the regions that are the parts of each foot, around the body.
        """
        self._gains = checks.optional("gains of Cartwheel", gains, CartwheelGains)
        self._turn = 2.0 * math.pi * checks.whole("turns of Cartwheel", turns, low=1)
        self._direction = checks.number("direction of Cartwheel", direction)
        if abs(self._direction) != 1.0:
            checks.refuse("direction of Cartwheel", "1 or -1", direction)
        self._start = checks.number("start of Cartwheel", start, low=0.0, unit="sqrt(L/g)")
        self._feet = checked_feet(feet)
        self._missing = MissingRate(self._gains.learning)
        self._units: BodyUnits | None = None
        self._arms = self._first = np.zeros((0, 3))
        self._rolls = 0.0
        # of the plan one horizon before, now and one horizon ahead; at the end of the step
        self._phases, self._soon = (0.0, 0.0, 0.0), 0.0
        self._past: tuple[float, ...] = ()
        self._speed = 0.0
        self._angle = self._begun = 0.0
        self._arrived: float | None = None
        self._rested = False

    @classmethod
    def for_(
        cls,
        character: Character,
        *,
        turns: int = 1,
        direction: float = 1.0,
        gains: CartwheelGains | None = None,
    ) -> Cartwheel:
        """Cartwheels of any body with limbs around y.

        Args:
            character: has three regions `foot_...` or more, around its middle; where a foot has
                parts `foot_..._0` and so on, contacts are these.
            turns: number of them.
            direction: 1 along x, -1 against it.
            gains: None for the usual ones.

        Raises:
            InputError: the body has fewer feet, or no muscles.
        """
        require_muscles("Cartwheel", character)
        return cls(gains, turns=turns, direction=direction, feet=feet_around(character))

    @property
    def phase(self) -> float:
        """By how much the plan has turned, rad, whatever its direction."""
        return self._soon

    @property
    def interruptible(self) -> bool:
        """Whether it stands, before its turns or after them."""
        return self.phase == 0.0 or self._arrived is not None

    @property
    def finished(self) -> bool:
        """Whether it has stood for its time of rest after the last turn."""
        return self._rested

    def goals(self, view: BodyView) -> Goals:
        """Objectives of the step from ``view`` on."""
        view = seen(view)
        if self._units is None:
            self._begin(view, BodyUnits.of(view))
        turned = angle_turned(view, 2, 0) - self._begun
        self._angle += float(np.angle(np.exp(1j * (turned - self._angle))))
        self._go_on(view)
        return Goals(
            objectives=(*self._momenta(view), *self._limbs(view)),
            patches=self._patches(view),
            activation=self._gains.activation,
        )

    def _begin(self, view: BodyView, units: BodyUnits) -> None:
        """Take over the units of the body, its place, and what it rolls off in a turn."""
        self._units = units
        self._gains = g = in_si(self._gains, units)
        self._start *= units.time
        self._missing = MissingRate(g.learning)
        self._first = view.center_of_mass.copy()
        self._begun = angle_turned(view, 2, 0)
        rest = view.scene.character.mesh.points
        self._arms = rest - view.masses[: len(rest)] @ rest / view.mass
        around = hull(rest[:, [0, 2]])
        sides = np.linalg.norm(around - np.roll(around, -1, axis=0), axis=1)
        self._rolls = float(sides.sum()) / (2.0 * math.pi)

    def _go_on(self, view: BodyView) -> None:
        """Turn the plan by a step, at a speed from which it still can stop at the end."""
        g, dt, now = self._gains, view.time_step, self._soon
        soon = ahead = now
        if view.time >= self._start:
            left = self._turn - now
            wanted = min(g.cruise, math.sqrt(2.0 * g.speedup * max(left, 0.0)))
            if now - self._direction * self._angle > g.lead:
                wanted = 0.0
            change = g.speedup * dt
            self._speed = min(max(wanted, self._speed - WAITING * change), self._speed + change)
            soon = min(self._turn, now + dt * self._speed)
            ahead = min(self._turn, now + view.horizon * self._speed)
        count = view.steps_ahead
        self._past = (*(self._past or (now,) * count), now)[-count - 1 :]
        self._phases, self._soon = (self._past[0], now, ahead), soon
        if soon == self._turn and abs(soon - self._direction * self._angle) < THERE:
            self._arrived = view.time if self._arrived is None else self._arrived
            self._rested = view.time - self._arrived >= g.rest_time

    def _momenta(self, view: BodyView) -> tuple[Objective, Objective]:
        """The centre of mass goes along its path, and the body turns with the plan."""
        g, inertia = self._gains, moments_of_inertia(view)
        path = np.array([self._middle(phase) for phase in self._phases])
        rate = self._missing.made_up(view, following(view, path, g.position, g.velocity))
        wanted = np.array([0.0, inertia[1] * self._rate(view), 0.0])
        angular = -g.turn * self._tipped(view) + g.spin * (wanted - view.angular_momentum)
        ahead = self._direction * self._phases[2] - self._angle
        angular[1] += g.turn * inertia[1] * ahead
        return (
            objectives.linear_momentum(view, rate, g.momentum_weight),
            objectives.angular_momentum(view, angular, g.spin_weight),
        )

    def _rate(self, view: BodyView) -> float:
        """At which the plan turns, rad/s."""
        return self._direction * (self._phases[2] - self._phases[1]) / view.horizon

    def _middle(self, phase: float) -> FloatArray:
        """Where (3,) m the centre of mass is wanted when the plan has turned by a phase."""
        way = self._direction * self._rolls * phase
        low = (1.0 - self._gains.height) * self._first[2]
        return np.asarray(self._first + np.array([way, 0.0, -low]))

    def _tipped(self, view: BodyView) -> FloatArray:
        """By what (3,) kg m^2 the body has turned about x and z, times moments of inertia."""
        arms = self._arms @ _turn_about_y(self._begun + self._angle).T
        own = slice(len(arms))
        moments = (view.masses[own, None] * arms).T @ (view.positions[own] - view.center_of_mass)
        across = moments - moments.T
        return np.array([across[1, 2], 0.0, across[0, 1]])

    def _limbs(self, view: BodyView) -> tuple[Objective, ...]:
        """The feet come to where the plan has them, seen from the centre of mass, in its plane."""
        g, unit = self._gains, view.gravity * view.horizon
        turn = _turn_about_y(self._begun + self._direction * self._phases[2])
        spin, middle = np.array([0.0, self._rate(view), 0.0]), view.masses / view.mass
        target = []
        for parts in self._feet:
            weights = mean_weights(view, parts) - middle
            arm = turn @ (weights[: len(self._arms)] @ self._arms)
            speed = np.cross(spin, arm) + g.limb_rate * (arm - weights @ view.positions)
            target.append(speed[[0, 2]] / unit)
        rows = view.kept(("limbs", self._feet), lambda: self._limb_rows(view) / unit)
        weight = np.full(2 * len(self._feet), g.limb_weight)
        return (Objective(name="limbs", rows=rows, target=np.concatenate(target), weight=weight),)

    def _limb_rows(self, view: BodyView) -> FloatArray:
        """Velocities along x and z of all feet from the centre of mass, (2 feet, 3n)."""
        middle = view.masses / view.mass
        feet = (mean_weights(view, parts) - middle for parts in self._feet)
        return np.concatenate([objectives.mean_rows(view, own)[[0, 2]] for own in feet])

    def _patches(self, view: BodyView) -> tuple[Patch, ...]:
        """The parts of the feet that are lowest."""
        heights = [
            min(float(view.positions[view.scene.character.region(part), 2].min()) for part in parts)
            for parts in self._feet
        ]
        lowest = sorted(np.argsort(heights, kind="stable")[:STANDING].tolist())
        return ground_patches(view, tuple(part for foot in lowest for part in self._feet[foot]))


def _turn_about_y(angle: float) -> FloatArray:
    """Matrix (3, 3) that turns z towards x by an angle, rad."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
