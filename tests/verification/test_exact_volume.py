"""Elasticity that resists the change of volume itself (docs/method.md section 1)."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from tests.support.bodies import Rig, box, crumpled, epsilon, numbers, rig
from warp_softbody import Character, Material
from warp_softbody.arrays import FloatArray
from warp_softbody.engine.options import TANGENTS, Precision, Tangent
from warp_softbody.errors import InputError

EXACT = Material(young_modulus=1e5, poisson_ratio=0.45, stiffness_damping=0.0, volume="exact")
MESH = box((3, 2, 2), (0.3, 0.2, 0.2), jitter=0.15)
TIME_STEP = 1e-3


def body(material: Material = EXACT) -> Character:
    return Character(name="body", mesh=MESH, material=material)


def still(material: Material = EXACT, **options: Any) -> Rig:
    return rig(body(material), gravity=(0.0, 0.0, 0.0), time_step=TIME_STEP, **options)


def gradients(points: FloatArray) -> FloatArray:
    """Deformation gradients (m, 3, 3)."""
    rest, now = (
        (p[MESH.tets[:, 1:]] - p[MESH.tets[:, :1]]).transpose(0, 2, 1)
        for p in (MESH.points, points)
    )
    return np.asarray(now @ np.linalg.inv(rest))


def energy(points: FloatArray, material: Material = EXACT) -> float:
    """Sum of V (mu |F - R|^2 + lambda / 2 (det F - 1)^2)."""
    F = gradients(points)
    left, stretch, right = np.linalg.svd(F)
    stretch[:, 2] *= np.linalg.det(left @ right)
    shear = ((stretch - 1.0) ** 2).sum(axis=1)
    swelling = (np.linalg.det(F) - 1.0) ** 2
    return float(MESH.volumes @ (material.lame_mu * shear + 0.5 * material.lame_lambda * swelling))


def forces(placed: Rig, points: FloatArray) -> FloatArray:
    """Elastic forces (n, 3), N: with no speed the known momentum of a step is dt times these."""
    placed.place(positions=points)
    placed.stepper.assemble(placed.state)
    return numbers(placed.stepper.assembly.momentum) / TIME_STEP


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("amount", [0.05, 0.3])
def test_forces_are_the_energy_s_derivative(precision: Precision, amount: float) -> None:
    """Along random directions, by central differences of step h.

    Their truncation is h^2 of third derivatives and their rounding eps E / h: with h = 1e-6 of the
    size some 1e-7 of the force.
    """
    points = crumpled(MESH, amount)
    found = forces(still(precision=precision), points)
    generator = np.random.default_rng(3)
    size = np.linalg.norm(found)
    for _ in range(5):
        way = generator.normal(size=points.shape)
        way /= np.linalg.norm(way)
        h = 1e-7
        slope = (energy(points + h * way) - energy(points - h * way)) / (2.0 * h)
        close = 1e-5 if precision == "float64" else 300.0 * epsilon("float32")
        assert -(found * way).sum() == pytest.approx(slope, abs=close * size)


def matrix(placed: Rig) -> FloatArray:
    """K of the assembled step, dense."""
    model = placed.model
    n, pattern = model.node_count, model.topology
    dense = np.zeros((n, 3, n, 3))
    rows = np.repeat(np.arange(n), np.diff(pattern.row_start))
    dense[rows, :, pattern.column, :] = numbers(placed.stepper.assembly.values)
    square = dense.reshape(3 * n, 3 * n)
    return np.asarray((square - np.diag(np.repeat(model.masses, 3))) / TIME_STEP**2)


def test_matrix_at_rest_is_that_of_linear_elasticity() -> None:
    """cof(I) = I: the two agree to rounding where nothing is strained."""
    found = []
    for volume in ("linear", "exact"):
        placed = still(replace(EXACT, volume=volume), precision="float64")
        placed.stepper.assemble(placed.state)
        found.append(matrix(placed))
    np.testing.assert_allclose(found[1], found[0], atol=1e-9 * np.abs(found[0]).max())


def test_matrix_is_symmetric_and_positive_semidefinite() -> None:
    placed = still(precision="float64")
    placed.place(positions=crumpled(MESH, 0.4))
    placed.stepper.assemble(placed.state)
    K = matrix(placed)
    size = np.abs(K).max()
    # the mass that is taken off again has digits of its own: eps m / dt^2
    np.testing.assert_allclose(K, K.T, atol=1e-9 * size)
    assert np.linalg.eigvalsh(0.5 * (K + K.T)).min() > -1e-8 * size


def test_squeezed_bar_swells_as_the_closed_form_says() -> None:
    """Stretched by s along x and by t across, so that its sides bear nothing.

    ``2 mu (t - 1) + lambda (J - 1) s t = 0`` with J = s t^2. At s = 0.6 the bar loses 7 % of its
    volume; one that resists the trace of its strain, 16 %.
    """
    mu, lam = EXACT.lame_mu, EXACT.lame_lambda
    s = 0.6
    t = brentq(lambda t: 2.0 * mu * (t - 1.0) + lam * (s * t * t - 1.0) * s * t, 1.0, 2.0)
    middle = MESH.points.mean(axis=0)
    points = middle + (MESH.points - middle) * (s, t, t)
    found = forces(still(precision="float64"), points)
    x = MESH.points[:, 0]
    sides = (x > 1e-9) & (x < 0.3 - 1e-9)
    assert np.abs(found[sides]).max() < 1e-9 * np.abs(found).max()
    assert np.abs(found[~sides][:, 1:]).max() < 1e-9 * np.abs(found).max()
    linear = brentq(lambda t: 2.0 * mu * (t - 1.0) + lam * (s + 2.0 * t - 3.0), 1.0, 2.0)
    assert abs(s * t * t - 1.0) < 0.5 * abs(s * linear * linear - 1.0)


@pytest.mark.parametrize("tangent", TANGENTS)
@pytest.mark.parametrize("amount", [0.5, 1.0])
def test_crumpled_body_comes_back(amount: float, tangent: Tangent) -> None:
    """Nodes thrown about by half an edge and a whole one, tets inverted: it ends at rest, whole.

    Damped with 0.05 s, slow modes have some 0.1 s; after two seconds speeds are e^-20.
    """
    damped = body(replace(EXACT, stiffness_damping=0.05))
    placed = rig(damped, gravity=(0.0, 0.0, 0.0), time_step=0.01, tangent=tangent)
    points = crumpled(MESH, amount)
    start = energy(points)
    placed.place(positions=points)
    for _ in range(200):
        statistics = placed.step()
        assert statistics.finite
    F = gradients(placed.positions)
    assert np.linalg.det(F).min() > 0.99
    assert energy(placed.positions) < 1e-6 * start


def test_free_body_keeps_its_momentum() -> None:
    """Forces of a tet sum to nothing by construction, and rows of K to nothing."""
    placed = still(precision="float64", tolerance=1e-12)
    placed.place(
        positions=crumpled(MESH, 0.2),
        velocities=np.random.default_rng(2).normal(size=MESH.points.shape),
    )
    before = placed.momentum
    placed.step(50)
    np.testing.assert_allclose(placed.momentum, before, atol=50 * 1e-12 * placed.masses.sum() * 3.0)


def test_volume_must_be_known() -> None:
    with pytest.raises(InputError, match=r"Material\.volume must be one of linear, exact"):
        Material(volume="cubic")  # type: ignore[arg-type]
