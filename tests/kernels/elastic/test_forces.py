"""Elastic and muscle forces and the step's matrix, against the formulas assembled in NumPy."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from tests.support.bodies import Rig, box, crumpled, epsilon, muscular_bar, numbers, rig, turned
from tests.verification import reference
from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.body.material import Material
from warp_softbody.body.mesh import TetMesh
from warp_softbody.characters import letter_x
from warp_softbody.device.launching import launch
from warp_softbody.engine.muscle_layout import SMALLEST_WEIGHT, build_muscle_layout
from warp_softbody.engine.options import TANGENTS, Precision, Tangent
from warp_softbody.kernels.muscles import make_muscles

PRECISIONS: tuple[Precision, ...] = ("float32", "float64")
SOFT = Material(young_modulus=1e5, poisson_ratio=0.4, stiffness_damping=0.03, mass_damping=0.7)


def forces_at(body: Rig, positions: FloatArray) -> FloatArray:
    """The engine's elastic forces (n, 3): at rest and weightless the known momentum is dt f_e."""
    body.place(positions, (0.0, 0.0, 0.0))
    body.stepper.assemble(body.state)
    return numbers(body.stepper.assembly.momentum) / body.model.options.time_step


def mixed_up(mesh: TetMesh) -> FloatArray:
    """Crumpled so far that some tets are inside out."""
    points = crumpled(mesh, amount=0.6)
    F = reference.deformation_gradients(mesh, points)
    assert 0.02 < (np.linalg.det(F) < 0.0).mean() < 0.5
    return points


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("angle", [0.0, 0.4, 1.7, np.pi, -2.6])
def test_rigid_motion_makes_no_force(angle: float, precision: Precision) -> None:
    """Positions are rounded to eps |x|, so strains are eps |x| / h, forces that times E area."""
    mesh = box((2, 2, 3), (0.2, 0.3, 0.4), jitter=0.2)
    points = turned(mesh.points, (0.3, -1.0, 0.5), angle) + np.array([0.4, 1.0, -0.7])
    found = forces_at(rig(mesh, material=SOFT, precision=precision, time_step=1.0), points)
    gradients = np.linalg.norm(reference.rest_gradients(mesh), axis=2)
    strain = 8 * epsilon(precision) * (1.0 + np.abs(points).max() * gradients.max())
    stiffness = 2.0 * SOFT.lame_mu + 3.0 * SOFT.lame_lambda
    bound = np.zeros(len(points))
    np.add.at(bound, mesh.tets, strain * stiffness * mesh.volumes[:, None] * gradients)
    assert (np.linalg.norm(found, axis=1) <= bound).all()


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("inverted", [False, True])
def test_elastic_forces_have_no_net_force_and_torque(inverted: bool, precision: Precision) -> None:
    """Up to rounding: a few eps for each of the 24 tets around a node."""
    mesh = box((2, 2, 3), (0.2, 0.3, 0.4), jitter=0.2)
    points = mixed_up(mesh) if inverted else crumpled(mesh)
    points -= points.mean(axis=0)
    found = forces_at(rig(mesh, material=SOFT, precision=precision, time_step=1.0), points)
    size = np.linalg.norm(found, axis=1)
    assert size.max() > 1.0
    assert np.abs(found.sum(axis=0)).max() <= 24 * epsilon(precision) * size.sum()
    arms = np.linalg.norm(points, axis=1)
    torque = np.cross(points, found).sum(axis=0)
    assert np.abs(torque).max() <= 48 * epsilon(precision) * (arms @ size)


@pytest.mark.parametrize("inverted", [False, True])
def test_elastic_force_is_minus_the_gradient_of_the_energy(inverted: bool) -> None:
    mesh = box((1, 2, 2), (0.2, 0.3, 0.25))
    points = mixed_up(mesh) if inverted else crumpled(mesh)
    found = forces_at(rig(mesh, material=SOFT, precision="float64", time_step=1.0), points)
    step = 1e-6
    expected = np.zeros_like(points)
    for index in np.ndindex(*points.shape):
        moved = points.copy()
        moved[index] += step
        ahead = reference.elastic_energy(mesh, SOFT, moved)
        moved[index] -= 2.0 * step
        expected[index] = (reference.elastic_energy(mesh, SOFT, moved) - ahead) / (2.0 * step)
    np.testing.assert_allclose(found, expected, atol=1e-6 * np.abs(found).max())


