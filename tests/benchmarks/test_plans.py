"""Plans are compared with what the steps really came to."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks import plans
from warp_softbody import scenes
from warp_softbody.engine.options import SimulationOptions
from warp_softbody.run.plan_outcome import PlanOutcome, planned_values
from warp_softbody.run.recorded_step import _activation_cost
from warp_softbody.run.simulation import Simulation
from warp_softbody.run.step_record import StepRecord


def test_what_a_plan_expects_adds_up_to_its_objective() -> None:
    plan = scenes.make("balance-i")
    options = SimulationOptions(time_step=plan.time_step)
    simulation = Simulation(plan.scene, plan.controller, options=options)
    seen: list[tuple[float, float]] = []

    def keep(step: StepRecord) -> None:
        decision = step.decision
        assert decision is not None
        values, begin, cost = planned_values(decision), 0, 0.0
        for goal in decision.goals.objectives:
            end = begin + len(goal.rows)
            cost += float(goal.weight @ (values[begin:end] - goal.target) ** 2)
            begin = end
        planned_feet = values[begin:].reshape(-1, 3)
        gaps = np.array([patch.gap for patch in decision.goals.patches]) / plan.time_step
        np.testing.assert_allclose(
            planned_feet + np.outer(gaps, [1.0, 0.0, 0.0]), decision.result.velocities, atol=1e-9
        )
        chosen = decision.rest_lengths / decision.maps.rest_lengths
        cost += float(sum(_activation_cost(decision.goals, decision, chosen).values()))
        seen.append((cost, decision.result.objective))

    simulation.observe(keep)
    for _ in range(6):
        simulation.step()
    costs, objectives = np.array(seen).T
    # the activations before are kept in single precision: 1e-7 of one, in squares of some 1e-3
    np.testing.assert_allclose(costs, objectives, rtol=3e-4)


def test_a_standing_body_does_what_was_planned(capsys: pytest.CaptureFixture[str]) -> None:
    found = plans.misses("balance-i", 0.25)
    standing = plans.by_phase(found)["standing"]
    assert np.median([one.outcome.momentum_miss for one in standing]) < 0.02
    assert np.median([one.outcome.feet_miss for one in standing]) < 0.005
    costs = [(one.outcome.planned, one.outcome.reached, one.outcome.cost_miss) for one in found]
    assert np.isfinite(costs).all()
    plans.main(["--scenes", "balance-i", "--seconds", "0.1"])
    assert "| `balance-i` | standing |" in capsys.readouterr().out


def test_plots_have_the_cost_of_plans_and_steps() -> None:
    none = np.zeros(3)
    outcome = PlanOutcome(
        time=0.5,
        momentum_planned=none,
        momentum=none,
        spin_planned=none,
        spin=none,
        share_planned=0.0,
        share=0.0,
        momentum_miss=0.1,
        feet_miss=0.0,
        planned=0.02,
        reached=0.03,
    )
    assert outcome.cost_miss == pytest.approx(1.0 / 3.0)
    costs, off = plans.plots("balance-i", [plans.PlanMiss(phase="standing", outcome=outcome)])
    assert set(costs.columns) == {"planned", "reached"} and set(off.columns) >= {"momentum"}
