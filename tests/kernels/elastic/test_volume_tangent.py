"""Tangents of tets that resist their exact change of volume, against derivatives in NumPy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.support.bodies import box, crumpled, epsilon, numbers, rig
from tests.verification import reference
from tests.verification.volume_reference import volume_forces
from warp_softbody.arrays import FloatArray
from warp_softbody.body.material import Material
from warp_softbody.body.mesh import TetMesh
from warp_softbody.engine.options import TANGENTS, Precision, Tangent

SOFT = Material(young_modulus=1e5, poisson_ratio=0.45, stiffness_damping=0.0, volume="exact")
MESH = box((1, 2, 2), (0.2, 0.3, 0.25), jitter=0.2)

each_tangent = pytest.mark.parametrize("tangent", TANGENTS)


def stiffness_of(mesh: TetMesh, points: FloatArray, tangent: Tangent, **options: Any) -> FloatArray:
    """K (3n, 3n) from the step's matrix with dt = 1."""
    options = {"material": SOFT, "precision": "float64", **options}
    body = rig(mesh, time_step=1.0, tangent=tangent, **options)
    body.place(points)
    body.stepper.assemble(body.state)
    matrix = reference.block_matrix(body.model, numbers(body.stepper.assembly.values))
    return matrix - np.diag(np.repeat(body.masses, 3))


def measures(mesh: TetMesh, points: FloatArray) -> FloatArray:
    """Strain and det F of each tet, (m, 10): the energy is a sum of their squares."""
    F = reference.deformation_gradients(mesh, points)
    S = np.einsum("mki,mkj->mij", reference.polar_rotations(F), F)
    strain = (0.5 * (S + S.transpose(0, 2, 1)) - np.eye(3)).reshape(-1, 9)
    return np.column_stack([strain, np.linalg.det(F)])


def slopes(points: FloatArray, what: Any) -> FloatArray:
    """Derivative of ``what(points)`` by all coordinates, the last axis, by central differences."""
    columns = []
    for index in np.ndindex(*points.shape):
        move = np.zeros_like(points)
        move[index] = 1e-6
        columns.append((what(points + move) - what(points - move)) / 2e-6)
    return np.stack(columns, axis=-1)


@pytest.mark.parametrize("amount", [0.1, 0.3])
def test_conserving_tangent_is_the_gauss_newton_matrix(amount: float) -> None:
    """``sum V (2 mu (d eps)^T d eps + lambda (d det F)^T d det F)``, with R's change in eps."""
    points = crumpled(MESH, amount)
    slope = slopes(points, lambda x: measures(MESH, x))
    weights = np.array([2.0 * SOFT.lame_mu] * 9 + [SOFT.lame_lambda])
    expected = np.einsum("m,i,mik,mil->kl", MESH.volumes, weights, slope, slope)
    found = stiffness_of(MESH, points, "conserving")
    np.testing.assert_allclose(found, expected, atol=1e-7 * np.abs(expected).max())


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_conserving_tangent_takes_rigid_motions_to_zero(precision: Precision) -> None:
    """In strained shapes: turns by rounding of K and x, translations by that of the row sums."""
    mesh = box((2, 2, 2), (0.2, 0.3, 0.25), jitter=0.2)
    points = crumpled(mesh, amount=0.3).astype(precision).astype(np.float64)
    # without the mass, whose digits would hide those of K
    material = Material(
        young_modulus=1e5, poisson_ratio=0.45, density=1e-9, stiffness_damping=0.0, volume="exact"
    )
    K = stiffness_of(mesh, points, "conserving", material=material, precision=precision)
    for axis in np.eye(3):
        for motion in (np.cross(axis, points), np.tile(axis, (len(points), 1))):
            sums = np.abs(K) @ np.abs(motion).ravel()
            left = np.abs(K @ motion.ravel()).max()
            assert left <= 1000.0 * epsilon(precision) * sums.max()


@each_tangent
def test_tangent_at_rest_is_that_of_linear_elasticity(tangent: Tangent) -> None:
    plain = Material(young_modulus=1e5, poisson_ratio=0.45, stiffness_damping=0.0)
    expected = stiffness_of(MESH, MESH.points, "warped", material=plain)
    found = stiffness_of(MESH, MESH.points, tangent)
    np.testing.assert_allclose(found, expected, atol=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize("across", [0.9, 1.0, 1.15])
def test_exact_tangent_is_the_derivative_of_the_force(across: float) -> None:
    """A little swollen, tets' second derivatives are semidefinite, so nothing is cut off."""
    points = crumpled(MESH, amount=0.01) * (across, 1.0, 1.0 / across)
    swelling = np.linalg.det(reference.deformation_gradients(MESH, points)).mean()
    points *= (1.06 / swelling) ** (1.0 / 3.0)
    expected = -slopes(points, lambda x: volume_forces(MESH, SOFT, x).ravel())
    found = stiffness_of(MESH, points, "exact")
    np.testing.assert_allclose(found, expected, atol=1e-7 * np.abs(expected).max())
    # and the pressure's part is no small one
    gap = np.abs(stiffness_of(MESH, points, "warped") - expected).max()
    assert gap > 0.01 * np.abs(expected).max()


@each_tangent
@pytest.mark.parametrize("amount", [0.0, 0.15, 0.6, 2.0])
@pytest.mark.parametrize("scale", [0.5, 1.0, 2.0])
def test_every_tangent_is_positive_semidefinite(
    amount: float, scale: float, tangent: Tangent
) -> None:
    """Also with tets squashed, swollen and inside out."""
    mesh = box((2, 2, 3), (0.2, 0.3, 0.4), jitter=0.2)
    K = stiffness_of(mesh, scale * crumpled(mesh, amount), tangent)
    np.testing.assert_allclose(K, K.T, atol=1e-12 * np.abs(K).max())
    assert np.linalg.eigvalsh(K).min() >= -1e-12 * np.linalg.norm(K)


@each_tangent
def test_both_precisions_agree(tangent: Tangent) -> None:
    """float32 rounds F by some eps, and pressure takes lambda / mu = 9 times as much of it."""
    points = crumpled(MESH, amount=0.1)
    single = stiffness_of(MESH, points, tangent, precision="float32")
    double = stiffness_of(MESH, points, tangent)
    np.testing.assert_allclose(single, double, atol=500 * epsilon("float32") * np.abs(double).max())
