"""Muscles with an energy: forces, stiffness, statics, convergence, stability, and their plan."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest

from tests.support.bodies import EXACT, Rig, crumpled, exact_dynamics, muscular_bar, numbers, rig
from tests.verification import reference
from tests.verification.fibers import Fibers
from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.body.material import Material
from warp_softbody.body.muscles import MuscleGroup

DT = 0.01
MATERIAL = Material(young_modulus=2e5, poisson_ratio=0.4, stiffness_damping=0.01, mass_damping=0.5)
PLAIN = {"elements": "linear", "tangent": "warped"}
UNDAMPED = Material(young_modulus=2e5, poisson_ratio=0.4, stiffness_damping=0.0, mass_damping=0.0)


def implicit(character: Character, **options: Any) -> Rig:
    """A rig with implicit muscles, its linear solves as good as direct ones."""
    plain = {"elements": "linear", "tangent": "warped", "muscles": "implicit"}
    every: dict[str, Any] = {"time_step": DT} | plain | EXACT | options
    return rig(character, **every)


def differences(function: Any, points: FloatArray, width: float) -> FloatArray:
    """Central differences (3n, ...) of a function of positions."""
    rows = []
    for number in range(points.size):
        moved = np.zeros(points.size)
        moved[number] = width
        ends = [function(points + sign * moved.reshape(points.shape)) for sign in (1.0, -1.0)]
        rows.append((ends[0] - ends[1]) / (2.0 * width))
    return np.array(rows)


def crumpled_rig(**options: Any) -> tuple[Rig, FloatArray, FloatArray]:
    """A crumpled bar with some segments slack, its positions and activations."""
    bar = muscular_bar(MATERIAL, helix=True)
    body = implicit(bar, **options)
    points = crumpled(bar.mesh, amount=0.05)
    stretches = Fibers(body.model).stretches(points)
    shares = np.random.default_rng(7).uniform(0.7, 1.1, len(stretches))
    activations = stretches * shares
    assert 0.1 < (shares > 1.0).mean() < 0.5
    body.place(points, (0.0, 0.0, 0.0))
    body.activate(activations)
    return body, points, activations


def muscle_forces(body: Rig) -> FloatArray:
    """Forces (n, 3) N of the muscles in a step from the state as it is."""
    body.stepper.step(body.state, body.control, body.contacts, body.after)
    forces = np.zeros_like(body.positions)
    corners = numbers(body.stepper.muscle_forces).reshape(-1, 4, 3)
    np.add.at(forces, body.model.body.mesh.tets, corners)
    return forces


def muscle_matrix(body: Rig) -> FloatArray:
    """What muscles add to K, dense (3n, 3n), of a step from the state as it is."""
    body.stepper.step(body.state, body.control, body.contacts, body.after)
    whole = reference.block_matrix(body.model, numbers(body.stepper.assembly.values))
    rest = reference.step_matrix(body.model, body.positions)
    return np.asarray((whole - rest) / body.model.options.time_step**2)


def test_forces_are_minus_the_gradient_of_the_energy() -> None:
    """Central differences of 1e-5 m are right to the square of 1e-5 over a tet's size of 0.1."""
    body, points, activations = crumpled_rig()
    found, fibers = muscle_forces(body), Fibers(body.model)
    expected = -differences(lambda x: fibers.energy(x, activations), points, 1e-5)
    largest = np.abs(found).max()
    np.testing.assert_allclose(found.ravel() / largest, expected / largest, atol=1e-7)
    np.testing.assert_allclose(found, fibers.forces(points, activations), atol=1e-10 * largest)


def test_there_is_no_net_force_and_no_net_torque() -> None:
    body, points, _ = crumpled_rig()
    found = muscle_forces(body)
    size = np.linalg.norm(found, axis=1)
    assert size.max() > 1.0
    assert np.abs(found.sum(axis=0)).max() <= 1e-13 * size.sum()
    torque = np.cross(points, found).sum(axis=0)
    assert np.abs(torque).max() <= 1e-13 * np.linalg.norm(points, axis=1) @ size


def test_stiffness_is_that_of_each_pair_and_bounds_the_energy_s() -> None:
    """The Jacobian of pairs' forces, and above that of the segments' (Jensen); of pulling ones."""
    body, points, activations = crumpled_rig()
    matrix, fibers = muscle_matrix(body), Fibers(body.model)
    largest = np.abs(matrix).max()
    assert np.abs(matrix - matrix.T).max() <= 1e-9 * largest
    assert np.abs(matrix.reshape(len(matrix), -1, 3).sum(axis=1)).max() <= 1e-8 * largest
    assert np.linalg.eigvalsh(matrix)[0] >= -1e-8 * largest
    tensions = fibers.tensions(points, activations)
    pulling = (fibers.strength * (tensions > 0.0))[fibers.segment]
    start = np.linalg.norm(fibers.along(points), axis=1)

    def by_pair(x: FloatArray) -> FloatArray:
        more = pulling * (np.linalg.norm(fibers.along(x), axis=1) - start)
        return fibers.by_pair(x, tensions[fibers.segment] + more).ravel()

    expected = -differences(by_pair, points, 1e-5)
    np.testing.assert_allclose(matrix / largest, expected / largest, atol=1e-7)
    energy_s = -differences(lambda x: fibers.forces(x, activations).ravel(), points, 1e-5)
    gap = matrix - 0.5 * (energy_s + energy_s.T)
    assert np.linalg.eigvalsh(gap)[0] >= -1e-7 * largest


