"""A body that nothing touches keeps its momentum, or gains what gravity and pushes give it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.support.bodies import box, muscular_bar, numbers, rig
from tests.verification.conservation.flight import (
    GRAVITY,
    MOST,
    PRECISIONS,
    Flight,
    flights,
    mean_velocity,
)
from warp_softbody import Material, Scene, Simulation, SimulationOptions, characters
from warp_softbody.engine.options import TANGENTS, Precision, Tangent

STEPS = 60


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("flight", flights(14, seed=11), ids=str)
def test_momentum_of_a_flight(flight: Flight, precision: Precision) -> None:
    """Whatever its stiffness and damping, its speed and place, and the step."""
    body = flight.rig(precision)
    start = mean_velocity(body)
    body.step(STEPS)
    seconds = STEPS * flight.time_step
    fall = GRAVITY * seconds * flight.gravity
    missed = mean_velocity(body) - start + (0.0, 0.0, fall)
    scale = max(flight.speed, fall)
    # velocities are read in the run's precision, each rounded
    rounding = np.finfo(precision).eps * scale
    assert np.linalg.norm(missed) <= MOST[precision] * scale * seconds + rounding


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize(
    ("young_modulus", "cells", "damping"),
    [(1e7, 7, 0.05), (1e7, 7, 0.0), (1e7, 2, 0.05), (5e5, 4, 1.0), (1e10, 7, 0.05)],
)
def test_a_stiff_cube_keeps_its_speed(
    young_modulus: float, cells: int, damping: float, precision: Precision
) -> None:
    """A second at 6 m/s: in single precision the mass was lost beside the stiffness."""
    flight = Flight(young_modulus, 0.3, damping, cells, 1.0 / 120.0, 0.0, 6.0, False)
    body = flight.rig(precision)
    body.step(120)
    assert mean_velocity(body)[0] == pytest.approx(6.0, rel=MOST[precision])


@pytest.mark.parametrize("precision", PRECISIONS)
def test_a_fine_body_in_short_steps(precision: Precision) -> None:
    """20,000 tets, two levels, 100 m/s: what a step adds is 1e-5 of the speed."""
    flight = Flight(1e6, 0.3, 0.05, 15, 1e-4, 0.0, 100.0, True)
    body = flight.rig(precision)
    body.step(10)
    fall = -GRAVITY * 10 * flight.time_step
    np.testing.assert_allclose(mean_velocity(body), (100.0, 0.0, fall), atol=100 * 1e-8)


@pytest.mark.parametrize("precision", PRECISIONS)
def test_rounding_of_velocities_does_not_add_up(precision: Precision) -> None:
    """In steps of 1e-4 s gravity adds 129 roundings of a speed of 100 m/s, less a part of one.

    Every step would round it alike, so that 1e-3 of the fall went missing.
    """
    flight = Flight(1e5, 0.3, 0.05, 2, 1e-4, 0.0, 100.0, True)
    body = flight.rig(precision)
    body.place(velocities=(0.0, 0.0, -100.0))
    body.step(1000)
    gained = mean_velocity(body)[2] + 100.0
    assert gained == pytest.approx(-GRAVITY * 0.1, rel=1e-5)


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("tolerance", [None, 1e-3])
def test_inner_loads_move_no_free_body(precision: Precision, tolerance: float | None) -> None:
    """Letter X, half of its segments held at 0.7, however loosely its solves end."""
    body = rig(
        characters.letter_x(), precision=precision, time_step=1.0 / 60.0, tolerance=tolerance
    )
    count = body.model.segment_count
    share = np.where(np.arange(count) < count // 2, 0.7, 1.0)
    body.activate(share)
    body.step(5)
    assert np.abs(body.velocities).max() > 0.1
    body.step(55)
    inertia = body.masses @ ((body.positions - body.center) ** 2).sum(axis=1)
    spin = np.linalg.norm(body.angular_momentum) / inertia
    assert spin < {"float32": 1e-6, "float64": 1e-13}[precision]
    assert np.linalg.norm(mean_velocity(body)) < {"float32": 1e-8, "float64": 1e-14}[precision]


@pytest.mark.parametrize("options", [{"newton_iterations": 2}, {"tangent": "conserving"}, {}])
def test_a_push_gives_its_impulse(options: dict[str, Any]) -> None:
    """Muscles, a push on a few nodes, gravity and damping of the mass, together."""
    material = Material(young_modulus=2e5, poisson_ratio=0.4, mass_damping=0.3)
    body = rig(muscular_bar(material), gravity=(0.0, 0.0, -GRAVITY), **options)
    body.activate(0.8)
    forces = np.zeros_like(body.positions)
    forces[:5] = (30.0, -10.0, 20.0)
    body.push(forces)
    dt, mass = body.model.options.time_step, body.masses.sum()
    expected = np.zeros(3)
    for _ in range(60):
        body.step()
        given = forces.sum(axis=0) / mass + (0.0, 0.0, -GRAVITY)
        expected = (expected + dt * given) / (1.0 + 0.3 * dt)
    np.testing.assert_allclose(mean_velocity(body), expected, rtol=1e-5, atol=1e-6)
    assert np.linalg.norm(numbers(body.state.carry)) < 1e-5 * mass


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("tangent", TANGENTS)
@pytest.mark.parametrize(("young_modulus", "cells"), [(1e4, 3), (1e6, 8), (1e9, 3), (1e9, 8)])
def test_angular_momentum_of_a_flight(
    young_modulus: float, cells: int, tangent: Tangent, precision: Precision
) -> None:
    """A cube at 5 m/s that turns half a time, damped, with a factor and with two levels."""
    flight = Flight(young_modulus, 0.3, 0.05, cells, 1.0 / 120.0, 0.0, 5.0, False)
    body = flight.rig(precision, tangent=tangent)
    arms = body.positions - body.center
    body.place(velocities=np.array([5.0, 0.0, 0.0]) + np.cross([0.0, 1.0, 6.0], arms))
    start = body.angular_momentum
    body.step(60)
    # positions are rounded too: eps of 2.5 m of arms of 0.05 m in every step
    bound = {"float32": 2e-5, "float64": 1e-11}[precision]
    assert np.linalg.norm(body.angular_momentum - start) < bound * np.linalg.norm(start)


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("young_modulus", [1e4, 1e7, 1e9])
def test_a_spinning_flight_gains_no_energy(young_modulus: float, precision: Precision) -> None:
    """Momentum stays and kinetic energy falls, but for the swelling of the step's first order."""
    flight = Flight(young_modulus, 0.3, 0.01, 4, 1e-3, 1.0, 2.0, False)
    body = flight.rig(precision)
    arms = body.positions - body.center
    body.place(velocities=np.array([2.0, 0.0, 0.0]) + np.cross([0.0, 1.0, 3.0], arms))
    start, begun = mean_velocity(body), body.masses @ (body.velocities**2).sum(axis=1)
    for _ in range(10):
        body.step(20)
        assert body.masses @ (body.velocities**2).sum(axis=1) <= begun * (1.0 + 1e-4)
    np.testing.assert_allclose(mean_velocity(body), start, atol=2.0 * MOST[precision])


def test_the_account_of_a_flight_is_balanced() -> None:
    """The summary finds no momentum without a force, and no doubt."""
    scene = Scene(
        character=characters.letter_i(), initial_velocity=(3.0, 0.0, 1.0), gravity=(0, 0, -9.81)
    )
    simulation = Simulation(scene, options=SimulationOptions(time_step=0.01))
    assert len(list(simulation.run(0.5))) == 16
    findings = simulation.summary().findings
    assert findings.momentum_error < 1e-6 and findings.doubts == ()


def test_the_account_sees_what_the_balance_does_not_mend() -> None:
    """Negative control: velocities that are tampered with are momentum from nowhere."""
    body = rig(box(), precision="float64", gravity=(0.0, 0.0, -GRAVITY))
    body.step()
    assert np.linalg.norm(body.stepper.account().missing) < 1e-12
    body.stepper.contact.launch_account(body.contacts)
    body.stepper.contact.change.assign(numbers(body.stepper.contact.change) + 0.1)
    body.stepper.contact.launch_account(body.contacts)
    missing = body.stepper.account().missing
    np.testing.assert_allclose(missing[0], 0.1 * body.masses.sum() * np.ones(3), rtol=1e-9)
