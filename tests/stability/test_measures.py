"""The suite's own measures, against known answers."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.stability import starts
from benchmarks.stability.bodies import (
    bar_mesh,
    bending_frequency,
    body,
    sliver_mesh,
    tiny_tet_mesh,
)
from benchmarks.stability.cases import REDUCTION, settling_steps, spectral_radius
from benchmarks.stability.measures import Accuracy, StateProbe
from tests.support.bodies import crumpled, turn
from tests.verification import reference
from warp_softbody import Material
from warp_softbody.arrays import FloatArray

BAR = body(bar_mesh())
PROBE = StateProbe(BAR)
SINGLE = Accuracy(time_step=0.01, tolerance=0.0, epsilon=float(np.finfo(np.float32).eps))
STILL = np.zeros_like(BAR.mesh.points)


@pytest.mark.parametrize("begin", [starts.bent, starts.mirrored(1), starts.scattered(0)])
def test_elastic_energy_is_that_of_the_method(begin: starts.Begin) -> None:
    positions = begin(BAR).positions
    expected = reference.elastic_energy(BAR.mesh, BAR.material, positions)
    assert PROBE.sample(positions, STILL, SINGLE).elastic == pytest.approx(expected, rel=1e-12)


def test_forces_are_those_of_the_method() -> None:
    """Through the residual: a tolerance of 1 allows the work |M v + dt f| |v|."""
    positions = crumpled(BAR.mesh)
    velocities = np.full_like(positions, 0.1)
    forces = reference.elastic_forces(BAR.mesh, BAR.material, positions)
    right = PROBE.masses[:, None] * velocities + 0.01 * forces
    exact = Accuracy(time_step=0.01, tolerance=1.0, epsilon=0.0)
    sample = StateProbe(body(bar_mesh(), clamped=False)).sample(positions, velocities, exact)
    expected = np.linalg.norm(right) * np.linalg.norm(velocities)
    assert sample.energy_allowance == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("crumple", [0.0, 0.02, 0.15])
def test_rounding_of_positions_stays_within_the_allowance(crumple: float) -> None:
    positions = crumpled(BAR.mesh, crumple) if crumple else BAR.mesh.points
    sample = PROBE.sample(positions, STILL, SINGLE)
    rounded = positions.astype(np.float32).astype(np.float64)
    change = abs(PROBE.sample(rounded, STILL, SINGLE).elastic - sample.elastic)
    assert 0.0 < change < sample.energy_allowance
    # and says something: what it allows is far below what any motion has
    assert sample.energy_allowance < 1e-3 * max(1.0, sample.elastic)


def test_spin_and_kinetic_energy_of_a_turning_block() -> None:
    """Lumped masses have their own moment of inertia, computed here as a matrix."""
    mesh = bar_mesh((2, 2, 2))
    probe = StateProbe(body(mesh, clamped=False))
    omega = np.array([1.0, -2.0, 0.5])
    arms = mesh.points - probe.masses @ mesh.points / probe.masses.sum()
    inertia = np.einsum("n,nij->ij", probe.masses, _inertia(arms))
    sample = probe.sample(mesh.points + 3.0, np.cross(omega, arms), SINGLE)
    np.testing.assert_allclose(sample.spin, inertia @ omega, rtol=1e-12)
    assert sample.kinetic == pytest.approx(0.5 * omega @ inertia @ omega, rel=1e-12)


def _inertia(arms: FloatArray) -> FloatArray:
    squares = (arms**2).sum(axis=1)[:, None, None]
    return np.asarray(squares * np.eye(3) - arms[:, :, None] * arms[:, None])


def test_shape_error_ignores_rigid_motion_and_sees_one_node() -> None:
    moved = BAR.mesh.points @ turn((1.0, 2.0, -1.0), 2.5).T + [3.0, -1.0, 0.5]
    assert PROBE.shape_error(moved) < 1e-14
    moved[5] += [0.0, 0.06, 0.0]
    # a tenth of the length of 0.6 m, less what the best fit takes over to the other 62 nodes
    assert 0.08 < PROBE.shape_error(moved) < 0.1


def test_a_mirrored_body_has_a_shape_error_and_a_volume_of_minus_one() -> None:
    mirrored = BAR.mesh.points * [1.0, 1.0, -1.0]
    assert PROBE.volume(mirrored) == pytest.approx(-1.0)
    assert (PROBE.volumes(mirrored) < 0.0).all()
    assert PROBE.shape_error(mirrored) > 0.1


def test_poor_meshes_are_as_poor_as_they_say() -> None:
    slivers, tiny = sliver_mesh(0.1), tiny_tet_mesh()
    assert slivers.smallest_dihedral_angle == pytest.approx(0.1, rel=1e-3)
    assert len(slivers.tets) == 148
    others = np.sort(tiny.volumes)[12]
    assert tiny.volumes.min() / np.median(tiny.volumes) == pytest.approx(1e-6)
    assert others > 0.1 * np.median(tiny.volumes)
    assert tiny.volume == pytest.approx(bar_mesh().volume)
    assert slivers.volume == pytest.approx(bar_mesh().volume)


@pytest.mark.parametrize(("time_step", "damping"), [(0.01, 0.0), (0.01, 0.05), (0.5, 0.05)])
def test_settling_steps_settle(time_step: float, damping: float) -> None:
    """The scheme itself, one mass on a spring: half the steps leave it a thousandth."""
    frequency = 20.0
    steps = settling_steps(frequency, time_step, damping) // 2
    x, v = 1.0, 0.0
    largest = []
    for _ in range(steps):
        factor = 1.0 + time_step * damping * frequency**2 + time_step**2 * frequency**2
        v = (v - time_step * frequency**2 * x) / factor
        x += time_step * v
        largest.append(np.hypot(x, v / frequency))
    # an oscillation's norm is that of its eigenvectors' parts, of which two nearly parallel ones
    # may be large: a factor of ten is ample for these
    assert largest[-1] < 10.0 * REDUCTION
    assert spectral_radius(frequency, time_step, damping) < 1.0


def test_bending_frequency_of_a_slender_beam() -> None:
    """Blevins' table: f = 3.516 / (2 pi L^2) sqrt(E I / (rho A)), here 1.02 Hz."""
    material = Material(young_modulus=1e6, density=1000.0)
    frequency = bending_frequency(bar_mesh((10, 2, 2)), material)
    assert frequency / (2.0 * np.pi) == pytest.approx(1.0217, rel=1e-3)
