"""Bodies that turn freely: what a step keeps, what it loses, and Euler's equations."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.support.bodies import EXACT, Rig, Vector, box, epsilon, rig, turned
from tests.verification.accuracy import energy, orders, rest_stiffness
from warp_softbody.arrays import FloatArray
from warp_softbody.body.material import Material
from warp_softbody.engine.options import TANGENTS, Tangent

EPS = epsilon("float64")
TEN_TURNS_A_SECOND = 20.0 * np.pi
AXES = [(0.0, 0.0, 1.0), (1.0, 2.0, 1.0)]

each_tangent = pytest.mark.parametrize("tangent", TANGENTS)
about_each_axis = pytest.mark.parametrize("axis", AXES, ids=["face", "oblique"])


def bar(material: Material, spin: Sequence[float] | FloatArray, **options: Any) -> Rig:
    """A stress-free bar of 0.3 x 0.2 x 0.1 m, turning about its centre of mass."""
    body = rig(box((3, 2, 1), (0.3, 0.2, 0.1)), material=material, **EXACT, **options)
    arms = body.positions - body.center
    body.place(arms, np.cross(spin, arms))
    return body


def spin_about(axis: Sequence[float], speed: float = TEN_TURNS_A_SECOND) -> FloatArray:
    return np.asarray(speed * np.asarray(axis) / np.linalg.norm(axis))


def rounding(body: Rig, steps: int) -> float:
    """Of a velocity after some steps, m/s: positions' eps in the elastic force, and the solves'.

    A node's force is off by eps of the row sum of |K| times the body's size.
    """
    character = body.model.scene.character
    K = abs(rest_stiffness(character.mesh, character.material)).sum(axis=1).reshape(-1, 3)
    force = EPS * np.ptp(body.positions) * (K / body.masses[:, None]).max()
    solve = EXACT["tolerance"] * np.sqrt(len(body.masses)) * np.abs(body.velocities).max()
    return float(steps * (body.model.options.time_step * force + solve))


@each_tangent
def test_turned_body_at_rest_stays(tangent: Tangent) -> None:
    """Without stress and without spin nothing moves, whatever way the body is turned."""
    body = bar(Material(young_modulus=1e6), (0.0, 0.0, 0.0), time_step=1e-3, tangent=tangent)
    start = turned(body.positions, (1.0, -2.0, 0.5), 2.5)
    body.place(start)
    body.step(100)
    bound = rounding(body, 100)
    np.testing.assert_allclose(body.velocities, 0.0, atol=bound)
    np.testing.assert_allclose(body.positions, start, atol=0.1 * bound + 100 * EPS)


@each_tangent
@about_each_axis
@pytest.mark.parametrize(("damping", "step"), [(0.0, 7e-4), (0.05, 1e-5)])
def test_first_step_of_a_stress_free_spin(
    axis: Vector, damping: float, step: float, tangent: Tangent
) -> None:
    """K takes a turn of the undeformed body for none; the straight path stretches it.

    By sqrt(1 + (w dt)^2) across the axis, which is all the energy that the step adds. So short a
    step takes it; longer ones take an arc (tests/verification/conservation/test_spins.py).
    """
    material = Material(young_modulus=1e6, poisson_ratio=0.3, stiffness_damping=damping)
    body = bar(material, spin_about(axis), time_step=step, tangent=tangent)
    velocities, angular, before = body.velocities, body.angular_momentum, energy(body)
    body.step()
    bound = rounding(body, 1)
    np.testing.assert_allclose(body.velocities, velocities, atol=bound)
    size = float(body.masses @ np.linalg.norm(body.positions, axis=1))
    np.testing.assert_allclose(body.angular_momentum, angular, atol=size * bound)
    stretch = np.hypot(1.0, TEN_TURNS_A_SECOND * step) - 1.0
    volume = 0.3 * 0.2 * 0.1
    gain = 2.0 * volume * (material.lame_mu + material.lame_lambda) * stretch**2
    assert energy(body) - before == pytest.approx(gain, abs=1e-12 * before)


@cache
def spun(axis: Vector, steps: int, tangent: Tangent) -> tuple[Rig, FloatArray, FloatArray]:
    """A quarter turn at ten turns a second; angular momenta and energies after every step."""
    material = Material(young_modulus=4e5, poisson_ratio=0.3, stiffness_damping=0.0)
    body = bar(material, spin_about(axis), time_step=0.025 / steps, tangent=tangent)
    angular, energies = [body.angular_momentum], [energy(body)]
    for _ in range(steps):
        body.step()
        angular.append(body.angular_momentum)
        energies.append(energy(body))
    return body, np.array(angular), np.array(energies)


def residuals(body: Rig, steps: int) -> float:
    """Of all nodes' momenta after some steps, from the solves and from rounding of M~ v, kg m/s."""
    character, dt = body.model.scene.character, body.model.options.time_step
    implicit = dt * (character.material.stiffness_damping + dt)
    K = abs(rest_stiffness(character.mesh, character.material))
    speeds = np.abs(body.velocities).ravel()
    size = np.linalg.norm(np.repeat(body.masses, 3) * speeds + implicit * (K @ speeds))
    return float(steps * np.sqrt(len(body.masses)) * (EXACT["tolerance"] + 8.0 * EPS) * size)


@each_tangent
@about_each_axis
def test_spin_keeps_its_linear_momentum(axis: Vector, tangent: Tangent) -> None:
    body, _, _ = spun(axis, 400, tangent)
    np.testing.assert_allclose(body.momentum, 0.0, atol=residuals(body, 400))


