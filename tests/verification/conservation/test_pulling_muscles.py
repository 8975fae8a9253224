"""Muscles that pull resist no turn: their stiffness, and a driven body on the ground."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import warp_softbody as wsb
from tests.support.bodies import EXACT, Rig, muscular_bar, numbers, rig, turned
from tests.verification import reference
from tests.verification.fibers import Fibers
from warp_softbody.arrays import FloatArray
from warp_softbody.body.material import Material

DT = 1.0 / 60.0
MATERIAL = Material(young_modulus=2e5, poisson_ratio=0.3, volume="exact")
PULL = 0.6

each_form = pytest.mark.parametrize("native_code", [True, False], ids=["native", "plain"])


def pulling_bar(**options: Any) -> Rig:
    """A turned, crumpled bar at rest whose muscles all pull, with the conserving tangent."""
    bar = muscular_bar(MATERIAL, helix=True)
    every: dict[str, Any] = {"tangent": "conserving", "muscles": "implicit", "time_step": DT}
    body = rig(bar, **every, **EXACT, **options)
    noise = np.random.default_rng(3).uniform(-0.01, 0.01, bar.mesh.points.shape)
    body.place(turned(bar.mesh.points + noise, (1.0, 2.0, -1.0), 0.8), (0.0, 0.0, 0.0))
    return body


def step_matrix(body: Rig, activations: FloatArray | None) -> FloatArray:
    """M~ of a step from the state as it is, dense (3n, 3n)."""
    body.activate(activations)
    body.stepper.step(body.state, body.control, body.contacts, body.after)
    return np.asarray(reference.block_matrix(body.model, numbers(body.stepper.assembly.values)))


def muscle_stiffness(body: Rig) -> FloatArray:
    """What muscles that pull add to K, dense (3n, 3n)."""
    pulling = np.full(body.model.segment_count, PULL)
    return (step_matrix(body, pulling) - step_matrix(body, None)) / DT**2


def stiffness_beside_turns(body: Rig) -> FloatArray:
    """The same from its formula, by pairs: turns are the least-squares ones of each tet."""
    fibers, x = Fibers(body.model), body.positions
    F = reference.deformation_gradients(body.model.body.mesh, x)
    along = fibers.along(x)
    length = np.linalg.norm(along, axis=1)
    n = along / length[:, None]
    tensions = fibers.tensions(x, np.full(body.model.segment_count, PULL))[fibers.segment]
    gradients = reference.rest_gradients(body.model.body.mesh)
    matrix = np.zeros((x.size, x.size))
    for q, t in enumerate(fibers.tet):
        corners = np.arange(12).reshape(4, 3)
        change = np.zeros((3, 3, 12))
        for corner, axis in np.ndindex(4, 3):
            change[axis, :, corners[corner, axis]] = gradients[t, corner]
        turn_of = np.stack([np.cross(axis, F[t].T).T.ravel() for axis in np.eye(3)], axis=1)
        omega = np.linalg.lstsq(turn_of, change.reshape(9, 12), rcond=None)[0]
        rate = np.einsum("ijc,j->ic", change, fibers.directions[q])
        beside = rate - np.cross(omega.T, along[q]).T
        across = beside - np.outer(n[q], n[q] @ beside)
        strength = fibers.strength[fibers.segment[q]]
        own = strength * np.outer(n[q] @ rate, n[q] @ rate)
        own += tensions[q] / length[q] * across.T @ across
        nodes = (3 * body.model.body.mesh.tets[t][:, None] + np.arange(3)).ravel()
        matrix[np.ix_(nodes, nodes)] += fibers.volume[q] * own
    return matrix


@each_form
def test_their_stiffness_is_that_beside_the_turns_of_tets(native_code: bool) -> None:
    body = pulling_bar(native_code=native_code)
    found, expected = muscle_stiffness(body), stiffness_beside_turns(body)
    np.testing.assert_allclose(found, expected, atol=1e-8 * np.abs(expected).max())


@each_form
def test_their_stiffness_resists_no_turn_and_no_shift(native_code: bool) -> None:
    """To rounding; it is symmetric and positive semidefinite."""
    body = pulling_bar(native_code=native_code)
    matrix, x = muscle_stiffness(body), body.positions
    size = np.linalg.norm(matrix, 2)
    motions = [np.cross(axis, x).ravel() for axis in np.eye(3)]
    motions += [np.tile(axis, len(x)) for axis in np.eye(3)]
    for motion in motions:
        assert np.linalg.norm(matrix @ motion) <= 1e-9 * size * np.linalg.norm(motion)
    assert np.abs(matrix - matrix.T).max() <= 1e-9 * size
    assert np.linalg.eigvalsh(matrix)[0] >= -1e-9 * size


def test_a_driven_letter_keeps_its_angular_momentum_on_the_ground() -> None:
    """But for the moments of contact about the place where a step begins.

    Activations change in every step, so that segments pull, let go and go slack. The part of the
    stiffness that grows with tension took up to 1e-2 m^2/s in a step when it resisted turns.
    """
    plan = wsb.scenes.make("balance-i")
    options = wsb.SimulationOptions(precision="float64", tolerance=1e-10, time_step=plan.time_step)
    simulation = wsb.Simulation(replace(plan.scene, pushes=()), options=options)
    random, largest = np.random.default_rng(1), 0.0
    for _ in range(30):
        simulation.drive(random.uniform(0.6, 1.0, len(simulation.model.muscles.rest_lengths)))
        before = simulation.view()
        x, centre = before.positions.copy(), before.center_of_mass.copy()
        angular = before.angular_momentum.copy()
        simulation.step()
        after = simulation.view()
        arm = after.center_of_mass - centre
        end = after.angular_momentum + np.cross(arm, after.linear_momentum)
        contact = np.cross(x - centre, after.impulses).sum(axis=0)
        np.testing.assert_allclose(end - angular, contact, atol=1e-9 * after.mass)
        largest = max(largest, float(np.abs(end - angular).max()) / after.mass)
    assert largest > 1e-3


@each_form
@pytest.mark.parametrize("pull", [0.5, 0.7, 0.9])
@pytest.mark.parametrize("turn", [0.15, 0.3, 0.45])
def test_a_driven_body_that_is_thrown_fast_gains_no_energy(
    turn: float, pull: float, native_code: bool
) -> None:
    """It turns by so many rad a step as it lands, in steps of one Newton iteration."""
    bar = wsb.placed(muscular_bar(helix=True, strength=4e5), translation=(0.0, 0.0, 0.05))
    spin = turn / DT * np.array([0.82, 0.55, 0.14])
    scene = wsb.Scene(character=bar, ground=wsb.Plane(friction=0.5), initial_spin=tuple(spin))
    options = wsb.SimulationOptions(
        time_step=DT, tangent="conserving", muscles="implicit", native_code=native_code
    )
    simulation = wsb.Simulation(scene, options=options)
    simulation.drive(np.full(simulation.model.segment_count, pull))
    recorder = wsb.Recorder(simulation)
    for _ in range(30):
        simulation.step()
    parts = [values for name, values in recorder.arrays().items() if name.startswith("energy/")]
    energy = np.sum(parts, axis=0)[:, 0]
    assert np.diff(energy).max() <= 1e-6 * energy[0]
