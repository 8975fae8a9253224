"""Knobs inside the engine: what they set, that it is set back, and what must not depend on them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from warp_softbody import scenes
from warp_softbody.accuracy.cases.settings import Settings
from warp_softbody.accuracy.runs.inner_knobs import inner_knobs
from warp_softbody.accuracy.runs.job import Job
from warp_softbody.accuracy.runs.running import run_job
from warp_softbody.controllers import ContactQPCC, solve_qpcc
from warp_softbody.controllers import control_solver as driver
from warp_softbody.engine import linear_system as system
from warp_softbody.run.simulation import Simulation

PLAIN = Settings(time_step=1.0 / 60.0)


def test_all_are_set_back_after_an_error() -> None:
    before = (
        driver.STEP_OPTIONS,
        driver.CALM_OPTIONS,
        driver.build_qpcc,
        system.MOST_FACTOR_BLOCKS,
    )
    turned = replace(PLAIN, qps=3, plan_cone=4, preconditioner="two-level")
    with pytest.raises(RuntimeError), inner_knobs(turned):
        assert driver.STEP_OPTIONS.max_qps == driver.CALM_OPTIONS.max_qps == 3
        assert driver.build_qpcc is not before[2] and system.MOST_FACTOR_BLOCKS == 0
        raise RuntimeError
    after = (
        driver.STEP_OPTIONS,
        driver.CALM_OPTIONS,
        driver.build_qpcc,
        system.MOST_FACTOR_BLOCKS,
    )
    assert after == before
    with inner_knobs(PLAIN):
        assert driver.build_qpcc is before[2]


def test_the_planned_cone_has_fewer_directions(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of the crawler, whose friction depends on the direction, every second factor is left."""
    seen: list[ContactQPCC] = []

    def spy(qpcc: ContactQPCC, **more: Any) -> Any:
        seen.append(qpcc)
        return solve_qpcc(qpcc, **more)

    monkeypatch.setattr(driver, "solve_qpcc", spy)
    first: list[ContactQPCC] = []
    for directions in (None, 4):
        seen.clear()
        settings = replace(PLAIN, plan_cone=directions)
        with inner_knobs(settings):
            plan = settings.plan("crawl-i", {})
            simulation = Simulation(plan.scene, plan.controller, options=settings.options())
            for _ in range(32):
                simulation.step()
        first.append(seen[0])
    eight, four = first
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
