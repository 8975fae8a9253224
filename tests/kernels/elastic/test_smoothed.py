"""Forces and rotations of smoothed tets, against an energy and formulas in NumPy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from tests.support.bodies import (
    Rig,
    box,
    crumpled,
    epsilon,
    muscular_bar,
    numbers,
    rig,
    turn,
    turned,
)
from tests.verification import reference
from tests.verification.smoothed_reference import (
    by_edge,
    by_node,
    smallest_sum,
    smoothed_energy,
    smoothed_forces,
    smoothed_stiffness,
)
from warp_softbody.arrays import FloatArray
from warp_softbody.body.material import Material
from warp_softbody.body.mesh import TetMesh
from warp_softbody.engine.options import ELEMENTS, Elements, Precision, SimulationOptions, Tangent
from warp_softbody.errors import InputError

SOFT = Material(young_modulus=1e5, poisson_ratio=0.4, stiffness_damping=0.03, mass_damping=0.7)
MESH = box((2, 2, 3), (0.2, 0.3, 0.4), jitter=0.2)

each_precision = pytest.mark.parametrize("precision", ["float32", "float64"])
plain_or_inverted = pytest.mark.parametrize("inverted", [False, True])


def assembled(
    mesh: TetMesh,
    points: FloatArray,
    precision: Precision = "float64",
    elements: Elements = "smoothed",
    material: Material = SOFT,
    tangent: Tangent = "warped",
) -> Rig:
    """A body at some positions, assembled with a step of a second."""
    options: dict[str, Any] = {"precision": precision, "elements": elements, "tangent": tangent}
    body = rig(mesh, material=material, time_step=1.0, **options)
    body.place(points, (0.0, 0.0, 0.0))
    body.stepper.assemble(body.state)
    return body


def forces(body: Rig) -> FloatArray:
    """(n, 3) N: at rest, weightless and in a step of a second the known momentum is the force."""
    return numbers(body.stepper.assembly.momentum)


def crumpled_points(mesh: TetMesh, inverted: bool, precision: Precision = "float64") -> FloatArray:
    """With tets inside out or without, exact in a precision, rotations of all means unique."""
    points = crumpled(mesh, amount=0.6, seed=1) if inverted else crumpled(mesh)
    points = points.astype(precision).astype(np.float64)
    F = reference.deformation_gradients(mesh, points)
    assert bool((np.linalg.det(F) < 0.0).any()) is inverted
    assert smallest_sum(mesh, points) > 0.3
    return np.asarray(points)


def force_rounding(mesh: TetMesh, points: FloatArray, precision: Precision) -> FloatArray:
    """Of nodes' forces, (n,) N.

    F = sum x g is off by a few eps of |x| |g|, a mean over up to 24 tets by as many eps, and R by
    that over the smallest sum of two stretches; stress is at most (2 mu + 3 lambda) times it.
    """
    gradients = np.linalg.norm(reference.rest_gradients(mesh), axis=2)
    size = 1.0 + np.abs(points).max() * gradients.max()
    strain = 32 * epsilon(precision) * size * (1.0 + 2.0 / smallest_sum(mesh, points))
    stress = (2.0 * SOFT.lame_mu + 3.0 * SOFT.lame_lambda) * strain
    bound = np.zeros(len(points))
    np.add.at(bound, mesh.tets, stress * mesh.volumes[:, None] * gradients)
    return bound


@plain_or_inverted
def test_force_is_minus_the_gradient_of_the_energy(inverted: bool) -> None:
    """Central differences lose eps of the energy over the step, 1e-9 of a force times a length."""
    mesh = box((1, 2, 2), (0.2, 0.3, 0.25))
    points = crumpled_points(mesh, inverted)
    found = forces(assembled(mesh, points))
    expected = np.zeros_like(points)
    for index in np.ndindex(*points.shape):
        move = np.zeros_like(points)
        move[index] = 1e-6
        ahead = smoothed_energy(mesh, SOFT, points + move)
        expected[index] = (smoothed_energy(mesh, SOFT, points - move) - ahead) / 2e-6
    np.testing.assert_allclose(found, expected, atol=1e-6 * np.abs(found).max())


@each_precision
@plain_or_inverted
def test_force_equals_the_formula(inverted: bool, precision: Precision) -> None:
    points = crumpled_points(MESH, inverted, precision)
    found = forces(assembled(MESH, points, precision))
    gap = np.linalg.norm(found - smoothed_forces(MESH, SOFT, points), axis=1)
    assert (gap <= force_rounding(MESH, points, precision)).all()
    assert gap.max() < 1e-3 * np.abs(found).max()


@each_precision
@plain_or_inverted
def test_forces_have_no_net_force_and_torque(inverted: bool, precision: Precision) -> None:
    """Up to the rounding of each."""
    points = crumpled_points(MESH, inverted)
    points -= points.mean(axis=0)
    found = forces(assembled(MESH, points, precision))
    bound = force_rounding(MESH, points, precision)
    assert np.abs(found).max() > 1.0
    assert np.linalg.norm(found.sum(axis=0)) <= bound.sum()
    torque = np.cross(points, found).sum(axis=0)
    assert np.linalg.norm(torque) <= np.linalg.norm(points, axis=1) @ bound


@each_precision
@pytest.mark.parametrize("angle", [0.0, 0.4, 1.7, np.pi, -2.6])
def test_rigid_motion_makes_no_force(angle: float, precision: Precision) -> None:
    points = turned(MESH.points, (0.3, -1.0, 0.5), angle) + np.array([0.4, 1.0, -0.7])
    found = forces(assembled(MESH, points, precision))
    assert (np.linalg.norm(found, axis=1) <= force_rounding(MESH, points, precision)).all()


@each_precision
@pytest.mark.parametrize("stretches", [(1.3, 0.9, 1.1), (0.4, 0.5, 0.6), (1.2, 0.9, -0.4)])
def test_homogeneous_deformation_gives_the_linear_elements_forces(
    stretches: tuple[float, float, float], precision: Precision
) -> None:
    """All means are the same F then, and a tet's shares of its edges and nodes sum to one."""
    affine = turn((1.0, -1.0, 2.0), 1.2) @ np.diag(stretches) @ turn((0.0, 1.0, 1.0), 0.7)
    points = MESH.points @ affine.T
    smoothed, linear = (forces(assembled(MESH, points, precision, e)) for e in ELEMENTS[::-1])
    gap = np.linalg.norm(smoothed - linear, axis=1)
    assert (gap <= 2.0 * force_rounding(MESH, points, precision)).all()


