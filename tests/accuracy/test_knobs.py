"""Knobs of charts: the options that they stand for, and what must not depend on them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from warp_softbody import scenes
from warp_softbody.accuracy.cases.settings import KNOBS, OPTIONS, Settings
from warp_softbody.accuracy.runs.job import Job
from warp_softbody.accuracy.runs.running import run_job
from warp_softbody.controllers import ContactQPCC
from warp_softbody.controllers.control_options import ControlOptions
from warp_softbody.controllers.control_solver import ControlSolver
from warp_softbody.engine.model import build_model
from warp_softbody.engine.options import SimulationOptions
from warp_softbody.engine.reduced_dynamics import ReducedDynamics
from warp_softbody.engine.state import State
from warp_softbody.engine.stepper import Stepper
from warp_softbody.run.simulation import Simulation

PLAIN = Settings(time_step=1.0 / 60.0)


def test_every_knob_is_an_option_or_of_the_scene() -> None:
    assert set(KNOBS) - set(OPTIONS) == {"cells", "level", "patches"}
    assert set(OPTIONS) <= set(KNOBS)


def test_knobs_are_the_options_that_they_stand_for() -> None:
    turned = replace(PLAIN, qps=3, plan_cone=4, preconditioner="two-level", tolerance=1e-3)
    expected = ControlOptions(max_qps=3, planned_cone=4)
    assert turned.control_options() == expected
    assert turned.options() == SimulationOptions(
        time_step=1.0 / 60.0,
        precision="float32",
        elements="linear",
        tangent="warped",
        preconditioner="two_level",
        tolerance=1e-3,
    )
    assert PLAIN.control_options() == ControlOptions()
    assert turned.differences(PLAIN) == "tolerance 0.001, QPs 3, planned cone 4, two-level"


def first_plan(settings: Settings) -> ContactQPCC:
    """The first QPCC of the crawler, as its controller plans it from rest."""
    plan = settings.plan("crawl-i", {})
    assert plan.controller is not None
    simulation = Simulation(plan.scene, plan.controller, options=settings.options())
    for _ in range(32):
        simulation.step()
    model = build_model(plan.scene, settings.options())
    stepper, state, view = Stepper(model), State.at_rest(model), simulation.view()
    state.positions.assign(view.positions)
    stepper.assemble(state)
    solver = ControlSolver(plan.controller, ReducedDynamics(stepper), settings.control_options())
    goals = solver.goals(view)
    assert goals is not None
    return solver.decide(view, goals).problem


def test_the_planned_cone_has_fewer_directions() -> None:
    """Of the crawler, whose friction depends on the direction, every second factor is left."""
    eight, four = (first_plan(replace(PLAIN, plan_cone=cone)) for cone in (None, 4))
    assert len(eight.directions) == 8 and len(four.directions) == 4
    np.testing.assert_array_equal(four.directions, eight.directions[::2])
    assert eight.factors[0].max() > 9.0 * eight.factors[0].min()
    np.testing.assert_array_equal(four.factors[0], eight.factors[0][::2])


def test_a_preconditioner_changes_the_way_not_the_answer() -> None:
    """Both solve to 1e-8 of the right-hand side: what is left differs by no more than rounding."""
    tight = replace(PLAIN, cells=2, precision="float64", tolerance=1e-8)
    jobs = [
        Job(
            scene="cantilever",
            seconds=0.2,
            functionals=("tip_fall",),
            settings=replace(tight, preconditioner=name),
        )
        for name in (None, "factor", "two-level")
    ]
    plain, factor, two_level = (run_job(job) for job in jobs)
    # an error of 1e-8 in v of some m/s over 0.2 s, and paths in single precision
    np.testing.assert_allclose(two_level.path, plain.path, atol=2e-7)
    np.testing.assert_array_equal(factor.path, plain.path)
    assert two_level.iterations > 1.5 * factor.iterations
    assert len({job.key for job in jobs}) == 3


@pytest.mark.parametrize("patches", [4, 8])
def test_patches_are_a_setting_of_what_rolls(patches: int) -> None:
    plan = replace(PLAIN, patches=patches).plan("roll-o", {})
    assert plan.settings["patches"] == patches
    assert plan.controller is not None
    simulation = Simulation(plan.scene, plan.controller)
    goals = plan.controller.goals(simulation.view())
    assert goals is not None and len(goals.patches) == patches
    assert "patches" not in {one.name for one in scenes.recipe("balance-i").settings}
