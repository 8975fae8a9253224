"""How near the steps of a run come to their plans, told in its summary."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from warp_softbody.device.host_view import HostViews
from warp_softbody.engine.state import Control, State
from warp_softbody.run.controlled_body import seen_part
from warp_softbody.run.plan_outcome import plan_outcome
from warp_softbody.world.scene import Scene

if TYPE_CHECKING:
    from warp_softbody.controllers.control_solver import Decision

EVERY = 23
"""Of so many planned steps one is compared, as that takes a seventh of a small body's step; no gait
repeats in so many."""

LEAST_STEPS = 5
"""Fewer compared steps say too little to doubt a run."""

MOST_MOMENTUM = 0.75
"""Median miss of the momentum, of m g dt, beyond which plans have little to do with their steps."""

MOST_COST = 0.99
"""Median miss of the cost beyond which plans have little to do with their steps."""


@dataclass(frozen=True, kw_only=True)
class PlanMisses:
    """How far the steps of a run end from their plans.

    Attributes:
        steps: that were compared.
        momentum: median of |planned less realised momentum| over m g dt; None where handles or
            fixed nodes have a part in it.
        cost: median of |planned less reached cost| over the larger of both.
    """

    steps: int
    momentum: float | None
    cost: float

    def __str__(self) -> str:
        """One line of a summary."""
        momentum = "" if self.momentum is None else f"momentum by {100 * self.momentum:.2g} %, "
        return (
            f"missed in {momentum}cost by {100 * self.cost:.2g} % (medians of {self.steps} steps)"
        )

    def doubts(self) -> Iterator[str]:
        """Sentences where plans say little about what is done."""
        if self.steps < LEAST_STEPS:
            return
        found = {
            "the momentum of half of them by more than {} % of m g dt": (
                0.0 if self.momentum is None else self.momentum,
                MOST_MOMENTUM,
            ),
            "the cost of half of them by more than {} %": (self.cost, MOST_COST),
        }
        for what, (miss, most) in found.items():
            if not miss <= most:
                yield (
                    f"steps end elsewhere than planned, {what.format(f'{100 * miss:.3g}')}: take a "
                    "smaller time step, or patches for all that bears the body"
                )


class PlanLog:
    """Compares one of `EVERY` planned steps of a run with its plan."""

    def __init__(self, scene: Scene) -> None:
        """No steps of a scene yet."""
        self._scene = scene
        self._planned = 0
        self._momentum: list[float] = []
        self._cost: list[float] = []
        self._views = HostViews()

    def note(self, decision: Decision, state: State, control: Control) -> None:
        """Count a step that led to a state; compare it if it is its turn."""
        self._planned += 1
        if self._planned % EVERY or not decision.converged:
            return
        nodes, _ = seen_part(self._scene, decision.view)
        velocities = self._views.read(state.velocities)[nodes].astype(np.float64)
        pushes = self._views.read(control.external_forces)[nodes].astype(np.float64)
        outcome = plan_outcome(decision, velocities, pushes)
        self._momentum.append(outcome.momentum_miss)
        self._cost.append(outcome.cost_miss)

    def misses(self) -> PlanMisses | None:
        """Of the steps compared so far; None where there are none."""
        if not self._cost:
            return None
        momentum = float(np.median(self._momentum))
        return PlanMisses(
            steps=len(self._cost),
            momentum=momentum if np.isfinite(momentum) else None,
            cost=float(np.median(self._cost)),
        )
