"""Smoothed tets with exact volume: sag, patch test, energy, momenta, contact, recovery."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest

from tests.support.bodies import EXACT, Rig, box, crumpled, rig
from tests.verification.volume_reference import smoothed_volume_energy
from warp_softbody.arrays import FloatArray
from warp_softbody.body.material import Material
from warp_softbody.engine.options import Tangent
from warp_softbody.world.ground import Plane

# Fall of the beam's tip as in test_smoothed.py, by the same hexahedra, m: with exact volume it is
# 0.0002 to 0.0003 m larger on the same mesh (4, 6 and 8 x 2, 2 and 4 x 2, 2 and 4 cells alike).
CONVERGED = {0.3: 0.3449, 0.4: 0.3417, 0.45: 0.3396, 0.49: 0.3374}

each_tangent = pytest.mark.parametrize("tangent", ["warped", "conserving"])


def material_of(poisson_ratio: float, modulus: float = 1e5, damping: float = 0.0) -> Material:
    """With exact volume."""
    return Material(
        young_modulus=modulus,
        poisson_ratio=poisson_ratio,
        stiffness_damping=damping,
        volume="exact",
    )


def volumes(body: Rig) -> FloatArray:
    """Of all tets, (m,) m^3."""
    corners = body.positions[body.model.body.mesh.tets]
    return np.asarray(np.linalg.det(corners[:, 1:] - corners[:, :1]) / 6.0)


@pytest.mark.parametrize("poisson_ratio", CONVERGED)
def test_coarse_beam_sags_within_a_tenth_of_the_converged_value(poisson_ratio: float) -> None:
    """810 tets; linear ones reach 73, 64, 53 and 25 %. Its volume stays within a thousandth."""
    mesh = box((15, 3, 3), (1.0, 0.2, 0.2))
    along = mesh.points[:, 0]
    options: dict[str, Any] = {"time_step": 0.5, "precision": "float64", "elements": "smoothed"}
    fixed = np.flatnonzero(along < 1e-9)
    material = material_of(poisson_ratio, modulus=1e6)
    body = rig(mesh, material=material, fixed=fixed, gravity=(0.0, 0.0, -9.81), **options)
    tip = along > 1.0 - 1e-9
    sag, last = 0.0, np.inf
    for _ in range(400):
        assert body.step().converged
        last, sag = sag, float((mesh.points - body.positions)[tip, 2].mean())
        if abs(sag - last) < 1e-5 * sag:
            break
    assert abs(sag - last) < 1e-5 * sag
    assert sag == pytest.approx(CONVERGED[poisson_ratio], rel=0.1)
    assert volumes(body).sum() == pytest.approx(mesh.volumes.sum(), rel=1e-3)


def test_inner_nodes_find_the_affine_displacement() -> None:
    """Patch test: only the surface is given, statics finds the rest."""
    mesh = box((3, 3, 3), (0.3, 0.3, 0.3), jitter=0.3)
    affine = np.array([[1.2, 0.1, 0.0], [0.0, 0.9, 0.2], [0.0, 0.0, 1.1]])
    surface = mesh.surface_nodes
    options: dict[str, Any] = {"fixed": surface, "time_step": 1.0, "elements": "smoothed"}
    body = rig(mesh, material=material_of(0.3), **options, **EXACT)
    expected = mesh.points @ affine.T
    start = mesh.points.copy()
    start[surface] = expected[surface]
    body.place(start)
    for _ in range(300):
        body.step()
        body.place(velocities=(0.0, 0.0, 0.0))
    np.testing.assert_allclose(body.positions, expected, atol=1e-9)


@each_tangent
@pytest.mark.parametrize("poisson_ratio", [0.3, 0.45])
def test_wide_swing_gains_no_energy(poisson_ratio: float, tangent: Tangent) -> None:
    """A beam of 0.6 m thrown at 2 m/s into bending, undamped; its tip moves by 0.15 m."""
    mesh = box((6, 2, 2), (0.6, 0.15, 0.15))
    clamped = np.flatnonzero(mesh.points[:, 0] < 1e-9)
    material = material_of(poisson_ratio, modulus=2e4)
    options: dict[str, Any] = {"time_step": 3e-3, "elements": "smoothed", "tangent": tangent}
    body = rig(mesh, material=material, fixed=clamped, **options, **EXACT)
    bend = np.outer((mesh.points[:, 0] / 0.6) ** 2, [0.0, 0.0, 2.0])
    body.place(velocities=bend)
    energies, falls = [], []
    for _ in range(130):
        kinetic = 0.5 * float(body.masses @ (body.velocities**2).sum(axis=1))
        energies.append(kinetic + smoothed_volume_energy(mesh, material, body.positions))
        body.step()
        falls.append(np.abs(body.positions - mesh.points).max())
    assert max(falls) > 0.15
    assert (np.diff(energies) < 1e-12 * energies[0]).all()


@pytest.mark.parametrize("damping", [0.0, 0.02])
def test_conserving_tangent_keeps_angular_momentum_about_a_pin(damping: float) -> None:
    """Nothing is given back to a body that something holds: this is the matrix's own doing."""
    mesh = box((2, 2, 3), (0.2, 0.3, 0.4), jitter=0.2)
    options: dict[str, Any] = {"elements": "smoothed", "tangent": "conserving", "fixed": [0]}
    body = rig(
        mesh, material=material_of(0.45, damping=damping), time_step=0.01, **options, **EXACT
    )
    points = mesh.points - mesh.points[0]
    points = points @ np.array([[1.0, 0.2, 0.0], [0.0, 0.9, 0.0], [0.1, 0.0, 1.2]]).T
    body.place(points, np.cross([0.0, 1.0, 4.0], points))
    momenta = []
    for _ in range(26):
        momenta.append(body.masses @ np.cross(body.positions, body.velocities))
        body.step()
    assert np.linalg.norm(momenta[-1] - momenta[0]) < 1e-10 * np.linalg.norm(momenta[0])


