"""Balance: linear and angular momentum and the base (METHOD section 4; TRIAL's gains)."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from warp_softbody.controllers import objectives
from warp_softbody.controllers.controller import ActivationCost, Goals
from warp_softbody.controllers.patches import ground_patches
from warp_softbody.view import BodyView


@dataclass(frozen=True, kw_only=True)
class BalanceGains:
    """Gains and weights of the balance controller.

    Attributes:
        position: Kp, 1/s^2, pull of the centre of mass towards its place above the base.
        velocity: Kd, 1/s, decay of linear momentum.
        spin: 1/s, decay of angular momentum.
        momentum_weight: of the linear momentum, in units of m g dt.
        spin_weight: of the angular momentum, in units of m g dt times 1 m.
        base_weight: of the base's relative area, s^2; 0 leaves the term out.
        base_rate: 1/s, wanted relative growth of the base while the body is disturbed.
        activation: cost of effort and change.
    """

    position: float = 15.0
    velocity: float = 8.0
    spin: float = 6.0
    momentum_weight: float = 1.0
    spin_weight: float = 40.0
    base_weight: float = 0.0
    base_rate: float = 0.0
    activation: ActivationCost = field(default_factory=ActivationCost)


class Balance:
    """Keeps the centre of mass above the middle of the nominal base and the body from turning."""

    def __init__(
        self,
        gains: BalanceGains | None = None,
        *,
        base: str = "base",
        patches: tuple[str, ...] = ("base_patch_0", "base_patch_1", "base_patch_2", "base_patch_3"),
    ) -> None:
        """Balance on a base region, thinking of the ground through patch regions of it."""
        self._gains = gains or BalanceGains()
        self._base = base
        self._patches = patches
        self._height: float | None = None
        self._triangles: np.ndarray[tuple[int, ...], np.dtype[np.int32]] | None = None

    def goals(self, view: BodyView) -> Goals:
        """Objectives of the step from ``view`` on."""
        g = self._gains
        nodes = view.scene.character.region(self._base)
        target = view.positions[nodes].mean(axis=0)
        if self._height is None:
            self._height = float((view.center_of_mass - target)[2])
        target[2] += self._height
        pull = view.mass * g.position * (target - view.center_of_mass)
        rate = pull - g.velocity * view.linear_momentum
        wanted = [
            objectives.linear_momentum(view, rate, g.momentum_weight),
            objectives.angular_momentum(view, -g.spin * view.angular_momentum, g.spin_weight),
        ]
        if g.base_weight > 0.0:
            wanted.append(self._widen(view))
        return Goals(
            objectives=tuple(wanted),
            patches=ground_patches(view, self._patches),
            activation=g.activation,
        )

    def _widen(self, view: BodyView) -> objectives.Objective:
        if self._triangles is None:
            surface = view.scene.character.mesh.surface
            inside = np.isin(surface, view.scene.character.region(self._base)).all(axis=1)
            self._triangles = surface[inside]
        return objectives.base_area(
            view, self._triangles, self._gains.base_rate, self._gains.base_weight
        )
