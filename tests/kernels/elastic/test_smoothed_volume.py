"""Smoothed tets with exact volume by node: forces against their energy, matrices, momenta."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.support.bodies import Rig, box, crumpled, epsilon, numbers, rig, turned
from tests.verification import reference
from tests.verification.volume_reference import (
    smoothed_volume_energy,
    smoothed_volume_forces,
    volume_slopes,
)
from warp_softbody.arrays import FloatArray
from warp_softbody.body.material import Material
from warp_softbody.engine.options import ELEMENTS, Elements, Precision, Tangent

SOFT = Material(young_modulus=1e5, poisson_ratio=0.45, stiffness_damping=0.0, volume="exact")
MESH = box((2, 2, 3), (0.2, 0.3, 0.4), jitter=0.2)
EPSILON = epsilon("float64")

each_tangent = pytest.mark.parametrize("tangent", ["warped", "conserving"])


def assembled(points: FloatArray, elements: Elements = "smoothed", **options: Any) -> Rig:
    """A body at some positions, assembled with a step of a second."""
    chosen = {"material": SOFT, "precision": "float64", **options}
    body = rig(MESH, time_step=1.0, elements=elements, **chosen)
    body.place(points, (0.0, 0.0, 0.0))
    body.stepper.assemble(body.state)
    return body


def forces(body: Rig) -> FloatArray:
    """(n, 3) N: at rest, weightless and in a step of a second the known momentum is the force."""
    return numbers(body.stepper.assembly.momentum)


def stiffness(body: Rig) -> FloatArray:
    """K (3n, 3n)."""
    matrix = reference.block_matrix(body.model, numbers(body.stepper.assembly.values))
    return matrix - np.diag(np.repeat(body.masses, 3))


@pytest.mark.parametrize("amount", [0.15, 0.6])
def test_force_is_minus_the_gradient_of_the_energy(amount: float) -> None:
    """Along random directions; differences of step 1e-6 lose 1e-9 of an energy over a length."""
    points = crumpled(MESH, amount)
    found = forces(assembled(points))
    rng = np.random.default_rng(3)
    for _ in range(8):
        move = rng.normal(size=points.shape)
        move /= np.linalg.norm(move)
        ahead = smoothed_volume_energy(MESH, SOFT, points + 1e-6 * move)
        behind = smoothed_volume_energy(MESH, SOFT, points - 1e-6 * move)
        slope = (behind - ahead) / 2e-6
        assert (found * move).sum() == pytest.approx(slope, abs=1e-6 * np.linalg.norm(found))


@each_tangent
@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("amount", [0.15, 0.6])
def test_force_equals_the_formula(amount: float, precision: Precision, tangent: Tangent) -> None:
    points = crumpled(MESH, amount).astype(precision).astype(np.float64)
    found = forces(assembled(points, precision=precision, tangent=tangent))
    expected = smoothed_volume_forces(MESH, SOFT, points)
    # strains are off by some eps |x| |g|, stresses by lambda of it
    bound = 1000.0 * epsilon(precision) * np.abs(expected).max()
    np.testing.assert_allclose(found, expected, atol=bound)


@pytest.mark.parametrize("angle", [0.0, 1.7, np.pi])
def test_rigid_motion_makes_no_force(angle: float) -> None:
    points = turned(MESH.points, (0.3, -1.0, 0.5), angle) + np.array([0.4, 1.0, -0.7])
    found = forces(assembled(points))
    largest = np.abs(forces(assembled(1.01 * MESH.points))).max()
    assert np.abs(found).max() < 1e4 * EPSILON * largest


@pytest.mark.parametrize("amount", [0.15, 0.6])
def test_forces_have_no_net_force_and_torque(amount: float) -> None:
    points = crumpled(MESH, amount)
    points -= points.mean(axis=0)
    found = forces(assembled(points))
    size = np.linalg.norm(found, axis=1)
    assert np.abs(found.sum(axis=0)).max() <= 100 * EPSILON * size.sum()
    torque = np.cross(points, found).sum(axis=0)
    assert np.abs(torque).max() <= 200 * EPSILON * (np.linalg.norm(points, axis=1) @ size)


@pytest.mark.parametrize("stretches", [(1.3, 0.9, 1.1), (0.4, 0.5, 0.6)])
def test_homogeneous_deformation_gives_the_linear_elements_forces(
    stretches: tuple[float, float, float],
) -> None:
    """All means are the same F then, and a tet's shares of its edges and nodes sum to one."""
    points = turned(MESH.points * stretches, (1.0, -1.0, 2.0), 1.2)
    smoothed, linear = (forces(assembled(points, elements)) for elements in ELEMENTS[::-1])
    np.testing.assert_allclose(smoothed, linear, atol=1e3 * EPSILON * np.abs(linear).max())


@pytest.mark.parametrize("amount", [0.15, 0.6])
def test_volume_s_matrix_bounds_that_of_the_nodes_in_every_shape(amount: float) -> None:
    """Jensen: ``sum_n V_n lambda |mean c . u|^2 <= sum_t V_t lambda (c_t . u)^2``, turned or not.

    With next to no shear the step's matrix is the volume's alone.
    """
    points = crumpled(MESH, amount)
    material = Material(
        young_modulus=1e5, poisson_ratio=0.4999999, stiffness_damping=0.0, volume="exact"
    )
    upper = stiffness(assembled(points, material=material))
    slopes, volumes = volume_slopes(MESH, points)
    nodes = material.lame_lambda * np.einsum("n,nk,nl->kl", volumes, slopes, slopes)
    assert np.linalg.eigvalsh(upper - nodes)[0] >= -1e-10 * np.linalg.norm(upper)
    # and at rest the two are not far apart: a tenth of the largest is the nodes' own
    assert np.linalg.norm(nodes, 2) > 0.1 * np.linalg.norm(upper, 2)


@each_tangent
@pytest.mark.parametrize("amount", [0.0, 0.15, 0.6, 2.0])
def test_matrix_is_positive_semidefinite(amount: float, tangent: Tangent) -> None:
    K = stiffness(assembled(crumpled(MESH, amount), tangent=tangent))
    np.testing.assert_allclose(K, K.T, atol=1e-12 * np.abs(K).max())
    assert np.linalg.eigvalsh(K)[0] >= -1e-12 * np.linalg.norm(K)


def test_conserving_tangent_takes_turns_to_zero() -> None:
    """It is the matrix of the linear elements, whose rotations are those of the tets' own F."""
    points = crumpled(MESH, amount=0.3)
    K = stiffness(assembled(points, tangent="conserving"))
    for axis in np.eye(3):
        turning = np.cross(axis, points).ravel()
        forces_of = np.abs(K) @ np.abs(turning)
        assert np.abs(K @ turning).max() <= 1e-12 * forces_of.max()
    linear = stiffness(assembled(points, "linear", tangent="conserving"))
    np.testing.assert_allclose(K, linear, atol=1e-12 * np.abs(linear).max())
