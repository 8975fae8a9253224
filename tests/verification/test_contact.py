"""Contact with a plane: weight, rest, Coulomb's law on a slope, and what must not happen."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from tests.support.bodies import Rig, box, rig
from warp_softbody.arrays import FloatArray
from warp_softbody.body.material import Material
from warp_softbody.body.mesh import TetMesh
from warp_softbody.contact_mode import ContactMode
from warp_softbody.kernels.contact.modes import MISSED
from warp_softbody.world.ground import Plane

G = 9.81
SOFT = Material(young_modulus=1e5, poisson_ratio=0.4, stiffness_damping=0.02)
STIFF = Material(young_modulus=1e7, poisson_ratio=0.3, stiffness_damping=0.005)


def block(height: float = 0.0, cells: tuple[int, int, int] = (3, 3, 3)) -> TetMesh:
    return box(cells, (0.2, 0.2, 0.2), (-0.1, -0.1, height))


def on_ground(
    mesh: TetMesh, material: Material = SOFT, friction: float = 0.5, **options: Any
) -> Rig:
    options = {"time_step": 0.01} | options
    return rig(
        mesh, material=material, ground=Plane(friction=friction), gravity=(0, 0, -G), **options
    )


def impulse(body: Rig) -> FloatArray:
    """Sum of the contact impulses of the last step, (3,) N s."""
    return np.asarray(body.contacts.impulses.numpy().astype(np.float64).sum(axis=0))


def energy(body: Rig) -> float:
    """Kinetic and potential energy, J; elastic energy only adds to it."""
    speeds = (body.velocities**2).sum(axis=1)
    return float(body.masses @ (0.5 * speeds + G * body.positions[:, 2]))


@pytest.mark.parametrize("material", [SOFT, STIFF], ids=["soft", "stiff"])
@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_resting_block_is_carried_by_its_contact_forces(precision: str, material: Material) -> None:
    body = on_ground(block(), material, precision=precision)
    body.step(300)
    start = body.positions
    weight = body.masses.sum() * G * 0.01
    for _ in range(10):
        statistics = body.step()
        assert statistics.converged and statistics.contact_converged
        np.testing.assert_allclose(impulse(body), [0.0, 0.0, weight], atol=1e-4 * weight)
    assert body.positions[:, 2].min() > -1e-4
    normal = body.contacts.impulses.numpy()[:, 2]
    assert normal.min() >= -1e-6 * weight
    body.step(490)
    # five seconds: no creep
    assert np.abs(body.positions - start).max() < 1e-4
    assert np.abs(body.velocities).max() < 1e-4


def test_coulomb_s_law_holds_at_every_node() -> None:
    """While a block thrown sideways slides, and after it has stuck."""
    friction = 0.5
    body = on_ground(block(), friction=friction)
    body.place(velocities=(1.0, 0.4, 0.0))
    weight = body.masses.sum() * G * 0.01
    surface = body.model.scene.character.mesh.surface_nodes
    # the part of the bound by which the solver may miss the law of a sliding node
    assert MISSED < 0.051
    seen = set()
    for _ in range(80):
        settled = body.step().contact_converged
        modes = body.contacts.modes.numpy()
        impulses = body.contacts.impulses.numpy().astype(np.float64)
        velocities = body.velocities[surface]
        normal, tangent = impulses[:, 2], impulses[:, :2]
        assert normal.min() > -1e-5 * weight
        if not settled:
            continue
        size = np.linalg.norm(tangent, axis=1)
        seen |= set(modes.tolist())
        # and for every node a millionth of the weight
        assert (size <= (1.001 + MISSED) * friction * normal + 3e-6 * weight).all()
        np.testing.assert_array_equal(impulses[modes == ContactMode.LIFT], 0.0)
        assert np.abs(velocities[modes == ContactMode.STICK, :2]).max(initial=0.0) < 1e-6
        slides = (modes == ContactMode.SLIDE) & (normal > 1e-3 * weight)
        speed = np.linalg.norm(velocities[:, :2], axis=1)
        slides &= speed > 1e-3
        # friction points against the sliding
        against = -np.einsum("ck,ck->c", tangent[slides], velocities[slides, :2])
        assert (against >= (0.99 - MISSED) * friction * normal[slides] * speed[slides]).all()
    assert seen == {0, 1, 2}
    assert np.abs(body.velocities).max() < 0.05


def on_slope(friction: float, degrees: float, **options: Any) -> tuple[Rig, FloatArray]:
    """A stiff block at rest on a slope, and the direction downhill."""
    angle = math.radians(degrees)
    normal = (math.sin(angle), 0.0, math.cos(angle))
    mesh = box((3, 3, 1), (0.3, 0.3, 0.06), (-0.15, -0.15, 0.0))
    lean = np.array(
        [[math.cos(angle), 0.0, math.sin(angle)], [0, 1, 0], [-math.sin(angle), 0, math.cos(angle)]]
    )
    mesh = TetMesh.from_arrays(mesh.points @ lean.T, mesh.tets)
    ground = Plane(friction=friction, normal=normal)
    options = {"time_step": 0.01} | options
    body = rig(mesh, material=STIFF, ground=ground, gravity=(0, 0, -G), **options)
    return body, np.array([math.cos(angle), 0.0, -math.sin(angle)])


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("margin", [0.5, 1.0, 2.0, 4.0, 8.0, 15.0])
@pytest.mark.parametrize("friction", [0.3, 0.8])
def test_block_sticks_below_the_friction_angle(
    friction: float, margin: float, precision: str
) -> None:
    """By any margin in degrees: after a second it holds still, and the contact modes settle."""
    limit = math.degrees(math.atan(friction))
    body, downhill = on_slope(friction, limit - margin, precision=precision)
    body.step(100)
    start = body.positions
    settled = [body.step().contact_converged for _ in range(200)]
    assert np.abs((body.positions - start) @ downhill).max() < 1e-4
    assert all(settled)


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("friction", [0.3, 0.8])
def test_block_slides_above_the_friction_angle(friction: float, precision: str) -> None:
    """At g (sin - mu cos), half a degree above the angle and ten degrees above."""
    limit = math.degrees(math.atan(friction))
    for excess, seconds in ((0.5, 2.0), (10.0, 1.0)):
        body, downhill = on_slope(friction, limit + excess, precision=precision)
        # the start, in which the block settles and begins to slide, is not measured
        body.step(50)
        start = body.momentum @ downhill / body.masses.sum()
        count = round(seconds / 0.01)
        body.step(count)
        speed = body.momentum @ downhill / body.masses.sum() - start
        angle = math.radians(limit + excess)
        expected = G * (math.sin(angle) - friction * math.cos(angle))
        assert speed / seconds == pytest.approx(expected, rel=0.02)
        normal = np.array(body.model.scene.ground.normal)  # type: ignore[union-attr]
        assert np.abs(body.positions @ normal).min() < 1e-4
        assert (body.positions @ normal).min() > -1e-4


@pytest.mark.parametrize("young_modulus", [1e5, 1e7])
@pytest.mark.parametrize("friction", [0.3, 0.8])
def test_settled_block_starts_to_slide(friction: float, young_modulus: float) -> None:
    """Every node sticks, then gravity leans two degrees beyond the angle: stiffness has no say."""
    material = Material(young_modulus=young_modulus, poisson_ratio=0.3, stiffness_damping=0.005)
    mesh = box((3, 3, 1), (0.3, 0.3, 0.06), (-0.15, -0.15, 0.0))
    body = on_ground(mesh, material, friction)
    body.step(50)
    angle = math.atan(friction) + math.radians(2.0)
    leaning = np.array([[math.sin(angle), 0.0, -math.cos(angle)]]) * G
    body.model.arrays.step.gravity.assign(leaning)
    body.step(20)
    start = body.momentum[0] / body.masses.sum()
    body.step(50)
    gained = body.momentum[0] / body.masses.sum() - start
    expected = G * (math.sin(angle) - friction * math.cos(angle))
    assert gained / 0.5 == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize("height", [0.05, 0.5])
def test_dropped_block_gains_no_energy_and_does_not_sink(height: float) -> None:
    body = on_ground(block(height), time_step=0.005)
    energies, lowest = [energy(body)], []
    for _ in range(400):
        body.step()
        energies.append(energy(body))
        lowest.append(body.positions[:, 2].min())
    # the bound is the start: elastic energy, not counted here, can only come back out of it
    assert max(energies) <= energies[0] * (1.0 + 1e-5)
    assert min(lowest) > -1e-4
    assert np.abs(body.velocities).max() < 1e-3
    assert lowest[-1] < 1e-4


def test_impact_bounces_at_most_as_high_as_it_fell() -> None:
    elastic = Material(young_modulus=1e5, poisson_ratio=0.4, stiffness_damping=0.0)
    body = on_ground(block(0.3), elastic, friction=0.0, time_step=0.002)
    centers = []
    for _ in range(600):
        body.step()
        centers.append(body.center[2])
    landed = int(np.argmin(centers[:250]))
    assert 0.11 < max(centers[landed:]) < 0.4


def test_frictionless_sliding_keeps_its_velocity() -> None:
    """1 m/s for a second, by the solver's relative tolerance of 1e-5 a step."""
    body = on_ground(block(), STIFF, friction=0.0)
    body.step(50)
    body.place(velocities=(0.8, -0.6, 0.0))
    start = body.momentum
    body.step(100)
    np.testing.assert_allclose(body.momentum[:2], start[:2], atol=100 * 1e-5 * body.masses.sum())
    np.testing.assert_allclose(body.center[:2], [0.8, -0.6], atol=1e-3)
    assert np.abs(body.velocities[:, 2]).max() < 1e-3


