"""Rolling: fall ahead of the contact, over and over (docs/method.md section 4)."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from warp_softbody.controllers import objectives
from warp_softbody.controllers.controller import ActivationCost, Goals
from warp_softbody.controllers.patches import Patch, patch_of
from warp_softbody.view import BodyView

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int32]


@dataclass(frozen=True, kw_only=True)
class RollGains:
    """Gains and weights of rolling along x.

    Attributes:
        lead: m, how far ahead of the contact the centre of mass is wanted.
        position: Kp, 1/s^2, of the centre of mass.
        velocity: Kd, 1/s, of linear momentum.
        spin: m g times 1 m, wanted rate of angular momentum about the axis.
        steadiness: 1/s, decay of angular momentum about the other axes, and about all in a stop.
        top_speed: m/s, of the centre of mass, at which the wanted rate has fallen to zero.
        spin_weight: of the angular momentum, in units of m g dt times 1 m.
        momentum_weight: of the linear momentum, in units of m g dt.
        activation: cost of effort and change.
    """

    lead: float = 0.1
    position: float = 15.0
    velocity: float = 5.0
    spin: float = 0.1
    steadiness: float = 5.0
    top_speed: float = 1.5
    spin_weight: float = 5.0
    momentum_weight: float = 1.0
    activation: ActivationCost = field(
        default_factory=lambda: ActivationCost(effort=0.02, change=5.0)
    )


@dataclass(frozen=True)
class Leg:
    """A stretch of time: direction +1 or -1 along x, 0 to stop, None to be passive."""

    seconds: float
    direction: float | None


class Roll:
    """Rolls leg by leg; afterwards passive."""

    def __init__(self, gains: RollGains | None = None, *, legs: tuple[Leg, ...], rim: str) -> None:
        """Roll on the nodes of a region ``rim`` that touch."""
        self._gains = gains or RollGains()
        self._legs = legs
        self._rim = rim
        self._height: float | None = None

    def goals(self, view: BodyView) -> Goals | None:
        """Objectives of the step from ``view`` on; None where the leg is passive."""
        direction = self._direction(view.time)
        if direction is None:
            return None
        g = self._gains
        nodes = self._contact(view)
        middle = view.positions[nodes].mean(axis=0)
        if self._height is None:
            self._height = float(view.center_of_mass[2] - middle[2])
        goal = middle + np.array([direction * g.lead, 0.0, self._height])
        pull = view.mass * g.position * (goal - view.center_of_mass)
        rate = pull - g.velocity * view.linear_momentum
        speed = direction * view.linear_momentum[0] / view.mass
        spin = -g.steadiness * view.angular_momentum
        if direction:
            eager = float(np.clip(1.0 - speed / g.top_speed, -1.0, 1.0))
            spin[1] = direction * eager * g.spin * view.weight
        return Goals(
            objectives=(
                objectives.linear_momentum(view, rate, g.momentum_weight),
                objectives.angular_momentum(view, spin, g.spin_weight),
            ),
            patches=split(view, nodes),
            activation=g.activation,
        )

    def _direction(self, time: float) -> float | None:
        for leg in self._legs:
            if time < leg.seconds:
                return leg.direction
            time -= leg.seconds
        return None

    def _contact(self, view: BodyView) -> IntArray:
        """Nodes of the rim that touch; while none does, the lowest ones."""
        rim = view.scene.character.region(self._rim)
        touching = rim[view.touching[rim]]
        if len(touching):
            return np.asarray(touching)
        heights = view.positions[rim, 2]
        return np.asarray(rim[heights <= heights.min() + 1e-3])


def split(view: BodyView, nodes: IntArray, columns: int = 3) -> tuple[Patch, ...]:
    """Patches of touching nodes: stretches along x, each in two halves across y."""
    ground = view.scene.ground
    if ground is None:
        return ()
    gaps, normals = ground.measure(view.positions[nodes])
    x, y, _ = view.positions[nodes].T
    edges = np.linspace(x.min() - 1e-9, x.max() + 1e-9, columns + 1)
    column = np.searchsorted(edges, x, side="right") - 1
    part = 2 * column + (y <= view.center_of_mass[1])
    return tuple(
        patch_of(view, ground, nodes[part == k], gaps[part == k], normals[part == k])
        for k in np.unique(part)
    )
