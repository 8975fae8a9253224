"""Balance: an upright body, momenta and the base (docs/method.md section 4)."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from warp_softbody.controllers import objectives
from warp_softbody.controllers.body_units import BodyUnits, dimension, in_si
from warp_softbody.controllers.controller import ActivationCost, Goals, seen
from warp_softbody.controllers.motions.body_measures import BASE_PATCHES, mean_weights, region_mean
from warp_softbody.controllers.patches import ground_patches
from warp_softbody.inputs import checks, input_kinds
from warp_softbody.world.view import BodyView

SKIP_DEPTH = 0.45
"""Share of its height at rest by which a skipping body wants to shorten: more than it can."""
SKIP_WEIGHT = 20.0
"""Of the head's height in a skip, over `BalanceGains.upright_weight`."""
SKIP_ACCELERATION = 8.0
"""g, of the head against the base in a skip: enough to lift the edge that a body stands on."""

LEAST_HEIGHT = 1e-3
"""L, of the centre of mass above the base, with which a lying body's capture point is reckoned."""


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
                "squat",
                "momentum_weight",
                "spin_weight",
                "base_weight",
                "relax",
            ),
            finite=("crouch", "base_rate", "follow", "lean", "least_height"),
        )
        checks.instance("BalanceGains.activation", self.activation, ActivationCost)


class Balance:
    """Keeps the head and the centre of mass above the base and the body from turning."""

    def __init__(
        self,
        gains: BalanceGains | None = None,
        *,
        base: str = "base",
        head: str = "head",
        patches: tuple[str, ...] = BASE_PATCHES,
    ) -> None:
        """Balance on a base region, thinking of the ground through patch regions of it.

        The region ``head`` is asked for only where `BalanceGains.upright_weight` is positive.
        """
        self._gains = checks.optional("gains of Balance", gains, BalanceGains)
        self._base = input_kinds.name("base of Balance", base)
        self._head = input_kinds.name("head of Balance", head)
        self._patches = input_kinds.names("patches of Balance", patches)
        self._units: BodyUnits | None = None
        self._height: float | None = None
        self._triangles: np.ndarray[tuple[int, ...], np.dtype[np.int32]] | None = None

    def goals(self, view: BodyView) -> Goals:
        """Objectives of the step from ``view`` on."""
        view = seen(view)
        if self._units is None:
            self._units = BodyUnits.of(view)
            self._gains = in_si(self._gains, self._units)
        g = self._gains
        target = region_mean(view, view.positions, self._base)
        if self._height is None:
            self._height = float((view.center_of_mass - target)[2])
        ahead = self._capture_point(view, target)
        offset = float(np.hypot(*ahead))
        target[2] += self._height - min(g.crouch * offset, 0.3 * self._height)
        pull = view.mass * g.position * (target - view.center_of_mass)
        rate = pull - g.velocity * view.linear_momentum
        wanted = [
            objectives.linear_momentum(view, rate, g.momentum_weight),
            objectives.angular_momentum(view, -g.spin * view.angular_momentum, g.spin_weight),
        ]
        if g.upright_weight > 0.0:
            wanted.append(self._upright(view, ahead, offset))
        if g.base_weight > 0.0:
            wanted.append(self._widen(view, g.base_rate * offset))
        return Goals(
            objectives=tuple(wanted),
            patches=ground_patches(view, self._patches),
            activation=self._relaxed(offset),
        )

    def _upright(
        self, view: BodyView, ahead: np.ndarray[tuple[int, ...], Any], offset: float
    ) -> objectives.Objective:
        """The head comes back to its place over the base, at the height that is wanted."""
        g, points = self._gains, view.scene.character.mesh.points
        weights = mean_weights(view, (self._head,)) - mean_weights(view, (self._base,))
        rest, now = weights[: len(points)] @ points, weights @ view.positions
        rows = objectives.mean_rows(view, weights).reshape(3, -1, 3)
        slopes = g.follow * rest[2] * self._slopes(view)
        rows[:2, :, 2] += slopes
        way = g.upright * (rest - now)
        way[:2] -= g.upright * (slopes @ view.positions[:, 2] + g.lean * ahead)
        skips = offset > g.skip_from
        way[2] = self._rising(view, weights, rest[2], offset, skips=skips)
        height = SKIP_WEIGHT if skips else g.height_weight
        unit = float(np.linalg.norm(view.scene.gravity)) * view.time_step
        return objectives.Objective(
            name="upright",
            rows=rows.reshape(3, -1) / unit,
            target=way / unit,
            weight=g.upright_weight * np.array([1.0, 1.0, height]),
        )

    def _rising(
        self,
        view: BodyView,
        weights: np.ndarray[tuple[int, ...], Any],
        rest: float,
        offset: float,
        *,
        skips: bool,
    ) -> float:
        """The wanted speed (m/s) at which the head rises over the base."""
        g = self._gains
        squat = rest - min(g.squat * offset, (1.0 - g.least_height) * rest)
        goal = (1.0 - SKIP_DEPTH) * rest if skips else squat
        speed = float((weights @ view.velocities)[2])
        share = SKIP_ACCELERATION if skips else g.height_acceleration
        change = share * float(np.linalg.norm(view.scene.gravity)) * view.time_step
        wanted = g.height_rate * (goal - float((weights @ view.positions)[2]))
        return min(max(wanted, speed - change), speed + change)

    def _slopes(self, view: BodyView) -> np.ndarray[tuple[int, ...], Any]:
        """Weights (2, n), 1/m, of the nodes' heights in the slopes of the base along x and y."""
        character = view.scene.character
        nodes = character.region(self._base)
        around = character.mesh.points[nodes, :2] - character.mesh.points[nodes, :2].mean(axis=0)
        slopes = np.zeros((2, view.node_count))
        slopes[:, nodes] = (around / np.square(around).sum(axis=0)).T
        return slopes

    def _relaxed(self, offset: float) -> ActivationCost:
        g = self._gains
        share = max(0.0, 1.0 - offset / g.relax_within)
        return replace(g.activation, effort=g.activation.effort * (1.0 + g.relax * share))

    def _capture_point(
        self, view: BodyView, base: np.ndarray[tuple[int, ...], Any]
    ) -> np.ndarray[tuple[int, ...], Any]:
        """Where (2,) m the capture point c + v sqrt(h / g) is, from the base's middle."""
        gravity = float(np.linalg.norm(view.scene.gravity))
        height = max(
            float((view.center_of_mass - base)[2]), LEAST_HEIGHT * BodyUnits.of(view).length
        )
        speed = view.linear_momentum / view.mass
        ahead = view.center_of_mass - base + speed * np.sqrt(height / max(gravity, 1e-6))
        return np.asarray(ahead[:2])

    def _widen(self, view: BodyView, growth: float) -> objectives.Objective:
        if self._triangles is None:
            surface = view.scene.character.mesh.surface
            inside = np.isin(surface, view.scene.character.region(self._base)).all(axis=1)
            self._triangles = surface[inside]
        return objectives.base_area(view, self._triangles, growth, self._gains.base_weight)
