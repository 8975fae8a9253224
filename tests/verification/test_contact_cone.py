"""Friction cones of four and eight directions: the law itself, slides and slopes."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.support.bodies import Rig, box, rig, turn
from warp_softbody.arrays import FloatArray
from warp_softbody.body.material import Material
from warp_softbody.body.mesh import TetMesh
from warp_softbody.contact_mode import ContactMode
from warp_softbody.controllers.contact_frames import contact_frame
from warp_softbody.engine.options import Cone, Precision
from warp_softbody.world.ground import Plane

G = 9.81
DT = 0.01
STIFF = Material(young_modulus=1e6, poisson_ratio=0.3, stiffness_damping=0.02)
LEVEL = (0.0, 0.0, 1.0)
LEANING = (0.36, -0.48, 0.8)
STEEP = (0.96, 0.0, 0.28)
POLYGONS: tuple[Cone, ...] = ("4", "8")
SHARE = 0.05
"""Share of the bound by which the friction of a sliding node may be off while its speed changes."""


def corners(cone: Cone, normal: tuple[float, float, float] = LEVEL) -> FloatArray:
    """The directions of a cone, (k, 3), in the controller's frame."""
    count = int(cone)
    angles = 2.0 * math.pi * np.arange(count) / count
    return np.column_stack([np.cos(angles), np.sin(angles)]) @ contact_frame(normal)[1:]


def slab(
    cone: Cone,
    friction: float,
    pull: FloatArray,
    normal: tuple[float, float, float] = LEVEL,
    precision: Precision = "float32",
    material: Material = STIFF,
) -> Rig:
    """A flat slab on a plane, with gravity ``pull`` (3,) m/s^2 whatever the plane's lean."""
    flat = box((3, 3, 1), (0.3, 0.3, 0.06), (-0.15, -0.15, 0.0))
    upright = np.cross(LEVEL, normal)
    angle = math.asin(np.linalg.norm(upright))
    lean = turn(upright.tolist(), angle) if angle else np.eye(3)
    x, y, z = pull.tolist()
    return rig(
        TetMesh.from_arrays(flat.points @ lean.T, flat.tets),
        material=material,
        ground=Plane(friction=friction, normal=normal),
        gravity=(x, y, z),
        time_step=DT,
        cone=cone,
        precision=precision,
    )


def point_mass(
    velocities: FloatArray, directions: FloatArray, decelerations: float, steps: int
) -> FloatArray:
    """Velocities (b, 3) of sliding points after every step of DT, (steps, b, 3).

    Friction is the corner that dissipates most, in explicit steps of DT / 100: it chatters over an
    edge, and about rest, by one such step, decelerations * DT / 100.
    """
    v, small, history = velocities.copy(), decelerations * DT / 100, []
    for _ in range(steps):
        for _ in range(100):
            v = v - small * directions[np.argmax(v @ directions.T, axis=1)]
        history.append(v)
    return np.array(history)


@pytest.mark.parametrize("normal", [LEVEL, LEANING, STEEP], ids=["level", "leaning", "steep"])
@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("cone", POLYGONS)
def test_block_slides_as_a_point_mass(
    cone: Cone, precision: Precision, normal: tuple[float, float, float]
) -> None:
    """Thrown in 24 directions at 2 m/s, until it stands.

    At first the deceleration is mu g times the support of the polygon; a throw between two corners
    is deflected towards the normal of the edge between them. By the friction that a node may miss
    in a step, at the throw and where it comes to an edge, and the residual of the solves, 1e-5 of
    the momentum in each of 150 steps.
    """
    friction, speed, steps = 0.2, 2.0, 150
    angles = 0.03 + 2.0 * math.pi * np.arange(24) / 24
    frame = contact_frame(normal)
    throws = speed * np.column_stack([np.cos(angles), np.sin(angles)]) @ frame[1:]
    expected = point_mass(throws, corners(cone, normal), friction * G, steps)
    atol = 2 * SHARE * friction * G * DT + 1e-5 * speed * steps + friction * G * DT / 100
    directions = range(24) if normal == LEVEL else range(0, 24, 5)
    for index in directions:
        body = slab(cone, friction, -G * frame[0], normal, precision)
        body.step(30)
        body.place(velocities=throws[index])
        for step in range(steps):
            statistics = body.step()
            assert statistics.contact_converged
            mean = body.momentum / body.masses.sum()
            np.testing.assert_allclose(mean, expected[step, index], atol=atol)
        assert np.abs(body.velocities).max() < atol


def radius(cone: Cone, angle: float) -> float:
    """Distance of the polygon's rim from its middle in a direction; the corners lie at one."""
    half = math.pi / int(cone)
    return math.cos(half) / math.cos(angle % (2.0 * half) - half)


def on_slope(cone: Cone, friction: float, angle: float, margin: float) -> tuple[Rig, FloatArray]:
    """A slab that gravity pulls along an angle, a margin in degrees beyond the rim of the cone.

    Also the acceleration that is expected: the pull less the nearest friction.
    """
    lean = math.atan(friction * radius(cone, angle)) + math.radians(margin)
    along = np.array([math.cos(angle), math.sin(angle), 0.0])
    pull = G * (math.sin(lean) * along - math.cos(lean) * np.array(LEVEL))
    material = Material(young_modulus=1e7, poisson_ratio=0.3, stiffness_damping=0.005)
    body = slab(cone, friction, pull, material=material)
    tips = friction * G * math.cos(lean) * corners(cone)
    tangential = G * math.sin(lean) * along
    return body, tangential - nearest_point(tips, tangential)


