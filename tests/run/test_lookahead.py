"""Plans that look further ahead than a short step: the same plan, and a part of the way to it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from warp_softbody import (
    ControlOptions,
    Plane,
    Scene,
    Simulation,
    characters,
    controllers,
    scenes,
)
from warp_softbody.arrays import FloatArray
from warp_softbody.controllers import ActivationCost, Goals, objectives
from warp_softbody.controllers.control_solver import Decision
from warp_softbody.controllers.inner_controllers import says
from warp_softbody.controllers.motions.body_measures import mean_weights
from warp_softbody.controllers.motions.sequence import Sequence
from warp_softbody.errors import InputError
from warp_softbody.run.lookahead import steps_ahead
from warp_softbody.run.step_record import StepRecord
from warp_softbody.world.similar_scene import Similarity, similar_scene
from warp_softbody.world.view import BodyView

LETTER = characters.letter_i(coarse=1)
SCENE = Scene(character=LETTER, ground=Plane())
FREE = Scene(character=LETTER)
STEP = 1.0 / 60.0
MOTIONS = [
    name
    for name in scenes.names()
    if (controller := scenes.make(name).controller) is not None
    and not says(controller, "plans_single_steps")
]


class Shortens:
    """Wants the head to come down over the base, by a tenth of the letter's height."""

    def goals(self, view: BodyView) -> Goals:
        """A velocity in proportion to what is left of the way."""
        weights = mean_weights(view, ("head",)) - mean_weights(view, ("base",))
        rest = weights @ LETTER.mesh.points
        way = 3.0 * (np.array([1.0, 1.0, 0.9]) * rest - weights @ view.positions)
        return Goals(
            objectives=(objectives.velocity(view, weights, way),),
            activation=ActivationCost(effort=1e-3, change=1e-3),
        )


def decisions(share: float, steps: int, options: ControlOptions | None = None) -> list[Decision]:
    """Of the first steps of a share of 1/60 s each."""
    simulation = Simulation(
        FREE, Shortens(), time_step=share * STEP, fps=60.0, control_options=options
    )
    found: list[StepRecord] = []
    simulation.observe(found.append)
    for _ in range(steps):
        simulation.step()
    made = [record.decision for record in found]
    assert all(decision is not None for decision in made)
    return [decision for decision in made if decision is not None]


@pytest.mark.parametrize("name", MOTIONS)
def test_shipped_steps_are_the_horizon(name: str) -> None:
    """And shorter steps a whole part of it, so that motions ship as they did without."""
    plan = scenes.make(name)
    horizon = ControlOptions().horizon
    found = [steps_ahead(horizon, plan.scene, plan.time_step / share) for share in (0.5, 1, 2, 4)]
    assert found == [1, 1, 2, 4]
    assert steps_ahead(0.0, plan.scene, plan.time_step / 4.0) == 1


@pytest.mark.parametrize("length", [0.1, 10.0])
def test_the_horizon_is_in_units_of_the_body(length: float) -> None:
    similar = Similarity(length=length)
    scene = similar_scene(SCENE, similar)
    for share in (1, 2, 5):
        step = STEP / share
        assert steps_ahead(0.0522, scene, similar.time * step) == share


@pytest.mark.parametrize("share", [2, 4])
def test_a_short_step_goes_a_part_of_the_way_of_the_same_plan(share: int) -> None:
    """At the same state, in the first step, matrix, gaps and costs are those of the horizon."""
    (whole,), (part,) = decisions(1.0, 1), decisions(1.0 / share, 1)
    assert part.view.horizon == pytest.approx(whole.view.time_step)
    assert part.view.time_step == pytest.approx(whole.view.time_step / share)
    np.testing.assert_allclose(part.maps.muscle_map, whole.maps.muscle_map, rtol=1e-4, atol=1e-6)
    np.testing.assert_allclose(part.maps.compliance, whole.maps.compliance, rtol=1e-4, atol=1e-7)
    np.testing.assert_allclose(part.result.controls, whole.result.controls, atol=1e-4)
    np.testing.assert_allclose(part.lengths_ahead, whole.rest_lengths, rtol=1e-4)
    begun = part.view.activations
    gone = part.rest_lengths / part.maps.rest_lengths - begun
    np.testing.assert_allclose(gone, (part.result.controls - begun) / share, atol=1e-6)
    assert np.abs(gone).max() > 1e-3