@each_tangent
def test_free_body_keeps_its_momenta(tangent: Tangent) -> None:
    mesh = box((2, 2, 3), (0.2, 0.3, 0.4), jitter=0.2)
    options: dict[str, Any] = {"elements": "smoothed", "tangent": tangent}
    body = rig(mesh, material=material_of(0.45), **options, **EXACT)
    points = crumpled(mesh, amount=0.2)
    points -= points.mean(axis=0)
    body.place(points, np.cross([1.0, -2.0, 3.0], points) + np.array([0.5, 0.0, 1.0]))
    linear, angular = body.momentum, body.angular_momentum
    body.step(50)
    np.testing.assert_allclose(body.momentum, linear, atol=1e-10)
    np.testing.assert_allclose(body.angular_momentum, angular, atol=1e-10)


@each_tangent
def test_dropped_block_lands_and_bears_its_weight(tangent: Tangent) -> None:
    mesh = box((3, 3, 3), (0.2, 0.2, 0.2), (0.0, 0.0, 0.05))
    scene: dict[str, Any] = {"ground": Plane(friction=0.5), "gravity": (0.0, 0.0, -9.81)}
    options: dict[str, Any] = {"time_step": 0.01, "elements": "smoothed", "tangent": tangent}
    body = rig(mesh, material=material_of(0.45, damping=0.01), **scene, **options)
    body.place(velocities=(0.5, 0.2, -1.0))
    for _ in range(120):
        statistics = body.step()
        assert statistics.converged and statistics.finite
    assert statistics.touching == 16
    impulse = body.contacts.impulses.numpy().sum(axis=0)
    weight = body.masses.sum() * 9.81 * 0.01
    np.testing.assert_allclose(impulse, [0.0, 0.0, weight], atol=1e-2 * weight)


REST = box((3, 2, 2), (0.3, 0.2, 0.2), jitter=0.2)
MIDDLE = REST.points.mean(axis=0)
STARTS: dict[str, FloatArray] = {
    "stretched": REST.points * [3.0, 1.0, 1.0],
    "mirrored": REST.points * [-1.0, 1.0, 1.0],
    "squashed": MIDDLE + (REST.points - MIDDLE) * [1.0, 1.0, 0.05],
    "random": np.random.default_rng(4).uniform((0.0, 0.0, 0.0), (0.3, 0.2, 0.2), REST.points.shape),
}
STEPS = (1e-2, 0.1, 0.5)
TANGLED = (("mirrored", 0.45, 0.01), ("mirrored", 0.499, 0.01), ("random", 0.499, 0.01))
"""Where tets stay inside out: pulled through each other, their nodes have their volume without."""
FLUNG = (("random", 0.499, 0.1), ("random", 0.499, 0.5))


def cases() -> list[Any]:
    """All starts, materials and steps, and whether the body is whole again."""
    reason = "det F is cubic: a long linearised step about a tangle overshoots without bound"
    # a body that was flung may come back: rounding decides, and with it the processor
    far = pytest.mark.xfail(strict=False, reason=reason)
    found = []
    for case in itertools.product(STARTS, (0.3, 0.45, 0.499), STEPS):
        marks = [far] if case in FLUNG else []
        found.append(pytest.param(*case, case not in (*TANGLED, *FLUNG), marks=marks))
    return found


@each_tangent
@pytest.mark.parametrize(("start", "poisson_ratio", "step", "whole"), cases())
def test_body_recovers_from_any_shape(
    start: str, poisson_ratio: float, step: float, whole: bool, tangent: Tangent
) -> None:
    """Clamped at one end, two seconds or a hundred and fifty steps: its volume is back.

    Where it need not be ``whole``, tets may stay inside out as those of linear elements do, but the
    body stays in bounds with 0.95 of its volume.
    """
    clamped = np.flatnonzero(REST.points[:, 0] < 1e-9)
    options: dict[str, Any] = {"time_step": step, "elements": "smoothed", "tangent": tangent}
    body = rig(REST, material=material_of(poisson_ratio, damping=0.02), fixed=clamped, **options)
    points = STARTS[start].copy()
    points[clamped] = REST.points[clamped]
    body.place(points)
    # kinetic and elastic energy fall, so no stretch exceeds a few times the largest at the start
    size = 3.0 * max(np.ptp(points, axis=0).max(), np.ptp(REST.points, axis=0).max())
    for _ in range(max(150, round(2.0 / step))):
        body.step()
        assert np.ptp(body.positions, axis=0).max() < size
    share = 0.01 if whole else 0.05
    assert volumes(body).sum() == pytest.approx(REST.volumes.sum(), rel=share)
    assert volumes(body).min() > 0.0 or not whole