def test_friction_stops_a_thrown_block_where_coulomb_says() -> None:
    """A flat stiff block at 1.5 m/s slides v^2 / (2 mu g), one step's way more or less."""
    mesh = box((3, 3, 1), (0.3, 0.3, 0.06), (-0.15, -0.15, 0.0))
    body = on_ground(mesh, STIFF, friction=0.4, time_step=0.005)
    body.step(50)
    start = body.center[0]
    body.place(velocities=(1.5, 0.0, 0.0))
    body.step(120)
    way = body.center[0] - start
    assert way == pytest.approx(1.5**2 / (2 * 0.4 * G), abs=1.5 * 0.005 + 0.01 * 0.29)
    assert np.abs(body.velocities).max() < 1e-3


def test_pushed_block_leaves_the_ground() -> None:
    """No adhesion: an upward throw is a free flight from the first step on."""
    body = on_ground(block(), STIFF, precision="float64", tolerance=1e-12)
    body.step(100)
    body.place(velocities=(0.0, 0.0, 1.0))
    mass = body.masses.sum()
    for index in range(1, 16):
        body.step()
        np.testing.assert_allclose(impulse(body), 0.0, atol=0.0)
        assert body.momentum[2] == pytest.approx(mass * (1.0 - G * 0.01 * index), abs=1e-8)
    assert (body.contacts.modes.numpy() == ContactMode.LIFT).all()