@pytest.mark.parametrize("within", [False, True])
def test_a_motion_may_ask_for_plans_of_single_steps(within: bool) -> None:
    plan = scenes.make("flip-i")
    controller = plan.controller
    assert controller is not None
    if within:
        controller = Sequence([controller])
    simulation = Simulation(plan.scene, controller, time_step=plan.time_step, fps=60.0)
    found: list[StepRecord] = []
    simulation.observe(found.append)
    simulation.step()
    assert found[0].decision is not None
    assert found[0].decision.view.horizon == found[0].decision.view.time_step


def test_without_a_horizon_a_plan_is_for_its_step() -> None:
    (own,) = decisions(0.25, 1, ControlOptions(horizon=0.0))
    assert own.view.horizon == own.view.time_step
    np.testing.assert_array_equal(own.lengths_ahead, own.rest_lengths)


def muscles_after(share: int) -> FloatArray:
    """Activations 0.2 s on."""
    return decisions(1.0 / share, 12 * share)[-1].view.activations


def test_motions_have_a_limit_in_the_time_step() -> None:
    """Activations of shorter steps come together, at the rate of a method of first order."""
    coarse, middle, fine = (muscles_after(share) for share in (2, 4, 8))
    first, second = np.abs(middle - coarse).max(), np.abs(fine - middle).max()
    assert second < 0.75 * first < 0.02


def test_a_saved_motion_goes_on_to_the_last_bit() -> None:
    def made() -> Simulation:
        return Simulation(SCENE, controllers.Balance(), time_step=STEP / 3.0, fps=60.0)

    def places(simulation: Simulation) -> list[FloatArray]:
        found = []
        for _ in range(5):
            simulation.step()
            found.append(simulation.state.positions.numpy().copy())
        return found

    simulation = made()
    places(simulation)
    saved = simulation.save()
    once = places(simulation)
    for other in (simulation, made()):
        other.restore(saved)
        for one, again in zip(once, places(other), strict=True):
            np.testing.assert_array_equal(one, again)


def test_a_motion_of_another_horizon_is_refused() -> None:
    """Its plans and its solver's memory are of a step of another length."""

    def made(options: ControlOptions) -> Simulation:
        return Simulation(
            SCENE, controllers.Balance(), time_step=STEP / 3.0, fps=60.0, control_options=options
        )

    saved = made(ControlOptions()).save()
    with pytest.raises(InputError, match=r"look 3 time steps ahead .* look 1 ahead; .*horizon"):
        made(ControlOptions(horizon=0.0)).restore(saved)
    # two horizons of the same number of steps are one
    made(ControlOptions(horizon=0.0523)).restore(saved)


def test_what_is_reached_is_told_at_the_horizon() -> None:
    """A plan for a quarter of the step is compared with where the body is on its way to."""
    simulation = Simulation(FREE, Shortens(), time_step=STEP / 4.0, fps=60.0)
    for _ in range(40):
        simulation.step()
    down = simulation.goal_report().outcomes[2]
    assert down.reached == pytest.approx(down.planned, abs=0.1 * abs(down.wanted))


def test_a_view_carries_numbers_on_to_the_horizon() -> None:
    view = decisions(1.0, 1)[0].view
    now, soon = np.array([1.0, 2.0]), np.array([1.5, 2.0])
    assert view.at_horizon(now, soon) is soon
    ahead = replace(view, steps_ahead=3)
    np.testing.assert_allclose(ahead.at_horizon(now, soon), [2.5, 2.0])
    assert ahead.horizon == pytest.approx(3.0 * view.time_step)