def test_slack_muscles_leave_a_step_as_it_is() -> None:
    """To rounding: neither force nor stiffness."""
    body, _, _ = crumpled_rig()
    body.activate(None)
    assert np.abs(muscle_forces(body)).max() == 0.0
    largest = np.abs(reference.step_matrix(body.model, body.positions)).max()
    assert np.abs(muscle_matrix(body)).max() <= 1e-12 * largest / DT**2


def plain_bar(material: Material, strength: float) -> Character:
    """A bar with one segment from end to end that all of it feels alike."""
    bar = muscular_bar(material)
    fiber = bar.muscles[0].fibers[0]
    whole = type(fiber)(vertices=fiber.vertices[[0, -1]], kind=fiber.kind, name="whole")
    group = MuscleGroup(fibers=(whole,), strength=strength, kernel_width=0.08, name="one")
    return Character(name="bar", mesh=bar.mesh, material=material, muscles=(group,))


@pytest.mark.parametrize("ratio", [0.1, 1.0, 10.0])
@pytest.mark.parametrize("iterations", [1, 3])
def test_a_free_bar_shortens_as_in_closed_form(ratio: float, iterations: int) -> None:
    """E (1 - f) = S (f - a), whatever Poisson's ratio; slack to full in steps of 0.5 s."""
    body = implicit(plain_bar(MATERIAL, ratio * 2e5), time_step=0.5, newton_iterations=iterations)
    body.activate(0.6)
    body.step(100)
    stretch = (1.0 + ratio * 0.6) / (1.0 + ratio)
    moved = body.positions - body.positions.mean(axis=0)
    length = np.ptp(moved @ np.linalg.svd(moved, full_matrices=False)[2][0])
    assert abs(length / 0.6 - stretch) <= 1e-9


def energy(body: Rig, fibers: Fibers, activations: FloatArray) -> float:
    """Kinetic, elastic and of the muscles, J."""
    kinetic = 0.5 * float(body.masses @ (body.velocities**2).sum(axis=1))
    material = body.model.scene.character.material
    stored = reference.elastic_energy(body.model.body.mesh, material, body.positions)
    return kinetic + stored + fibers.energy(body.positions, activations)


@pytest.mark.parametrize("time_step", [0.5, 1.0 / 30.0, 1.0 / 240.0])
@pytest.mark.parametrize("iterations", [1, 2])
@pytest.mark.parametrize("tangent", ["warped", "conserving"])
def test_energy_only_falls_at_constant_activations(
    time_step: float, iterations: int, tangent: str
) -> None:
    """From slack to full, S = 10 E and no damping; explicit muscles blow up at 0.5 s."""
    bar = muscular_bar(UNDAMPED, strength=2e6)
    body = implicit(bar, time_step=time_step, newton_iterations=iterations, tangent=tangent)
    fibers = Fibers(body.model)
    activations = np.full(body.model.segment_count, 0.5)
    body.activate(activations)
    energies = [energy(body, fibers, activations)]
    for _ in range(30):
        body.step()
        energies.append(energy(body, fibers, activations))
    assert np.diff(energies).max() <= 1e-3 * energies[0]
    assert energies[-1] < 0.5 * energies[0]


def moved_exactly(fibers: Fibers, activations: FloatArray, seconds: float) -> FloatArray:
    """Positions after some seconds by the classical Runge-Kutta method, from rest."""
    masses = np.zeros(len(fibers.mesh.points))
    np.add.at(masses, fibers.mesh.tets, 1000.0 * fibers.mesh.volumes[:, None] / 4.0)
    x, v = fibers.mesh.points.copy(), np.zeros_like(fibers.mesh.points)

    def rate(x: FloatArray) -> FloatArray:
        force = reference.elastic_forces(fibers.mesh, UNDAMPED, x) + fibers.forces(x, activations)
        return np.asarray(force / masses[:, None])

    steps = 200
    h = seconds / steps
    for _ in range(steps):
        a1 = rate(x)
        a2 = rate(x + 0.5 * h * v)
        a3 = rate(x + 0.5 * h * v + 0.25 * h * h * a1)
        a4 = rate(x + h * v + 0.5 * h * h * a2)
        x = x + h * v + h * h / 6.0 * (a1 + a2 + a3)
        v = v + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
    return np.asarray(x)