@each_tangent
@about_each_axis
def test_angular_momentum_is_kept(axis: Vector, tangent: Tangent) -> None:
    """What a tangent takes from a turn is given back; x+ x v+ = x x v+ where x+ = x + dt v+."""
    body, angular, _ = spun(axis, 400, tangent)
    radius = float(np.linalg.norm(body.positions, axis=1).max())
    assert np.abs(angular - angular[0]).max() < radius * residuals(body, 400)


@each_tangent
@about_each_axis
def test_it_is_kept_with_damping_and_large_steps(axis: Vector, tangent: Tangent) -> None:
    """Half a radian a step and lambda = 6 dt, on the arc that so fast a spin takes."""
    material = Material(young_modulus=1e6, poisson_ratio=0.3, stiffness_damping=0.05)
    body = bar(material, spin_about(axis), time_step=1.0 / 120.0, tangent=tangent)
    start = body.angular_momentum
    body.step(60)
    radius = float(np.linalg.norm(body.positions, axis=1).max())
    bound = radius * residuals(body, 60)
    assert bound < 1e-6 * np.linalg.norm(start)
    np.testing.assert_allclose(body.angular_momentum, start, atol=bound)


@each_tangent
@about_each_axis
def test_spin_gains_no_energy(axis: Vector, tangent: Tangent) -> None:
    """But that of the straight path, which falls with dt^4: implicit Euler only loses energy."""
    gains = []
    for steps in (200, 400):
        _, _, energies = spun(axis, steps, tangent)
        gains.append(float(energies.max() - energies[0]))
        assert energies[-1] < energies[0]
        # a twentieth of the way on, the loss outweighs the stretch in every step
        assert (np.diff(energies)[steps // 20 :] < 0.0).all()
    # the stretch's series goes on with (w dt)^2, and the loss that competes with it with w dt
    margin = float(np.log2(1.0 + TEN_TURNS_A_SECOND * 0.025 / 200))
    np.testing.assert_allclose(orders(gains), 4.0, atol=margin)


def rigid_motion(body: Rig, spin: FloatArray, duration: float) -> FloatArray:
    """Positions by Euler's equations of a rigid body with the same nodal masses."""
    arms, masses = body.positions, body.masses
    inertia = np.einsum("n,ni,nj->ij", masses, arms, arms)
    inertia = np.trace(inertia) * np.eye(3) - inertia
    momentum = inertia @ spin

    def rate(_: float, turn: FloatArray) -> FloatArray:
        R = turn.reshape(3, 3)
        now = R @ np.linalg.solve(inertia, R.T @ momentum)
        return np.cross(now, R, axisb=0, axisc=0).ravel()

    start = np.eye(3).ravel()
    run = solve_ivp(rate, (0.0, duration), start, method="DOP853", rtol=1e-11, atol=1e-12)
    return np.asarray(arms @ run.y[:, -1].reshape(3, 3).T)


# not the exact tangent, which lets stress brake a turn, and a straight path's stress grows with E
@pytest.mark.parametrize("tangent", ["warped", "conserving"])
@pytest.mark.parametrize("young_modulus", [1e6, 1e7, 1e8])
def test_stiff_body_tumbles_as_a_rigid_one(young_modulus: float, tangent: Tangent) -> None:
    """About no principal axis, 0.9 turns: off by centrifugal strain and the square of w dt."""
    spin, duration, step = np.array([2.0, 6.0, 3.0]), 0.8, 5e-4
    material = Material(young_modulus=young_modulus, poisson_ratio=0.3, stiffness_damping=0.0)
    body = bar(material, spin, time_step=step, tangent=tangent)
    expected = rigid_motion(body, spin, duration)
    radius = float(np.linalg.norm(body.positions, axis=1).max())
    body.step(round(duration / step))
    speed = float(np.linalg.norm(spin))
    strain = material.density * (speed * radius) ** 2 / young_modulus
    # both change the rate of turning by their share, and so the angle turned by share * w T
    bound = radius * speed * duration * (strain + (speed * step) ** 2)
    np.testing.assert_allclose(body.positions, expected, atol=bound)


@each_tangent
@pytest.mark.parametrize("damping", [0.0, 0.05])
@pytest.mark.parametrize("step", [1.0 / 120.0, 1.0 / 480.0])
def test_stiff_body_swells_no_more_than_straight_paths_make_it(
    step: float, damping: float, tangent: Tangent
) -> None:
    """A step's path stretches by (w dt)^2 / 2, and dt / (lambda + dt) of all stretch goes back.

    So a turning body is too large by w^2 dt (lambda + dt) / 2, however stiff it is; where that is
    more than a thousandth it takes an arc, and is not.
    """
    speed, axis = 2.0 * np.pi, np.full(3, 3.0**-0.5)
    material = Material(young_modulus=1e8, poisson_ratio=0.3, stiffness_damping=damping)
    # the grid is the same from all three axes, so the cube's diagonal is a principal axis
    body = rig(box((2, 2, 2)), material=material, time_step=step, **EXACT, tangent=tangent)
    start = body.positions - body.center
    body.place(start, np.cross(speed * axis, start))
    body.step(round(0.5 / step))
    swelling = across(body, body.positions - body.center, axis) / across(body, start, axis) - 1.0
    expected = 0.5 * speed**2 * step * (damping + step)
    # centrifugal strain at a corner, and the next order of both series
    strain = material.density * speed**2 * 0.03 / material.young_modulus
    assert swelling < expected + strain + 2.0 * expected * (expected + speed * step)


def across(body: Rig, arms: FloatArray, axis: FloatArray) -> float:
    """Radius of gyration about an axis times the root of the mass."""
    return float(np.sqrt(body.masses @ (np.cross(axis, arms) ** 2).sum(axis=1)))
