"""Activations that a controller has in mind: changes are counted from them."""

from __future__ import annotations

import numpy as np
import pytest

from warp_softbody import Plane, Scene, Simulation, SimulationOptions
from warp_softbody.arrays import FloatArray
from warp_softbody.characters import letter_i
from warp_softbody.controllers import ActivationCost, Goals, ground_patches
from warp_softbody.controllers.motions.body_measures import BASE_PATCHES
from warp_softbody.errors import InputError
from warp_softbody.world.view import BodyView

COUNT = letter_i(coarse=2).segment_count
NOMINAL = tuple(np.linspace(0.7, 0.95, COUNT).tolist())


class Holding:
    """Wants nothing but its activations, and remembers those that it saw."""

    def __init__(self, nominal: tuple[float, ...], cost: ActivationCost) -> None:
        """Of these activations, at these costs."""
        self.nominal, self.cost = nominal, cost
        self.seen: list[FloatArray] = []

    def goals(self, view: BodyView) -> Goals:
        """The step's."""
        self.seen.append(view.activations.copy())
        patches = ground_patches(view, BASE_PATCHES)
        return Goals(objectives=(), patches=patches, activation=self.cost, nominal=self.nominal)


def run(controller: Holding, *, native_code: bool = True, seconds: float = 0.3) -> FloatArray:
    """The positions at the end."""
    simulation = Simulation(
        Scene(character=letter_i(coarse=2), ground=Plane()),
        controller,
        options=SimulationOptions(time_step=1.0 / 60.0, native_code=native_code),
        fps=60.0,
    )
    *_, last = simulation.run(seconds)
    return last.positions


@pytest.mark.parametrize("native_code", [True, False])
def test_they_are_taken_where_nothing_else_is_wanted(native_code: bool) -> None:
    controller = Holding(NOMINAL, ActivationCost(effort=0.0, change=1.0))
    run(controller, native_code=native_code)
    # a segment is never told to be longer than it is
    assert (controller.seen[-1] <= np.array(NOMINAL) + 1e-6).all()
    assert np.median(np.abs(controller.seen[-1] - NOMINAL)) < 1e-6


def test_effort_draws_them_towards_slack() -> None:
    """The least of e (a - 1)^2 + c (a - n)^2, with the costs of a step."""
    cost = ActivationCost(effort=0.5, change=0.02)
    controller = Holding(NOMINAL, cost)
    run(controller)
    change = cost.change / ((1.0 / 60.0) / np.sqrt(1.0 / 9.81))
    least = (cost.effort + change * np.array(NOMINAL)) / (cost.effort + change)
    assert np.median(np.abs(controller.seen[-1] - least)) < 1e-5


def test_there_is_one_for_each_segment() -> None:
    with pytest.raises(InputError, match=r"Goals.nominal must have \d+ activations, one for each"):
        run(Holding((0.9, 0.9), ActivationCost()))
    with pytest.raises(InputError, match=r"Goals.nominal\[1\] must be"):
        Goals(objectives=(), nominal=(0.9, 1.5))