def test_motion_converges_with_the_step_at_first_order() -> None:
    """Towards the motion of the energy, integrated by another method in NumPy."""
    bar, seconds = muscular_bar(UNDAMPED), 0.02
    body = implicit(bar)
    activations = np.linspace(0.7, 0.9, body.model.segment_count)
    expected = moved_exactly(Fibers(body.model), activations, seconds)
    errors = []
    for steps in (80, 160, 320):
        body = implicit(bar, time_step=seconds / steps)
        body.activate(activations)
        body.step(steps)
        errors.append(np.linalg.norm(body.positions - expected))
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (rates > 0.85).all() and (rates < 1.2).all()
    assert errors[-1] < 0.05 * np.linalg.norm(expected - bar.mesh.points)


@pytest.mark.parametrize(
    ("tangent", "material"), [("warped", MATERIAL), ("conserving", UNDAMPED)], ids=str
)
@pytest.mark.parametrize("native_code", [True, False], ids=["native", "plain"])
def test_newton_iterations_approach_the_implicit_euler_step(
    tangent: str, material: Material, native_code: bool
) -> None:
    """Its residual falls by half at least when iterations are doubled."""
    bar = muscular_bar(material)
    left = []
    for iterations in (1, 2, 4, 8):
        options = {"tangent": tangent, "native_code": native_code}
        body = implicit(bar, newton_iterations=iterations, **options)
        activations = np.linspace(0.6, 0.9, body.model.segment_count)
        body.activate(activations)
        body.step(2)
        before = body.velocities
        body.step()
        change, now = body.velocities - before, body.positions
        force = reference.elastic_forces(bar.mesh, material, now)
        force += Fibers(body.model).forces(now, activations)
        matrix = reference.warped_stiffness(bar.mesh, material, now)
        damping = (matrix @ body.velocities.ravel()).reshape(-1, 3)
        force -= material.stiffness_damping * damping
        force -= material.mass_damping * body.masses[:, None] * body.velocities
        missing = body.masses[:, None] * change - DT * force
        left.append(np.linalg.norm(missing) / np.linalg.norm(body.masses[:, None] * change))
    for worse, better in itertools.pairwise(left):
        assert better <= 0.5 * worse


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"native_code": False},
        {"tangent": "conserving"},
        {"tangent": "exact"},
        {"elements": "smoothed"},
        {"threads": 2},
        {"preconditioner": "two_level"},
    ],
    ids=str,
)
def test_the_plan_is_the_step(options: dict[str, Any]) -> None:
    """In flight, whatever is chosen up to what segments reach: both have the same matrix."""
    bar = muscular_bar(MATERIAL, helix=True)
    body = implicit(bar, gravity=(0.0, 0.0, -9.81), **options)
    rng = np.random.default_rng(4)
    body.place(crumpled(bar.mesh, amount=0.05), rng.standard_normal(bar.mesh.points.shape))
    rows = rng.standard_normal((20, 3 * body.model.node_count))
    dynamics = exact_dynamics(body, row_capacity=20)
    planned = []

    def decide() -> None:
        problem = dynamics.solve(rows, free=True)
        lengths = problem.reaches * rng.uniform(0.8, 1.0, len(problem.lengths))
        lengths[::3] = problem.reaches[::3]
        change = problem.muscle_map @ (lengths - problem.lengths)
        planned.append(problem.free_velocity + change)
        body.control.rest_lengths.assign(lengths)

    for _ in range(3):
        body.stepper.step(body.state, body.control, body.contacts, body.after, decide=decide)
        body.state, body.after = body.after, body.state
        found = rows @ body.velocities.ravel()
        scale = np.abs(rows) @ np.abs(body.velocities).ravel()
        np.testing.assert_allclose(planned[-1] / scale, found / scale, atol=1e-9)


def held_back(name: str, time_step: float) -> float:
    """By how much muscles let out to "lengths" or "reaches" change a step that lengthens a bar."""
    bar = muscular_bar(UNDAMPED, strength=2e6)
    body, slack = (implicit(bar, time_step=time_step, **PLAIN) for _ in range(2))
    for one in (body, slack):
        one.place(bar.mesh.points, bar.mesh.points * np.array([0.0, 0.0, 1.0]))
    slack.activate(None)
    slack.step()
    dynamics = exact_dynamics(body, row_capacity=3)
    rows = np.eye(3, 3 * body.model.node_count)

    def let_out() -> None:
        body.control.rest_lengths.assign(getattr(dynamics.solve(rows), name))

    body.stepper.step(body.state, body.control, body.contacts, body.after, decide=let_out)
    body.state, body.after = body.after, body.state
    return float(np.linalg.norm(body.velocities - slack.velocities))


def test_let_out_muscles_do_not_hold_a_body_that_lengthens() -> None:
    """Their impulse in a step falls with its third power; at l_d = l with the second."""
    steps = (1e-3, 5e-4, 2.5e-4)
    held = np.array([held_back("lengths", step) for step in steps])
    let_out = np.array([held_back("reaches", step) for step in steps])
    assert (np.log2(held[:-1] / held[1:]) < 2.2).all()
    assert (np.log2(let_out[:-1] / let_out[1:]) > 2.6).all()
    assert (let_out < 0.2 * held).all()
