"""Blocks on slopes: half a degree decides, at any friction, mesh, stiffness and time step."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.support.bodies import Rig, box, rig, turned
from warp_softbody.arrays import FloatArray
from warp_softbody.body.material import Material
from warp_softbody.body.mesh import TetMesh
from warp_softbody.world.ground import Plane

G = 9.81
MARGIN = 0.5  # degrees
FRICTIONS = (0.1, 0.3, 0.6, 0.9, 1.2)
MESHES = ((2, 2, 1), (3, 3, 1), (5, 5, 2))
STEPS = (1 / 240, 1 / 60, 1 / 30)
STIFFNESSES = (1e5, 1e7)


def slab(
    friction: float, degrees: float, cells: tuple[int, int, int], dt: float, young_modulus: float
) -> tuple[Rig, FloatArray]:
    """A slab at rest on a slope, and the direction downhill."""
    angle = math.radians(degrees)
    flat = box(cells, (0.3, 0.3, 0.06), (-0.15, -0.15, 0.0))
    mesh = TetMesh.from_arrays(turned(flat.points, (0.0, 1.0, 0.0), angle), flat.tets)
    ground = Plane(friction=friction, normal=(math.sin(angle), 0.0, math.cos(angle)))
    material = Material(young_modulus=young_modulus, poisson_ratio=0.3, stiffness_damping=0.005)
    body = rig(mesh, material=material, ground=ground, gravity=(0.0, 0.0, -G), time_step=dt)
    return body, np.array([math.cos(angle), 0.0, -math.sin(angle)])


def check_it_stays(friction: float, cells: tuple[int, int, int], dt: float, E: float) -> None:
    """After a second, no node moves by 0.1 mm in another one, and every step converges."""
    limit = math.degrees(math.atan(friction))
    body, downhill = slab(friction, limit - MARGIN, cells, dt, E)
    body.step(round(1.0 / dt))
    start = body.positions
    assert all(body.step().contact_converged for _ in range(round(1.0 / dt)))
    assert np.abs((body.positions - start) @ downhill).max() < 1e-4


def check_it_slides(friction: float, cells: tuple[int, int, int], dt: float, E: float) -> None:
    """At g (sin - mu cos), by 2 %.

    The residual of a solve, a hundred-thousandth of the momentum, is 1e-4 of the change of momentum
    in a step of 1/240 s; a node's friction may be 5 % off only while its speed still changes.
    """
    degrees = math.degrees(math.atan(friction)) + MARGIN
    body, downhill = slab(friction, degrees, cells, dt, E)
    body.step(round(0.5 / dt))
    start = body.momentum @ downhill / body.masses.sum()
    body.step(round(1.0 / dt))
    gained = body.momentum @ downhill / body.masses.sum() - start
    angle = math.radians(degrees)
    expected = G * (math.sin(angle) - friction * math.cos(angle))
    assert gained / (round(1.0 / dt) * dt) == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize("dt", [1 / 240, 1 / 30])
@pytest.mark.parametrize("friction", [0.1, 1.2])
def test_half_a_degree_decides(friction: float, dt: float) -> None:
    check_it_stays(friction, (3, 3, 1), dt, 1e7)
    check_it_slides(friction, (3, 3, 1), dt, 1e7)


@pytest.mark.long
@pytest.mark.parametrize("young_modulus", STIFFNESSES)
@pytest.mark.parametrize("dt", STEPS)
@pytest.mark.parametrize("cells", MESHES)
def test_half_a_degree_decides_everywhere(
    cells: tuple[int, int, int], dt: float, young_modulus: float
) -> None:
    for friction in FRICTIONS:
        check_it_stays(friction, cells, dt, young_modulus)
        check_it_slides(friction, cells, dt, young_modulus)


@pytest.mark.long
@pytest.mark.parametrize("young_modulus", STIFFNESSES)
@pytest.mark.parametrize("dt", [1 / 120, 1 / 30])
def test_a_minute_of_rest_is_without_creep(dt: float, young_modulus: float) -> None:
    """Half a degree below the angle, after it has settled."""
    limit = math.degrees(math.atan(0.6))
    body, _ = slab(0.6, limit - MARGIN, (3, 3, 1), dt, young_modulus)
    body.step(round(2.0 / dt))
    start = body.positions
    body.step(round(60.0 / dt))
    assert np.abs(body.positions - start).max() < 1e-4