@pytest.mark.parametrize("poisson_ratio", [0.0, 0.4, 0.499])
def test_stiffness_at_rest_is_bounded_by_the_tets_and_lacks_only_rigid_motion(
    poisson_ratio: float,
) -> None:
    """The bound is what the implicit step's stability rests on."""
    material = Material(young_modulus=1e5, poisson_ratio=poisson_ratio, stiffness_damping=0.0)
    body = assembled(MESH, MESH.points, material=material)
    mass = np.diag(np.repeat(body.masses, 3))
    upper = reference.block_matrix(body.model, numbers(body.stepper.assembly.values)) - mass
    K = smoothed_stiffness(MESH, material).toarray()
    columns = []
    for move in 1e-6 * np.eye(len(K)).reshape(-1, *MESH.points.shape):
        pair = [forces(assembled_again(body, MESH.points + side * move)) for side in (-1.0, 1.0)]
        columns.append((pair[0] - pair[1]).ravel() / 2e-6)
    # rounding of positions over the step, and the step's square
    np.testing.assert_allclose(np.array(columns), K, atol=1e-8 * np.abs(K).max())
    assert np.linalg.eigvalsh(upper - K)[0] >= -1e-12 * np.linalg.norm(upper)
    values = np.linalg.eigvalsh(K)
    np.testing.assert_allclose(values[:6], 0.0, atol=1e-12 * values[-1])
    # no mode but the rigid ones is lost to averaging: the softest keeps a tenth of its stiffness
    assert values[6] > 0.1 * np.linalg.eigvalsh(upper)[6] > 1e-6 * values[-1]


def assembled_again(body: Rig, points: FloatArray) -> Rig:
    body.place(points)
    body.stepper.assemble(body.state)
    return body


def test_smoothed_elements_have_no_exact_tangent() -> None:
    with pytest.raises(InputError, match="no exact tangent, got tangent 'exact'"):
        SimulationOptions(elements="smoothed", tangent="exact")


def test_conserving_tangent_goes_with_exact_volume_alone() -> None:
    """A volume that nodes' rotations turn is not left alone by turns of the tets."""
    with pytest.raises(InputError, match="warped tangent only, got tangent 'conserving'"):
        assembled(MESH, MESH.points, tangent="conserving")


