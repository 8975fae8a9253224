"""Where contact methods fail: extreme friction, deep starts, single nodes, redundancy, loads."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.support.bodies import box, rig, turn
from tests.verification.dropped_cube import SIDE, G, cube
from warp_softbody.body.material import Material
from warp_softbody.body.mesh import TetMesh
from warp_softbody.engine.options import CONES, Cone
from warp_softbody.world.ground import Plane

pytestmark = pytest.mark.parametrize("cone", CONES)


@pytest.mark.parametrize("young_modulus", [1e5, 1e7])
def test_without_friction_the_cube_slides_on(young_modulus: float, cone: Cone) -> None:
    """Its momentum along the ground changes by the residual of the solves alone, 1e-5 a step."""
    body = cube(0.0, young_modulus, 0.02, 0.01, friction=0.0, cone=cone)
    body.place(velocities=(1.0, 0.0, 0.0))
    settled = [body.step().contact_converged for _ in range(100)]
    assert all(settled[10:])
    assert body.momentum[0] / body.masses.sum() == pytest.approx(1.0, abs=100 * 1e-5)


@pytest.mark.parametrize("young_modulus", [1e5, 1e7])
def test_friction_of_a_thousand_holds_what_touches(young_modulus: float, cone: Cone) -> None:
    body = cube(0.05, young_modulus, 0.02, 0.01, friction=1e3, cone=cone)
    body.place(velocities=(1.0, 0.0, 0.0))
    fastest = 0.0
    for _ in range(200):
        body.step()
        fastest = max(fastest, np.abs(body.velocities).max())
    # no faster than it came, falling for 5 cm at g and moving at 1 m/s
    assert fastest < math.hypot(1.0, math.sqrt(2 * G * 0.05))
    assert np.abs(body.velocities).max() < 1e-4


@pytest.mark.parametrize("friction", [0.5, 1e3])
@pytest.mark.parametrize("young_modulus", [1e5, 1e7])
def test_a_cube_half_below_the_ground_is_pushed_out(
    young_modulus: float, friction: float, cone: Cone
) -> None:
    """At the recovery speed, 0.5 m/s; twice that is the bound for what swings."""
    body = cube(-SIDE / 2, young_modulus, 0.02, 0.01, friction=friction, cone=cone)
    for _ in range(200):
        body.step()
        assert np.linalg.norm(body.velocities, axis=1).max() < 2 * 0.5
    assert body.positions[:, 2].min() > -1e-4
    assert np.abs(body.velocities).max() < 1e-4


@pytest.mark.parametrize("young_modulus", [1e5, 1e7])
def test_a_corner_carries_the_cube(young_modulus: float, cone: Cone) -> None:
    """Standing on one node: it tips over in its time, and never faster than a fall allows."""
    mesh = box((4, 4, 4), (SIDE,) * 3)
    upright = turn((1.0, 0.0, 0.0), math.atan(math.sqrt(2.0))) @ turn((0.0, 0.0, 1.0), math.pi / 4)
    points = mesh.points @ upright.T
    points[:, 2] -= points[:, 2].min()
    body = rig(
        TetMesh.from_arrays(points, mesh.tets),
        material=Material(young_modulus=young_modulus, poisson_ratio=0.4, stiffness_damping=0.02),
        ground=Plane(friction=0.5),
        gravity=(0.0, 0.0, -G),
        time_step=0.01,
        cone=cone,
    )
    assert body.step().touching == 1
    height = points[:, 2].max()
    for _ in range(300):
        body.step()
        assert np.linalg.norm(body.velocities, axis=1).max() < math.sqrt(2 * G * height)
        assert body.positions[:, 2].min() > -1e-4


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_redundant_contacts_of_a_rigid_like_cube(precision: str, cone: Cone) -> None:
    """E = 1e9 on 25 nodes: it lands, rests and is carried."""
    body = cube(0.01, 1e9, 0.001, 0.01, precision=precision, cone=cone)
    for _ in range(100):
        body.step()
        assert body.positions[:, 2].min() > -1e-4
    assert np.abs(body.velocities).max() < 1e-4
    normal = body.contacts.impulses.numpy().astype(np.float64)[:, 2]
    weight = body.masses.sum() * G * 0.01
    assert normal.sum() == pytest.approx(weight, rel=1e-4)
    assert normal.min() >= -1e-5 * weight


@pytest.mark.parametrize("young_modulus", [1e6, 1e7])
def test_a_push_of_a_hundred_body_weights(young_modulus: float, cone: Cone) -> None:
    """Straight down on the top: nothing sinks, and the ground answers with all of it."""
    body = cube(0.0, young_modulus, 0.02, 0.01, cone=cone)
    body.step(20)
    top = body.positions[:, 2] > SIDE - 1e-3
    weight = body.masses.sum() * G
    forces = np.zeros((body.model.node_count, 3))
    forces[top, 2] = -100 * weight / np.count_nonzero(top)
    body.push(forces)
    for _ in range(200):
        body.step()
        assert body.positions[:, 2].min() > -1e-4
    assert np.abs(body.velocities).max() < 1e-4
    normal = body.contacts.impulses.numpy().astype(np.float64)[:, 2].sum()
    assert normal == pytest.approx(101 * weight * 0.01, rel=1e-4)


def test_what_a_pass_too_few_leaves_is_reported(cone: Cone) -> None:
    """With one active-set pass a landing step violates the laws, and says by how much."""
    body = cube(0.0, 1e5, 0.02, 0.01, max_contact_passes=1, cone=cone)
    body.place(velocities=(1.0, 0.0, -1.0))
    statistics = body.step()
    assert not statistics.contact_converged
    # friction is not what the impulses of a landing at 1 m/s ask for
    assert max(statistics.signorini, statistics.coulomb) > body.masses.sum() * G / 25
    assert statistics.worst_node >= 0
    settled = cube(0.0, 1e5, 0.02, 0.01, cone=cone)
    settled.step(100)
    rest = settled.statistics
    assert rest is not None and rest.contact_converged
    assert max(rest.signorini, rest.coulomb) < 1e-2 * settled.masses.sum() * G
