"""Tangents with exact change of volume: momenta, Newton's method, statics."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.support.bodies import EXACT, Rig, box, crumpled, numbers, rig
from tests.verification import reference
from tests.verification.implicit_euler import residual, rounding
from warp_softbody.arrays import FloatArray
from warp_softbody.body.material import Material
from warp_softbody.engine.options import TANGENTS, Tangent
from warp_softbody.world.ground import Plane

MESH = box((2, 2, 3), (0.2, 0.3, 0.4), jitter=0.2)
UNDAMPED = Material(
    young_modulus=1e5,
    poisson_ratio=0.4,
    stiffness_damping=0.0,
    mass_damping=0.7,
    volume="exact",
)

each_tangent = pytest.mark.parametrize("tangent", TANGENTS)


def swollen() -> FloatArray:
    """Turned, sheared and shaken, with 1.5 of its volume: in tension nothing is cut off."""
    points = crumpled(MESH, amount=0.02)
    swelling = np.linalg.det(reference.deformation_gradients(MESH, points)).mean()
    return np.asarray(points * (1.5 / swelling) ** (1.0 / 3.0))


def stepped(iterations: int, tangent: Tangent, **options: Any) -> Rig:
    """A swollen body, shaken, still growing, pushed, after one step."""
    rng = np.random.default_rng(1)
    chosen = {"newton_iterations": iterations, "tangent": tangent, **options, **EXACT}
    body = rig(MESH, material=UNDAMPED, time_step=0.01, gravity=(1.0, 2.0, -9.81), **chosen)
    points = swollen()
    body.place(points, rng.uniform(-0.3, 0.3, points.shape) + 5.0 * points)
    body.push(rng.uniform(-1.0, 1.0, points.shape))
    assert body.step().converged
    return body


def test_exact_tangent_converges_quadratically() -> None:
    """Each reduction is the square of the one before, times what the direction changes (ten)."""
    bodies = [stepped(count, "exact") for count in (1, 2, 3, 4, 8)]
    left = [float(np.linalg.norm(residual(body))) for body in bodies]
    floor = rounding(bodies[-1])
    reductions = np.array(left[1:4]) / left[:3]
    assert reductions[0] < 0.1
    assert reductions[1] < 10.0 * reductions[0] ** 2
    assert left[3] < max(floor, 10.0 * reductions[1] ** 2 * left[2])
    assert left[4] < floor


@pytest.mark.parametrize("tangent", ["warped", "conserving"])
def test_other_tangents_converge_linearly(tangent: Tangent) -> None:
    """To the same velocities, each iteration by half and more: neither has the pressure's part."""
    left = [np.linalg.norm(residual(stepped(count, tangent))) for count in (2, 3, 4, 5)]
    assert (np.array(left[1:]) < 0.5 * np.array(left[:-1])).all()
    limit = stepped(60, tangent)
    assert np.linalg.norm(residual(limit)) < rounding(limit)
    expected = stepped(8, "exact").velocities
    np.testing.assert_allclose(limit.velocities, expected, atol=1e-9 * np.abs(expected).max())


def pinned(damping: float, tangent: Tangent) -> float:
    """Share of its angular momentum about a corner's pin that a strained body loses in 0.25 s.

    Nothing is given back to a body that something holds, so that this is the matrix's own doing.
    """
    material = replace(UNDAMPED, mass_damping=0.0, stiffness_damping=damping)
    body = rig(MESH, material=material, fixed=[0], time_step=0.01, tangent=tangent, **EXACT)
    points = MESH.points - MESH.points[0]
    points = points @ np.array([[1.0, 0.2, 0.0], [0.0, 0.9, 0.0], [0.1, 0.0, 1.2]]).T
    body.place(points, np.cross([0.0, 1.0, 4.0], points))
    momenta = []
    for _ in range(26):
        momenta.append(body.masses @ np.cross(body.positions, body.velocities))
        body.step()
    assert np.ptp(body.positions - points, axis=0).max() > 0.05
    return float(np.linalg.norm(momenta[-1] - momenta[0]) / np.linalg.norm(momenta[0]))


@pytest.mark.parametrize("damping", [0.0, 0.02])
def test_conserving_tangent_keeps_angular_momentum(damping: float) -> None:
    """To the solver's residual, strained and damped as it is."""
    assert pinned(damping, "conserving") < 1e-10


def test_the_warped_tangent_does_not() -> None:
    """Negative control: it damps the turn of a strained body."""
    assert pinned(0.02, "warped") > 0.01


@each_tangent
def test_free_body_keeps_its_momenta(tangent: Tangent) -> None:
    body = rig(MESH, material=replace(UNDAMPED, mass_damping=0.0), tangent=tangent, **EXACT)
    points = crumpled(MESH, amount=0.2)
    points -= points.mean(axis=0)
    body.place(points, np.cross([1.0, -2.0, 3.0], points) + np.array([0.5, 0.0, 1.0]))
    linear, angular = body.momentum, body.angular_momentum
    body.step(50)
    np.testing.assert_allclose(body.momentum, linear, atol=1e-10)
    np.testing.assert_allclose(body.angular_momentum, angular, atol=1e-10)


def test_statics_do_not_depend_on_the_tangent() -> None:
    """A beam sags as far with each: only the way there is the matrix's."""
    mesh = box((6, 2, 2), (0.6, 0.2, 0.2))
    fixed = np.flatnonzero(mesh.points[:, 0] < 1e-9)
    options: dict[str, Any] = {"fixed": fixed, "gravity": (0.0, 0.0, -9.81), "time_step": 0.5}
    ends = []
    for tangent in TANGENTS:
        body = rig(mesh, material=UNDAMPED, tangent=tangent, **options, **EXACT)
        body.step(100)
        ends.append(body.positions)
    sag = float((mesh.points - ends[0])[:, 2].max())
    assert sag > 0.01
    for end in ends[1:]:
        np.testing.assert_allclose(end, ends[0], atol=1e-6 * sag)


@each_tangent
def test_step_with_contact_solves_its_equation(tangent: Tangent) -> None:
    """Thrown on the ground and along it: what the forces at x+ leave is the contact's impulses."""
    mesh = box((3, 3, 3))
    scene: dict[str, Any] = {"ground": Plane(friction=0.5), "gravity": (0.0, 0.0, -9.81)}
    options: dict[str, Any] = {"time_step": 0.01, "tangent": tangent, "newton_iterations": 40}
    body = rig(mesh, material=UNDAMPED, **scene, **options, **EXACT)
    body.place(velocities=(0.5, 0.2, -1.0))
    assert body.step().contact_converged
    impulses = np.zeros_like(mesh.points)
    impulses[mesh.surface_nodes] = numbers(body.contacts.impulses)
    assert impulses[:, 2].sum() > 1.0 and impulses[:, 2].min() >= 0.0
    assert np.linalg.norm(residual(body) - impulses) < rounding(body)
