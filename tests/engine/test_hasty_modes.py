"""Large bodies seek contact modes by few iterations: fewer in all, for the same motion."""

from __future__ import annotations

import numpy as np
import pytest

import warp_softbody as wsb
from warp_softbody.engine.step_statistics import StepStatistics
from warp_softbody.kernels.contact.stages import ALL_PASSES

STEPS = 60
"""The cube lands in the twelfth, rolls on its edge and slides."""


def dropped(**options: object) -> wsb.Simulation:
    plan = wsb.scenes.make("drop-block", {"cells": 7})
    wanted = wsb.SimulationOptions(time_step=plan.time_step, sleep=False, **options)  # type: ignore[arg-type]
    return wsb.Simulation(plan.scene, options=wanted)


def slid(simulation: wsb.Simulation) -> tuple[list[StepStatistics], float]:
    """Statistics of the steps, and the way of the cube, m."""
    seen: list[StepStatistics] = []
    simulation.observe(lambda step: seen.append(step.statistics))
    masses = simulation.model.masses
    for _ in range(STEPS):
        simulation.step()
    return seen, float(masses @ simulation.state.positions.numpy()[:, 0] / masses.sum())


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_fewer_iterations_lead_as_far(precision: str) -> None:
    hasty, way = slid(dropped(precision=precision))
    # with so few passes a solver is not hasty; none of the steps needs as many
    patient, known = slid(dropped(precision=precision, max_contact_passes=ALL_PASSES - 1))
    assert max(step.passes for step in patient) < ALL_PASSES - 1
    assert all(step.contact_converged and step.converged for step in hasty)
    spent, before = (sum(step.iterations for step in seen) for seen in (hasty, patient))
    assert spent < 0.8 * before
    # both end each step with laws and equations to the same tolerances
    assert way == pytest.approx(known, rel=5e-3)
    laws = [step.coulomb for step in hasty]
    assert max(laws) < 2.0 * max(step.coulomb for step in patient) + 1e-3


def test_a_motion_that_was_kept_goes_on_as_hastily() -> None:
    """To the last bit: what the last step took belongs to the motion."""
    first, second = dropped(), dropped()
    for _ in range(STEPS // 2):
        first.step()
    second.restore(first.save())
    for simulation in (first, second):
        for _ in range(3):
            simulation.step()
    one, other = (own.state.positions.numpy() for own in (first, second))
    np.testing.assert_array_equal(one, other)