@pytest.mark.parametrize("inverted", [False, True])
def test_elastic_force_equals_the_formula(inverted: bool) -> None:
    mesh = box((2, 2, 3), (0.2, 0.3, 0.4), jitter=0.2)
    points = mixed_up(mesh) if inverted else crumpled(mesh)
    found = forces_at(rig(mesh, material=SOFT, precision="float64", time_step=1.0), points)
    expected = reference.elastic_forces(mesh, SOFT, points)
    np.testing.assert_allclose(found, expected, atol=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("inverted", [False, True])
def test_step_matrix_equals_the_warped_stiffness(inverted: bool, precision: Precision) -> None:
    mesh = box((2, 2, 3), (0.2, 0.3, 0.4), jitter=0.2)
    body = rig(mesh, material=SOFT, precision=precision, time_step=0.05)
    points = mixed_up(mesh) if inverted else crumpled(mesh)
    forces_at(body, points)
    found = reference.block_matrix(body.model, body.stepper.assembly.values.numpy())
    expected = reference.step_matrix(body.model, points)
    bound = 1e-12 if precision == "float64" else 64 * epsilon(precision)
    np.testing.assert_allclose(found, expected, atol=bound * np.abs(expected).max())
    np.testing.assert_array_equal(found, found.T)


def test_stiffness_is_semidefinite_with_the_translations_in_its_null_space() -> None:
    mesh = box((2, 2, 3), (0.2, 0.3, 0.4), jitter=0.2)
    body = rig(mesh, material=SOFT, precision="float64", time_step=1.0)
    forces_at(body, mixed_up(mesh))
    step = reference.block_matrix(body.model, body.stepper.assembly.values.numpy())
    K = (step - 1.7 * np.diag(np.repeat(body.masses, 3))) / 1.03
    values = np.linalg.eigvalsh(K)
    assert values[0] >= -1e-12 * values[-1]
    translations = np.tile(np.eye(3), (len(mesh.points), 1))
    np.testing.assert_allclose(K @ translations, 0.0, atol=1e-12 * values[-1])


def muscle_forces_at(body: Rig, positions: FloatArray, activations: FloatArray) -> FloatArray:
    """The kernels' muscle forces on the nodes, (n, 3), summed up in float64."""
    body.place(positions, (0.0, 0.0, 0.0))
    body.activate(activations)
    body.stepper.assemble(body.state)
    model, a = body.model, body.model.arrays
    kernels, types = make_muscles(model.options.precision), model.types
    tensions = model.zeros(model.segment_count, types.scalar)
    corners = model.zeros(4 * model.tet_count, types.vec3)
    inputs = [a.muscles.stiffness, body.control.rest_lengths, body.stepper.lengths]
    launch(kernels.segment_tensions, model.segment_count, inputs, [tensions], "cpu")
    pairs = [
        a.muscles.pair_start,
        a.muscles.pair_segment,
        a.muscles.pair_weight,
        a.muscles.directions,
    ]
    inputs = [*pairs, tensions, body.stepper.assembly.rotations, body.stepper.assembly.area_rows]
    launch(kernels.muscle_tets, model.tet_count, inputs, [corners], "cpu")
    by_corner = corners.numpy().astype(np.float64).reshape(-1, 4, 3)
    forces = np.zeros((model.node_count, 3))
    np.add.at(forces, model.scene.character.mesh.tets, by_corner)
    return forces


def weights_of(character: Character, body: Rig) -> FloatArray:
    layout = body.model.muscles
    weights = np.zeros((len(character.mesh.tets), character.segment_count))
    weights[layout.pair_tet, layout.pair_segment] = layout.pair_weight
    return weights


@pytest.mark.parametrize("precision", PRECISIONS)
def test_muscle_forces_equal_stress_times_deformed_normals(precision: Precision) -> None:
    """Face by face in NumPy; some segments pull, some are slack because they are short."""
    character = muscular_bar(helix=True)
    body = rig(character, precision=precision, time_step=0.01)
    points = crumpled(character.mesh, amount=0.1)
    activations = np.random.default_rng(2).uniform(0.7, 1.4, character.segment_count)
    found = muscle_forces_at(body, points, activations)
    lengths = reference.segment_lengths(character, points)
    spans = np.concatenate([np.diff(fiber.vertices, axis=0) for fiber in character.fibers])
    rest = np.linalg.norm(spans, axis=1)
    strength = np.where(np.arange(len(rest)) < 12, 2e5, 1e5)
    tensions = strength / rest * np.maximum(lengths - activations * rest, 0.0)
    assert 0 < np.count_nonzero(tensions == 0.0) < len(rest)
    expected = reference.muscle_forces(character, points, tensions, weights_of(character, body))
    bound = (1e-12 if precision == "float64" else 64 * epsilon(precision)) * np.abs(expected).max()
    np.testing.assert_allclose(found, expected, atol=bound)


@pytest.mark.parametrize("precision", PRECISIONS)
def test_muscle_forces_have_no_net_force_and_torque(precision: Precision) -> None:
    character = muscular_bar(helix=True)
    body = rig(character, precision=precision, time_step=0.01)
    points = crumpled(character.mesh, amount=0.1)
    points -= points.mean(axis=0)
    activations = np.random.default_rng(2).uniform(0.5, 1.0, character.segment_count)
    found = muscle_forces_at(body, points, activations)
    size, arms = np.linalg.norm(found, axis=1), np.linalg.norm(points, axis=1)
    assert size.max() > 1.0
    assert np.abs(found.sum(axis=0)).max() <= 24 * epsilon(precision) * size.sum()
    torque = np.cross(points, found).sum(axis=0)
    assert np.abs(torque).max() <= 48 * epsilon(precision) * (arms @ size)


def test_slack_muscles_make_no_force() -> None:
    """At l_d = l and beyond there is no tension, and a muscle never pushes."""
    character = muscular_bar()
    body = rig(character, precision="float64", time_step=0.01)
    squeezed = character.mesh.points * np.array([1.0, 1.0, 0.7])
    for activations in (0.71, 1.0, 3.0, 1e6):
        found = muscle_forces_at(body, squeezed, np.full(character.segment_count, activations))
        np.testing.assert_array_equal(found, 0.0)
    found = muscle_forces_at(body, squeezed, np.full(character.segment_count, 0.69))
    top = character.region("top")
    assert found[top, 2].sum() < 0.0 < found[character.region("base"), 2].sum()


def test_muscle_weights_are_a_partition_of_unity() -> None:
    """Equal to the paper's formula but for the smallest, which are dropped."""
    character = muscular_bar(helix=True)
    body = rig(character, precision="float64")
    found = weights_of(character, body)
    for group in (slice(0, 12), slice(12, 20)):
        np.testing.assert_allclose(found[:, group].sum(axis=1), 1.0, atol=1e-14)
    assert (found >= 0.0).all()
    # the reference samples 4001 points a segment, an error in d^2 below 1e-9 m^2
    expected = reference.segment_weights(character)
    kept = np.where(found > 0.0, expected, 0.0)
    assert (expected[found == 0.0] < SMALLEST_WEIGHT * (1.0 + 1e-6)).all()
    for group in (slice(0, 12), slice(12, 20)):
        kept[:, group] /= kept[:, group].sum(axis=1, keepdims=True)
    np.testing.assert_allclose(found, kept, rtol=1e-5)


def stiffness_of(mesh: TetMesh, positions: FloatArray, tangent: Tangent) -> FloatArray:
    """K (3n, 3n) in double precision, from the step's matrix with dt = 1."""
    material = Material(young_modulus=1e5, poisson_ratio=0.4, stiffness_damping=0.0)
    body = rig(mesh, material=material, precision="float64", time_step=1.0, tangent=tangent)
    body.place(positions)
    body.stepper.assemble(body.state)
    matrix = reference.block_matrix(body.model, numbers(body.stepper.assembly.values))
    return matrix - np.diag(np.repeat(body.masses, 3))


def differences(
    mesh: TetMesh, positions: FloatArray, what: Callable[..., FloatArray]
) -> FloatArray:
    """Derivative of ``what(mesh, positions)`` by all coordinates, by central differences."""
    columns = []
    for index in np.ndindex(*positions.shape):
        move = np.zeros_like(positions)
        move[index] = 1e-6
        columns.append((what(mesh, positions + move) - what(mesh, positions - move)) / 2e-6)
    return np.stack(columns, axis=-1)


def strains(mesh: TetMesh, positions: FloatArray) -> FloatArray:
    F = reference.deformation_gradients(mesh, positions)
    S = np.einsum("mki,mkj->mij", reference.polar_rotations(F), F)
    return np.asarray(0.5 * (S + S.transpose(0, 2, 1)) - np.eye(3))


def test_conserving_tangent_is_the_gauss_newton_matrix() -> None:
    """``sum V0 (d eps / d x)^T D (d eps / d x)``, the rotations' change included."""
    mesh = box((1, 2, 2), (0.2, 0.3, 0.25), jitter=0.2)
    points = crumpled(mesh, amount=0.1)
    slope = differences(mesh, points, strains)
    trace = np.einsum("miik->mk", slope)
    mu, lam = SOFT.lame_mu, SOFT.lame_lambda
    expected = 2.0 * mu * np.einsum("m,mijk,mijl->kl", mesh.volumes, slope, slope)
    expected += lam * np.einsum("m,mk,ml->kl", mesh.volumes, trace, trace)
    found = stiffness_of(mesh, points, "conserving")
    np.testing.assert_allclose(found, expected, atol=1e-7 * np.abs(expected).max())


def test_conserving_tangent_takes_turns_to_zero_also_far_from_rest() -> None:
    mesh = box((2, 2, 2), (0.2, 0.3, 0.25), jitter=0.2)
    points = crumpled(mesh, amount=0.3)
    K = stiffness_of(mesh, points, "conserving")
    for axis in np.eye(3):
        turning = np.cross(axis, points).ravel()
        forces = np.abs(K) @ np.abs(turning)
        assert np.abs(K @ turning).max() <= 1e-12 * forces.max()


def test_exact_tangent_is_the_derivative_of_the_force_in_tension() -> None:
    """Under tension it is positive semidefinite by itself, so nothing is cut off."""
    mesh = box((1, 2, 2), (0.2, 0.3, 0.25), jitter=0.2)
    points = 1.3 * crumpled(mesh, amount=0.05)
    expected = -differences(mesh, points, lambda m, x: reference.elastic_forces(m, SOFT, x).ravel())
    found = stiffness_of(mesh, points, "exact")
    np.testing.assert_allclose(found, expected, atol=1e-7 * np.abs(expected).max())


@pytest.mark.parametrize("tangent", TANGENTS)
def test_every_tangent_is_positive_semidefinite(tangent: Tangent) -> None:
    """Also with tets squashed to half their size and inside out."""
    mesh = box((2, 2, 3), (0.2, 0.3, 0.4), jitter=0.2)
    for points in (0.5 * crumpled(mesh), mixed_up(mesh)):
        K = stiffness_of(mesh, points, tangent)
        np.testing.assert_allclose(K, K.T, atol=1e-12 * np.abs(K).max())
        assert np.linalg.eigvalsh(K).min() >= -1e-12 * np.abs(K).max()


@pytest.mark.parametrize("tangent", TANGENTS)
def test_tangents_agree_in_both_precisions_and_at_rest(tangent: Tangent) -> None:
    mesh = box((2, 2, 2), (0.2, 0.3, 0.25), jitter=0.2)
    at_rest = stiffness_of(mesh, mesh.points, tangent)
    warped = stiffness_of(mesh, mesh.points, "warped")
    np.testing.assert_allclose(at_rest, warped, atol=1e-9 * np.abs(warped).max())
    points = crumpled(mesh, amount=0.1)
    single = rig(mesh, material=SOFT, time_step=1.0, tangent=tangent)
    double = rig(mesh, material=SOFT, time_step=1.0, tangent=tangent, precision="float64")
    for body in (single, double):
        body.place(points)
        body.stepper.assemble(body.state)
    expected = numbers(double.stepper.assembly.values)
    bound = 200 * epsilon("float32") * np.abs(expected).max()
    np.testing.assert_allclose(numbers(single.stepper.assembly.values), expected, atol=bound)


def test_fibre_directions_hold_no_rounding() -> None:
    """Their squares would be denormal numbers in single precision."""
    directions = build_muscle_layout(letter_x()).directions
    parts = np.abs(directions[directions != 0.0])
    assert (parts**2 > np.finfo(np.float32).tiny).all()
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1.0, rtol=1e-15)
