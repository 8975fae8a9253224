"""Elasticity with known answers: patch test, uniform stress, one mode, the cantilever's sag."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import eigh

from tests.support.bodies import EXACT, Rig, box, rig, turn
from tests.verification import reference
from warp_softbody.body.material import Material

SOFT = Material(young_modulus=1e5, poisson_ratio=0.3, stiffness_damping=0.0)


def test_affine_displacement_leaves_inner_nodes_without_force() -> None:
    """Patch test on an irregular mesh, the affine map stretched, sheared and turned."""
    mesh = box((3, 3, 3), (0.3, 0.3, 0.3), jitter=0.3)
    affine = turn((1.0, -1.0, 2.0), 1.2) @ np.array([[1.2, 0.1, 0.0], [0.0, 0.9, 0.2], [0, 0, 1.1]])
    body = rig(mesh, material=SOFT, precision="float64", time_step=1.0)
    body.place(mesh.points @ affine.T)
    body.stepper.assemble(body.state)
    forces = body.stepper.assembly.momentum.numpy()
    inner = np.setdiff1d(np.arange(len(mesh.points)), mesh.surface_nodes)
    assert len(inner) == 8
    np.testing.assert_allclose(forces[inner], 0.0, atol=1e-12 * np.abs(forces).max())


def test_inner_nodes_find_the_affine_displacement() -> None:
    """Patch test as it is meant: only the surface is given, statics finds the rest."""
    mesh = box((3, 3, 3), (0.3, 0.3, 0.3), jitter=0.3)
    affine = np.array([[1.2, 0.1, 0.0], [0.0, 0.9, 0.2], [0.0, 0.0, 1.1]])
    body = rig(mesh, material=SOFT, fixed=mesh.surface_nodes, time_step=1.0, **EXACT)
    expected = mesh.points @ affine.T
    start = mesh.points.copy()
    start[mesh.surface_nodes] = expected[mesh.surface_nodes]
    body.place(start)
    settle(body, 60)
    np.testing.assert_allclose(body.positions, expected, atol=1e-9)


def settle(body: Rig, steps: int) -> None:
    """Steps from standstill, again and again: damped Newton iterations for the static answer."""
    for _ in range(steps):
        body.step()
        body.place(velocities=(0.0, 0.0, 0.0))


@pytest.mark.parametrize("stress", [2e3, 2e4])
def test_uniform_stress_gives_the_analytic_strain(stress: float) -> None:
    """Dead tractions on both ends: stretch 1 + t/E along and 1 - nu t/E across, also at 20 %."""
    mesh = box((3, 2, 2), (0.3, 0.2, 0.2), jitter=0.3)
    forces = np.zeros_like(mesh.points)
    for end, sign in ((0.0, -1.0), (0.3, 1.0)):
        faces = mesh.surface[(np.abs(mesh.points[mesh.surface, 0] - end) < 1e-9).all(axis=1)]
        a, b, c = mesh.points[faces].transpose(1, 0, 2)
        area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
        assert area.sum() == pytest.approx(0.04)
        np.add.at(forces[:, 0], faces, sign * stress * area[:, None] / 3.0)
    # short enough that the load's turning moment, which the matrix does not hold, stays stable
    body = rig(mesh, material=SOFT, time_step=0.02, **EXACT)
    body.push(forces)
    settle(body, 400)
    F = reference.deformation_gradients(mesh, body.positions)
    strain = stress / SOFT.young_modulus
    expected = np.diag([1.0 + strain, 1.0 - 0.3 * strain, 1.0 - 0.3 * strain]) ** 2
    # F^T F, for nothing holds the body against a slow turn about its axis
    found = F.transpose(0, 2, 1) @ F
    np.testing.assert_allclose(found, np.broadcast_to(expected, F.shape), atol=1e-9)


@pytest.mark.parametrize("mass_damping", [0.0, 3.0])
@pytest.mark.parametrize("stiffness_damping", [0.0, 0.02])
def test_one_mode_decays_at_the_scheme_s_rate(
    mass_damping: float, stiffness_damping: float
) -> None:
    """``v+ = v / (1 + dt mu + (dt lambda + dt^2) w^2)`` for an eigenvector of (K, M) at rest."""
    material = Material(
        young_modulus=1e5,
        poisson_ratio=0.3,
        stiffness_damping=stiffness_damping,
        mass_damping=mass_damping,
    )
    mesh = box((2, 2, 2), jitter=0.3)
    dt = 0.01
    body = rig(mesh, material=material, time_step=dt, **EXACT)
    K = reference.warped_stiffness(mesh, material, mesh.points)
    squares, modes = eigh(K, np.diag(np.repeat(body.masses, 3)))
    np.testing.assert_allclose(squares[:6], 0.0, atol=1e-9 * squares[-1])
    for index in (6, 11, 30, len(squares) - 1):
        velocities = modes[:, index].reshape(-1, 3)
        body.place(mesh.points, velocities)
        body.step()
        decay = 1.0 + dt * mass_damping + dt * (stiffness_damping + dt) * squares[index]
        expected = velocities / decay
        # the solve stops at 1e-13 of the momentum, before it is divided by the decay
        bound = 1e-11 * np.abs(velocities).max()
        np.testing.assert_allclose(body.velocities, expected, atol=bound)


def test_stiffness_damping_leaves_rigid_motion_alone() -> None:
    """No damping of a translation, nor of a turn, which its centrifugal load alone stretches."""
    material = Material(young_modulus=1e5, poisson_ratio=0.3, stiffness_damping=0.5)
    mesh = box((2, 2, 2), jitter=0.3)
    body = rig(mesh, material=material, time_step=0.01, **EXACT)
    body.place(velocities=(1.0, -2.0, 0.5))
    body.step(10)
    np.testing.assert_allclose(body.velocities, np.tile([1.0, -2.0, 0.5], (27, 1)), atol=1e-10)
    turning = np.cross([0.0, 0.0, 2.0], mesh.points - mesh.points.mean(axis=0))
    body.place(mesh.points, turning)
    spin = body.angular_momentum
    body.step()
    np.testing.assert_allclose(body.angular_momentum, spin, atol=1e-10)
    arms = body.positions - body.center
    # w^2 r dt, of which damping leaves next to nothing
    rigid = np.cross([0.0, 0.0, 2.0], arms) + body.momentum / body.masses.sum()
    np.testing.assert_allclose(body.velocities, rigid, atol=1e-3)


def test_cantilever_sags_as_much_as_with_vegafem() -> None:
    """VegaFEM's value: 810 corotational tets sag by 0.21750 m; it is statics, dt has no say."""
    mesh = box((15, 3, 3), (1.0, 0.2, 0.2))
    assert len(mesh.tets) == 810
    material = Material(young_modulus=1e6, poisson_ratio=0.4, density=1000.0, stiffness_damping=0.1)
    clamped = np.flatnonzero(mesh.points[:, 0] < 1e-9)
    tip = np.flatnonzero(mesh.points[:, 0] > 1.0 - 1e-9)
    body = rig(mesh, material=material, fixed=clamped, gravity=(0.0, 0.0, -9.81), time_step=0.1)
    body.step(100)
    assert np.abs(body.velocities).max() < 1e-4
    sag = float((mesh.points[tip, 2] - body.positions[tip, 2]).mean())
    assert sag == pytest.approx(0.21750, rel=5e-3)
    np.testing.assert_array_equal(
        body.positions[clamped], mesh.points[clamped].astype(np.float32).astype(np.float64)
    )