def nearest_point(tips: FloatArray, point: FloatArray) -> FloatArray:
    """Of a polygon with the corners given in order, to a point outside of it."""
    starts, ends = tips, np.roll(tips, -1, axis=0)
    edges = ends - starts
    share = ((point - starts) * edges).sum(axis=1) / (edges**2).sum(axis=1)
    candidates = starts + np.clip(share, 0.0, 1.0)[:, None] * edges
    return np.asarray(candidates[np.argmin(((candidates - point) ** 2).sum(axis=1))])


ANGLES = (0.0, 0.2, math.pi / 8, 0.6, math.pi / 4, 1.0, 2.9, 4.2)


@pytest.mark.parametrize("angle", ANGLES)
@pytest.mark.parametrize("cone", POLYGONS)
def test_half_a_degree_decides(cone: Cone, angle: float) -> None:
    """It holds half a degree below the polygon's rim, and slides half a degree above.

    As on the smooth cone: 0.1 mm in a second after the first one; an acceleration right to 2 % of
    its size, for the residual of a solve is 1e-5 of the momentum.
    """
    body, _ = on_slope(cone, 0.6, angle, -0.5)
    body.step(100)
    start = body.positions
    assert all(body.step().contact_converged for _ in range(100))
    assert np.abs(body.positions - start).max() < 1e-4
    body, expected = on_slope(cone, 0.6, angle, 0.5)
    body.step(50)
    before = body.momentum / body.masses.sum()
    body.step(100)
    gained = body.momentum / body.masses.sum() - before
    np.testing.assert_allclose(gained, expected, atol=0.02 * float(np.linalg.norm(expected)))


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("cone", POLYGONS)
def test_the_law_holds_at_every_node(cone: Cone, precision: Precision) -> None:
    """Friction is within the polygon, and a sliding node's dissipates most, as it lands and slides.

    By the share that a node may miss; a millionth of the weight is what the solver calls zero.
    """
    friction = 0.5
    mesh = box((3, 3, 3), (0.2, 0.2, 0.2), (-0.1, -0.1, 0.02))
    soft = Material(young_modulus=1e5, poisson_ratio=0.4, stiffness_damping=0.02)
    body = rig(
        mesh,
        material=soft,
        ground=Plane(friction=friction),
        gravity=(0.0, 0.0, -G),
        time_step=DT,
        cone=cone,
        precision=precision,
    )
    body.place(velocities=(1.0, 0.4, 0.0))
    weight = body.masses.sum() * G * DT
    tips = corners(cone)
    across = tips + np.roll(tips, -1, axis=0)
    across /= np.linalg.norm(across, axis=1)[:, None]
    apothem = math.cos(math.pi / int(cone))
    slid = 0
    for _ in range(120):
        settled = body.step().contact_converged
        assert settled
        modes = body.contacts.modes.numpy()
        impulses = body.contacts.impulses.numpy().astype(np.float64)
        velocities = body.velocities[mesh.surface_nodes] * (1.0, 1.0, 0.0)
        normal, tangent = impulses[:, 2], impulses * (1.0, 1.0, 0.0)
        assert normal.min() > -1e-5 * weight
        beyond = (tangent @ across.T).max(axis=1) - (1.0 + SHARE) * apothem * friction * normal
        assert beyond.max() < 3e-6 * weight
        slides = (modes > ContactMode.STICK) & (normal > 1e-3 * weight)
        slides &= np.linalg.norm(velocities, axis=1) > 1e-3
        most = friction * normal * (velocities @ tips.T).max(axis=1)
        dissipated = -(tangent * velocities).sum(axis=1)
        assert (dissipated >= (1.0 - SHARE) * most - 1e-6 * weight)[slides].all()
        slid += np.count_nonzero(slides)
    assert slid > 100
    assert np.abs(body.velocities).max() < 0.05


def stop_times(cone: Cone) -> FloatArray:
    """Seconds until a slab thrown at 1 m/s in eight directions over half a sector stands."""
    times = []
    for angle in np.linspace(0.01, math.pi / 8, 8):
        body = slab(cone, 0.2, np.array([0.0, 0.0, -G]))
        body.step(30)
        body.place(velocities=(math.cos(angle), math.sin(angle), 0.0))
        count = 0
        while np.linalg.norm(body.momentum) > 1e-3 * body.masses.sum():
            body.step()
            count += 1
        times.append(count * DT)
    return np.array(times)


def test_eight_directions_are_within_eight_percent_of_the_smooth_cone() -> None:
    """The support of the octagon lies between cos(22.5 degrees) and one; times are whole steps."""
    smooth, octagon = stop_times("smooth"), stop_times("8")
    assert (octagon >= smooth - DT).all()
    assert (octagon <= smooth / math.cos(math.pi / 8) + DT).all()
    assert octagon.max() > smooth.max() + 2 * DT
