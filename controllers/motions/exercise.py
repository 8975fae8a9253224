"""Exercise: the centre of mass follows a path while the feet stay (docs/method.md section 4)."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers import objectives
from warp_softbody.controllers.arguments import remembered
from warp_softbody.controllers.body_units import BodyUnits, dimension, in_si
from warp_softbody.controllers.controller import ActivationCost, Goals, seen
from warp_softbody.controllers.motions.body_measures import BASE_PATCHES
from warp_softbody.controllers.motions.tracking import MissingRate, following
from warp_softbody.controllers.motions.trajectories import smooth_step
from warp_softbody.controllers.patches import ground_patches
from warp_softbody.inputs import checks, input_kinds
from warp_softbody.world.view import BodyView


@dataclass(frozen=True, kw_only=True)
class Sway:
    """A sine along x that grows at the start and dies away after some periods.

    Given in units of the body (`BodyUnits`); `at` reckons in the units of its fields.

    Attributes:
        amplitude: L.
        period: sqrt(L/g).
        periods: how many.
        ease: sqrt(L/g), over which it grows, and dies away.
    """

    amplitude: float = field(default=0.1, metadata=dimension(length=1.0))
    period: float = field(default=6.264, metadata=dimension(time=1.0))
    periods: float = 4.0
    ease: float = field(default=1.566, metadata=dimension(time=1.0))

    def __post_init__(self) -> None:
        """Refuse times that are not positive and an amplitude that is not finite."""
        checks.settle(self, positive=("period", "periods", "ease"), finite=("amplitude",))

    def at(self, time: float) -> FloatArray:
        """Place, velocity and acceleration along x at a time from its start."""
        rate = 2.0 * math.pi / self.period
        sine, cosine = math.sin(rate * time), math.cos(rate * time)
        wave = self.amplitude * np.array([sine, rate * cosine, -(rate**2) * sine])
        end = self.period * self.periods
        size = np.subtract(smooth_step(time / self.ease), smooth_step((time - end) / self.ease))
        size *= np.array([1.0, 1.0 / self.ease, 1.0 / self.ease**2])
        return np.array(
            [
                size[0] * wave[0],
                size[0] * wave[1] + size[1] * wave[0],
                size[0] * wave[2] + 2.0 * size[1] * wave[1] + size[2] * wave[0],
            ]
        )


@dataclass(frozen=True, kw_only=True)
class ExerciseGains:
    """Gains and weights of following a path, in units of the body (`BodyUnits`).

    Attributes:
        position: Kp, g/L, of the distance from the path.
        velocity: Kd, sqrt(g/L), of the difference from the path's velocity.
        spin: sqrt(g/L), decay of angular momentum.
        learning: sqrt(L/g), within which it is learnt what momentum a plan misses.
        momentum_weight: of the linear momentum, in units of m g dt.
        spin_weight: of the angular momentum, in units of m g L dt.
        activation: cost of effort and change.
    """

    position: float = field(default=40.79, metadata=dimension(time=-2.0))
    velocity: float = field(default=12.77, metadata=dimension(time=-1.0))
    spin: float = field(default=6.5, metadata=dimension(time=-1.0))
    learning: float = field(default=0.157, metadata=dimension(time=1.0))
    momentum_weight: float = 1.0
    spin_weight: float = 5.0
    activation: ActivationCost = field(
        default_factory=lambda: ActivationCost(effort=0.5, change=0.25)
    )

    def __post_init__(self) -> None:
        """Refuse gains that are not finite or out of their range."""
        weights = ("momentum_weight", "spin_weight")
        checks.settle(self, not_negative=("position", "velocity", "spin", "learning", *weights))
        checks.instance("ExerciseGains.activation", self.activation, ActivationCost)


@remembered
class Exercise:
    """Moves the centre of mass along a path from where it is in the first step."""

    def __init__(
        self,
        gains: ExerciseGains | None = None,
        *,
        path: Sway | None = None,
        start: float = 1.566,
        patches: tuple[str, ...] = BASE_PATCHES,
    ) -> None:
        """Follow the path from ``start`` sqrt(L/g) on, thinking of the ground through patches."""
        self._gains = checks.optional("gains of Exercise", gains, ExerciseGains)
        self._path = checks.optional("path of Exercise", path, Sway)
        self._start = checks.number("start of Exercise", start, low=0.0, unit="sqrt(L/g)")
        self._patches = input_kinds.names("patches of Exercise", patches)
        self._units: BodyUnits | None = None
        self._origin = np.zeros(3)
        self._finished = False
        self._missing = MissingRate(self._gains.learning)

    @property
    def finished(self) -> bool:
        """Whether the path has died away."""
        return self._finished

    def goals(self, view: BodyView) -> Goals:
        """Objectives of the step from ``view`` on."""
        view = seen(view)
        if self._units is None:
            self._units = BodyUnits.of(view)
            self._gains = in_si(self._gains, self._units)
            self._path = in_si(self._path, self._units)
            self._start *= self._units.time
            self._missing = MissingRate(self._gains.learning)
            self._origin = view.center_of_mass
        g, path = self._gains, self._path
        self._finished = view.time >= self._start + path.period * path.periods + path.ease
        rate = self._missing.made_up(view, self._along(view))
        return Goals(
            objectives=(
                objectives.linear_momentum(view, rate, g.momentum_weight),
                objectives.angular_momentum(view, -g.spin * view.angular_momentum, g.spin_weight),
            ),
            patches=ground_patches(view, self._patches),
            activation=g.activation,
        )

    def _along(self, view: BodyView) -> FloatArray:
        """Rate of momentum (3,) N that keeps to the path."""
        times = view.time + view.horizon * np.array([-1.0, 0.0, 1.0]) - self._start
        path = np.tile(self._origin, (3, 1))
        path[:, 0] += [self._path.at(time)[0] for time in times]
        return following(view, path, self._gains.position, self._gains.velocity)