@pytest.mark.parametrize("material", [SOFT, STIFF], ids=["soft", "stiff"])
def test_sunken_block_is_pushed_out_at_a_bounded_speed(material: Material) -> None:
    """5 cm below the ground: out at the recovery speed, not shot into the air."""
    body = on_ground(block(-0.05), material, recovery_speed=0.5)
    highest = 0.0
    for _ in range(200):
        body.step()
        highest = max(highest, body.center[2])
        assert np.abs(body.velocities).max() < 4 * 0.5
    assert body.positions[:, 2].min() > -1e-4
    # thrown up at 0.5 m/s the centre would rise by v^2 / 2g = 13 mm above the standing one
    assert highest < 0.1 + 1.5 * 0.5**2 / (2 * G) + 0.005
    assert np.abs(body.velocities).max() < 1e-2


def test_plane_anywhere_is_as_good_as_the_plane_at_zero() -> None:
    mesh = box((2, 2, 2), (0.2, 0.2, 0.2), (3.0, -1.0, 7.0))
    body = rig(
        mesh, material=SOFT, ground=Plane(offset=7.0), gravity=(0, 0, -G), precision="float64"
    )
    twin = rig(
        box((2, 2, 2)), material=SOFT, ground=Plane(), gravity=(0, 0, -G), precision="float64"
    )
    body.step(30)
    twin.step(30)
    np.testing.assert_allclose(
        body.positions - np.array([3.0, -1.0, 7.0]), twin.positions, atol=1e-6
    )


def test_fixed_nodes_under_the_ground_stay_where_they_are() -> None:
    mesh = box((2, 2, 2), (0.2, 0.2, 0.2), (0.0, 0.0, -0.1))
    buried = np.flatnonzero(mesh.points[:, 2] < -0.05)
    body = rig(
        mesh, material=SOFT, fixed=buried, ground=Plane(), gravity=(0, 0, -G), precision="float64"
    )
    body.step(50)
    np.testing.assert_array_equal(body.positions[buried], mesh.points[buried])
    assert np.isfinite(body.positions).all()
