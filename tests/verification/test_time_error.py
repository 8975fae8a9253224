"""A solve that follows the time error: what it adds to a step, and that nothing else changes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.support.bodies import EXACT, Rig, box, numbers, rig
from warp_softbody import scenes
from warp_softbody.arrays import FloatArray
from warp_softbody.body.material import Material
from warp_softbody.engine.options import Precision, SimulationOptions
from warp_softbody.kernels.linear.stopping import TIME_ERROR_SHARE
from warp_softbody.run.simulation import Simulation

GRAVITY = (0.0, 0.0, -9.81)
SOFT = Material(young_modulus=1e5, poisson_ratio=0.4)


def beam(**options: Any) -> Rig:
    mesh = box((8, 2, 2), (0.8, 0.2, 0.2))
    held = np.flatnonzero(mesh.points[:, 0] < 1e-9)
    return rig(mesh, material=SOFT, fixed=held, gravity=GRAVITY, time_step=0.01, **options)


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_the_solve_adds_its_share_of_the_time_error(precision: Precision) -> None:
    """Each step of a falling beam against a direct solve from the same state.

    With r the residual and e the error of v+, e M e <= r M^-1 r <= |r|^2 / min m, as M~ >= M. |r|
    is at most the share of |M (v+ - 2 v + v-)| / 2, or the least tolerance of the right-hand side.
    Rounding adds that of the product M~ v, dt^2 times the row sums of |K|, below 20 E h of this
    mesh, times v and an epsilon for each of eight additions.
    """
    loose, tight = beam(precision=precision), beam(**EXACT)
    masses, dt = loose.masses, 0.01
    floor = loose.model.options.solver_tolerance
    eps = float(np.finfo(np.dtype(precision)).eps)
    before = loose.velocities
    saved = 0
    for _ in range(60):
        now = loose.velocities
        tight.place(positions=loose.positions, velocities=now)
        saved -= loose.step().iterations
        saved += tight.step().iterations
        change = masses[:, None] * (loose.velocities - 2.0 * now + before)
        right = numbers(loose.stepper.contact.right)[~loose.model.fixed]
        rounding = 8.0 * eps * dt**2 * 20.0 * 1e5 * 0.1 * np.linalg.norm(now)
        allowed = max(
            0.5 * TIME_ERROR_SHARE * np.linalg.norm(change), floor * np.linalg.norm(right)
        )
        error = np.sqrt(masses @ ((loose.velocities - tight.velocities) ** 2).sum(axis=1))
        free = masses[~loose.model.fixed]
        assert np.sqrt(free.min()) * error <= allowed + rounding
        before = now
    assert saved > 0


def test_the_start_is_the_last_change_again() -> None:
    """Increments are the change of the velocities, whatever solves them."""
    body = beam()
    for _ in range(3):
        before = body.velocities
        body.step()
        rounding = np.abs(np.concatenate([body.velocities, before])).max() * np.finfo("float32").eps
        np.testing.assert_allclose(
            numbers(body.state.increments), body.velocities - before, rtol=0.0, atol=rounding
        )


def end_of(name: str, seconds: float, **options: Any) -> tuple[FloatArray, Simulation]:
    plan = scenes.make(name, {})
    options = {"time_step": plan.time_step, **options}
    simulation = Simulation(plan.scene, options=SimulationOptions(**options))
    path = [frame.positions for frame in simulation.run(seconds)]
    return np.array(path), simulation


@pytest.mark.parametrize("name", ["cantilever", "twisted-bar", "drop-block", "bounce-ball"])
def test_motions_move_by_a_share_of_what_the_time_step_moves_them(name: str) -> None:
    """Against a tight solve; twice the step is the measure of the time error of the first order."""
    tight, _ = end_of(name, 0.5, tolerance=1e-6, precision="float64")
    double, _ = end_of(name, 0.5, tolerance=1e-6, precision="float64", time_step=1.0 / 60.0)
    found, simulation = end_of(name, 0.5)
    moved = np.sqrt(((found - tight) ** 2).sum(axis=2).mean())
    time_error = np.sqrt(((double - tight) ** 2).sum(axis=2).mean())
    assert moved <= TIME_ERROR_SHARE * time_error
    assert simulation.summary().residuals.median > 1e-5


def test_a_controlled_scene_solves_to_its_tolerance() -> None:
    """What a controller decides hangs on digits."""
    plan = scenes.make("balance-i", {})
    simulation = Simulation(plan.scene, plan.controller, time_step=plan.time_step)
    simulation.step()
    simulation.step()
    summary = simulation.summary()
    assert summary.residuals.median == summary.residuals.p95 == pytest.approx(1e-5)
    assert summary.left_out == ()


def test_the_summary_says_what_was_left_out() -> None:
    _, simulation = end_of("cantilever", 0.1)
    summary = simulation.summary()
    assert summary.left_out == ("muscles", "contact", "control")
    assert 1 <= summary.renewals < 0.1 / summary.time_step
    assert "no muscles, no contact, no control, preconditioner kept in" in str(summary)
