"""Plans beside steps: against the impulses of the contact solver, and what is told of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import warp_softbody as wsb
from warp_softbody.controllers.control_solver import Decision
from warp_softbody.run import plan_log
from warp_softbody.run.plan_log import PlanMisses
from warp_softbody.run.plan_outcome import plan_outcome
from warp_softbody.run.recorded_step import StepMeter
from warp_softbody.run.step_record import StepRecord

PUSHED_FROM = 0.52
"""s; letter I is pushed from 0.5 on."""


def test_momenta_of_plan_and_step_add_up(monkeypatch: pytest.MonkeyPatch) -> None:
    """The step's by the forces of the contact solver, the plan's by those of its patches."""
    monkeypatch.setattr(plan_log, "EVERY", 2)
    plan = wsb.scenes.make("balance-i")
    simulation = wsb.Simulation(plan.scene, plan.controller, time_step=plan.time_step)
    recorder, meter = wsb.Recorder(simulation), StepMeter(simulation.model)
    checked: list[float] = []

    def check(step: StepRecord) -> None:
        decision = step.decision
        assert decision is not None
        view, dt = decision.view, decision.view.time_step
        pushes = np.array(step.control.external_forces.numpy(), dtype=float)
        velocities = np.array(step.state.velocities.numpy(), dtype=float)
        outcome = plan_outcome(decision, velocities, pushes)
        arms = view.positions - view.center_of_mass
        outer = dt * (view.mass * np.array(view.scene.gravity) + pushes.sum(axis=0))
        turn = dt * np.cross(arms, pushes).sum(axis=0)
        size, numbers = view.weight * dt, meter.measure(step)[0]
        force = numbers["contact_force"][0]
        # in single precision, and where a step ends before it has settled
        np.testing.assert_allclose(
            outcome.momentum, view.linear_momentum + outer + dt * force, atol=2e-4 * size
        )
        assert outcome.share == pytest.approx(force[2] / view.weight, abs=1e-4)
        planned = decision.planned
        impulses = dt * planned.forces
        turned = np.cross(planned.points - view.center_of_mass, impulses).sum(axis=0)
        expected = view.linear_momentum + outer + impulses.sum(axis=0)
        np.testing.assert_allclose(outcome.momentum_planned, expected, atol=1e-9 * size)
        spin = view.angular_momentum + turn + turned
        np.testing.assert_allclose(outcome.spin_planned, spin, atol=1e-9 * size)
        off = np.linalg.norm(outcome.momentum - outcome.momentum_planned)
        assert outcome.momentum_miss == pytest.approx(off / size)
        checked.append(float(np.abs(pushes).max()))

    simulation.observe(check)
    while simulation.time < PUSHED_FROM:
        simulation.step()
    assert checked[0] == 0.0 and checked[-1] > 0.0
    _the_record_holds_the_same(recorder, simulation)


def _the_record_holds_the_same(recorder: wsb.Recorder, simulation: wsb.Simulation) -> None:
    arrays, plans = recorder.arrays(), simulation.summary().plans
    assert plans is not None and plans.steps == len(recorder) // 2
    assert plans.momentum == pytest.approx(np.median(arrays["plan/momentum_miss"][1::2]))
    assert plans.cost == pytest.approx(np.median(arrays["plan/cost_miss"][1::2]))
    assert ("plans", str(plans)) in simulation.summary().lines()
    np.testing.assert_allclose(
        np.linalg.norm(arrays["plan/momentum"] - arrays["momentum"][:, 0], axis=1),
        arrays["plan/momentum_miss"] * simulation.model.masses.sum() * 9.81 / 60.0,
        atol=1e-4,
    )


def test_spin_is_that_of_the_record_to_rounding() -> None:
    """About the centre of mass at the start of a step as at its end, as nodes go straight."""
    plan = wsb.scenes.make("balance-i")
    simulation = wsb.Simulation(plan.scene, plan.controller, time_step=plan.time_step)
    meter = StepMeter(simulation.model)
    off: list[float] = []

    def check(step: StepRecord) -> None:
        assert step.decision is not None
        velocities = np.array(step.state.velocities.numpy(), dtype=float)
        spin = plan_outcome(step.decision, velocities, np.zeros_like(velocities)).spin
        found = meter.measure(step)[0]["angular_momentum"][0]
        off.append(float(np.abs(spin - found).max()))

    simulation.observe(check)
    for _ in range(4):
        simulation.step()
    assert max(off) < 1e-4 * simulation.model.masses.sum()


def test_where_nodes_are_held_momenta_are_not_told() -> None:
    plan = wsb.scenes.make("balance-i")
    simulation = wsb.Simulation(plan.scene, plan.controller, time_step=plan.time_step)
    seen: list[Decision] = []
    simulation.observe(lambda step: seen.append(step.decision) if step.decision else None)
    simulation.step()
    mesh = plan.scene.character.mesh
    fixed = replace(plan.scene.character, fixed=np.array([3]))
    view = replace(seen[0].view, scene=replace(plan.scene, character=fixed))
    outcome = plan_outcome(
        replace(seen[0], view=view), seen[0].view.velocities, np.zeros_like(mesh.points)
    )
    assert np.isnan(outcome.momentum_miss) and np.isfinite(outcome.cost_miss)


def test_few_and_small_misses_are_no_doubt() -> None:
    assert not list(PlanMisses(steps=50, momentum=0.5, cost=0.8).doubts())
    assert not list(PlanMisses(steps=2, momentum=2.0, cost=1.0).doubts())
    assert not list(PlanMisses(steps=50, momentum=None, cost=0.8).doubts())
    doubts = list(PlanMisses(steps=50, momentum=1.5, cost=0.995).doubts())
    assert "by more than 150 % of m g dt" in doubts[0] and "99.5 %" in doubts[1]


def test_a_passive_run_tells_nothing_of_plans() -> None:
    plan = wsb.scenes.make("drop-block", {"cells": 3})
    simulation = wsb.Simulation(plan.scene, plan.controller, time_step=plan.time_step)
    simulation.step()
    assert simulation.summary().plans is None
    assert "plans" not in dict(simulation.summary().lines())
