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
            leaves the term out.
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
            positive=("relax_within",),
            not_negative=(
                "position",
                "velocity",
                "spin",
                "upright",
                "upright_weight",
                "momentum_weight",
                "spin_weight",
                "base_weight",
                "relax",
            ),
            finite=("crouch", "base_rate"),
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
        offset = self._capture_offset(view, target)
        target[2] += self._height - min(g.crouch * offset, 0.3 * self._height)
        pull = view.mass * g.position * (target - view.center_of_mass)
        rate = pull - g.velocity * view.linear_momentum
        wanted = [
            objectives.linear_momentum(view, rate, g.momentum_weight),
            objectives.angular_momentum(view, -g.spin * view.angular_momentum, g.spin_weight),
        ]
        if g.upright_weight > 0.0:
            wanted.append(self._upright(view))
        if g.base_weight > 0.0:
            wanted.append(self._widen(view, g.base_rate * offset))
        return Goals(
            objectives=tuple(wanted),
            patches=ground_patches(view, self._patches),
            activation=self._relaxed(offset),
        )

    def _upright(self, view: BodyView) -> objectives.Objective:
        """The head comes back to where it was over the base at rest; its height is left free."""
        g, points = self._gains, view.scene.character.mesh.points
        weights = mean_weights(view, (self._head,)) - mean_weights(view, (self._base,))
        own = slice(len(points))
        way = g.upright * (weights[own] @ (points - view.positions[own]))
        unit = float(np.linalg.norm(view.scene.gravity)) * view.time_step
        level = g.upright_weight * np.array([1.0, 1.0, 0.0])
        return objectives.velocity(view, weights, way, level, unit=unit)

    def _relaxed(self, offset: float) -> ActivationCost:
        g = self._gains
        share = max(0.0, 1.0 - offset / g.relax_within)
        return replace(g.activation, effort=g.activation.effort * (1.0 + g.relax * share))

    def _capture_offset(self, view: BodyView, base: np.ndarray[tuple[int, ...], Any]) -> float:
        """Horizontal distance (m) of the capture point c + v sqrt(h / g) from the base's middle."""
        gravity = float(np.linalg.norm(view.scene.gravity))
        height = max(
            float((view.center_of_mass - base)[2]), LEAST_HEIGHT * BodyUnits.of(view).length
        )
        speed = view.linear_momentum / view.mass
        ahead = view.center_of_mass - base + speed * np.sqrt(height / max(gravity, 1e-6))
        return float(np.hypot(ahead[0], ahead[1]))

    def _widen(self, view: BodyView, growth: float) -> objectives.Objective:
        if self._triangles is None:
            surface = view.scene.character.mesh.surface
            inside = np.isin(surface, view.scene.character.region(self._base)).all(axis=1)
            self._triangles = surface[inside]
        return objectives.base_area(view, self._triangles, growth, self._gains.base_weight)
