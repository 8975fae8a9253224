"""Controllers that note when they are asked, and views to ask them with."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from tests.support.bodies import muscular_bar
from warp_softbody import Plane, Scene, Simulation
from warp_softbody.controllers import ActivationCost, Goals, Sequence, objectives
from warp_softbody.world.view import BodyView

BAR = muscular_bar()
DT = 1.0 / 60.0


class Noted:
    """Wants the momentum to rise by a rate, and notes when it is asked."""

    def __init__(self, rate: float = 0.0) -> None:
        """A rate, N."""
        self.rate = rate
        self.times: list[float] = []
        self.heights: list[float] = []
        self.interruptible = True

    def goals(self, view: BodyView) -> Goals:
        """The momentum along x."""
        self.times.append(view.time)
        self.heights.append(float(view.center_of_mass[2]))
        wanted = objectives.linear_momentum(view, np.array([self.rate, 0.0, 0.0]))
        return Goals(objectives=(wanted,), activation=ActivationCost(effort=1.0 + self.rate))


class Ending(Noted):
    """Ends by itself after two steps."""

    @property
    def finished(self) -> bool:
        """Whether it was asked twice of its own motion."""
        return len(self.times) >= 2


def view_at(time: float, shift: float = 0.0) -> BodyView:
    """The bar at a time, s, moved along x by a way, m."""
    own = Simulation(Scene(character=BAR, ground=Plane()), time_step=DT).view()
    moved = own.positions + np.array([shift, 0.0, 0.0])
    return replace(own, time=time, positions=moved)


def shown(sequence: Sequence, steps: int, shift: Callable[[int], float] = lambda _: 0.0) -> Any:
    """Goals of steps one after the other."""
    return [sequence.goals(view_at(DT * k, shift(k))) for k in range(steps)]