@pytest.mark.parametrize("amount", [0.15, 0.6, 2.0])
def test_matrix_is_positive_semidefinite(amount: float) -> None:
    body = assembled(MESH, crumpled(MESH, amount))
    step = reference.block_matrix(body.model, numbers(body.stepper.assembly.values))
    K = (step - 1.7 * np.diag(np.repeat(body.masses, 3))) / 1.03
    np.testing.assert_allclose(K, K.T, atol=1e-12 * np.abs(K).max())
    assert np.linalg.eigvalsh(K)[0] >= -1e-12 * np.linalg.norm(K)


@each_precision
@plain_or_inverted
def test_rotations_are_those_of_the_means(inverted: bool, precision: Precision) -> None:
    """Of a node its mean F's; of a tet the mean of its six edges', nearly made orthogonal."""
    points = crumpled_points(MESH, inverted, precision)
    body = assembled(MESH, points, precision)
    F = reference.deformation_gradients(MESH, points)
    expected = reference.polar_rotations(by_node(MESH).average(F))
    rounding = 64 * epsilon(precision) * (1.0 + 2.0 / smallest_sum(MESH, points))
    found = numbers(body.stepper.assembly.node_rotations)
    np.testing.assert_allclose(found, expected, atol=rounding)

    edges = by_edge(MESH)
    around = edges.means.T.copy()
    around.data[:] = 1.0 / 6.0
    mean = around @ reference.polar_rotations(edges.average(F)).reshape(-1, 9)
    mean = np.asarray(mean).reshape(-1, 3, 3)
    found = numbers(body.stepper.assembly.rotations)
    # a Newton-Schulz step takes a singular value 1 - d to 1 - 3/2 d^2 or above
    d = 1.0 - np.linalg.svd(mean, compute_uv=False).min(axis=1)
    left = 1.5 * (1.5 * d**2) ** 2
    gap = np.linalg.norm(found - reference.polar_rotations(mean), axis=(1, 2))
    assert (gap <= np.sqrt(3.0) * left + rounding).all()
    assert (np.linalg.det(found) > (1.0 - left) ** 3 - 3.0 * rounding).all()
    assert left.max() < (1e-2 if inverted else 1e-8)


def test_rotations_of_a_smooth_deformation_are_nearly_the_tets_own() -> None:
    """Of x = X turned about z by X_z: tets around an edge lie within two of their lengths.

    The second derivative is at most 2 per m for arms up to a metre, F changes by it times the
    distance and R, for stretches of at least a half, by twice that.
    """
    for cells in (3, 6):
        mesh = box((cells, cells, 2 * cells), (0.3, 0.3, 0.6), origin=(-0.15, -0.15, 0.0))
        angle = mesh.points[:, 2]
        x, y = mesh.points[:, 0], mesh.points[:, 1]
        cosine, sine = np.cos(angle), np.sin(angle)
        points = np.column_stack([cosine * x - sine * y, sine * x + cosine * y, angle])
        F = reference.deformation_gradients(mesh, points)
        assert np.linalg.svd(F, compute_uv=False).min() > 0.5
        found = numbers(assembled(mesh, points).stepper.assembly.rotations)
        gap = np.linalg.norm(found - reference.polar_rotations(F), axis=(1, 2)).max()
        assert gap < 2.0 * 2.0 * 2.0 * np.sqrt(3.0) * 0.3 / cells
        np.testing.assert_allclose(found.transpose(0, 2, 1) @ found - np.eye(3), 0.0, atol=1e-8)
    # and by the last mesh the bound is a small one
    assert gap < 0.1


@pytest.mark.parametrize("elements", ELEMENTS)
def test_muscles_contract_a_bar_as_far_as_the_balance_of_stress_says(elements: Elements) -> None:
    """Shortening e is the same everywhere: E e = T (1 + nu e)^2 with T = S (1 - e - a)."""
    material = Material(young_modulus=2e5, poisson_ratio=0.4, stiffness_damping=0.01)
    character = muscular_bar(material)
    body = rig(character, time_step=0.01, elements=elements, precision="float64", tolerance=1e-10)
    body.activate(0.7)
    body.step(400)

    def balance(e: float) -> float:
        return float(2e5 * (1.0 - e - 0.7) * (1.0 + 0.4 * e) ** 2 - 2e5 * e)

    e = float(brentq(balance, 0.0, 0.3))
    assert e > 0.1
    F = reference.deformation_gradients(character.mesh, body.positions)
    found = np.linalg.svd(F, compute_uv=False)
    # a hundred steps damp what is left of the swing to a tenth and less
    expected = np.broadcast_to([1.0 + 0.4 * e, 1.0 + 0.4 * e, 1.0 - e], found.shape)
    np.testing.assert_allclose(found, expected, atol=1e-8)
