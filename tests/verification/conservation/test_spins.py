"""Bodies in flight that turn fast: their size, momenta and energy, and the way that they take."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from tests.support.bodies import EXACT, Rig, Vector, box, muscular_bar, rig
from tests.verification.accuracy import energy
from tests.verification.conservation.cubes import NO_GRAVITY, cube
from tests.verification.conservation.flight import MOST, PRECISIONS
from warp_softbody import (
    Body,
    Material,
    Plane,
    Scene,
    Simulation,
    SimulationOptions,
    TetMesh,
    placed,
)
from warp_softbody.arrays import FloatArray
from warp_softbody.body.mesh_geometry import tet_volumes
from warp_softbody.engine.options import Precision
from warp_softbody.engine.reduced_dynamics import ReducedDynamics

RUBBER = Material(young_modulus=1e6, poisson_ratio=0.3, stiffness_damping=0.01)
SHAPES = {
    "cube": box((3, 3, 3)),
    "rod": box((8, 2, 2), (0.4, 0.08, 0.08)),
    "brick": box((4, 3, 2), (0.3, 0.2, 0.1), jitter=0.2),
}
# rad/s; the rod about its long and a short axis and nearly so, the brick about all and none
SPINS = [
    ("cube", (0.0, 0.0, 30.0)),
    ("cube", (60.0, 60.0, 60.0)),
    ("rod", (0.0, 0.0, 40.0)),
    ("rod", (100.0, 3.0, 0.0)),
    ("brick", (0.0, 60.0, 1.0)),
    ("brick", (20.0, 40.0, 60.0)),
]


def spinning(
    mesh: TetMesh,
    spin: Sequence[float] | FloatArray,
    material: Material = RUBBER,
    velocity: Vector = (3.0, 0.0, 1.0),
    **options: Any,
) -> Rig:
    """A body without strain that flies and turns."""
    options = {"time_step": 1.0 / 120.0, **options}
    body = rig(mesh, material=material, **options)
    arms = body.positions - body.center
    body.place(velocities=np.asarray(velocity) + np.cross(spin, arms))
    return body


def volume(body: Rig) -> float:
    """Of all tets, over that at rest."""
    mesh = body.model.scene.character.mesh
    return float(tet_volumes(body.positions, mesh.tets).sum() / mesh.volumes.sum())


def spin_of(body: Rig) -> FloatArray:
    """Angular velocity of the rigid body of the same momentum, (3,) rad/s."""
    arms = body.positions - body.center
    squares = np.einsum("n,na,nb->ab", body.masses, arms, arms)
    inertia = np.trace(squares) * np.eye(3) - squares
    return np.asarray(np.linalg.solve(inertia, body.angular_momentum))


def keeps(body: Rig, steps: int, size: float = 0.03) -> None:
    """Assert what a flight keeps: volume, momenta and, but for what damping takes, energy."""
    precision = body.model.options.precision
    momentum, angular, begun = body.momentum, body.angular_momentum, energy(body)
    rounding = 1e-12 if precision == "float64" else 1e-5
    last = begun
    for _ in range(steps):
        body.step()
        assert volume(body) == pytest.approx(1.0, abs=size)
        assert energy(body) <= last * (1.0 + rounding) + 1e-6 * begun
        last = energy(body)
    most = MOST[precision]
    np.testing.assert_allclose(body.momentum, momentum, atol=most * np.linalg.norm(momentum))
    np.testing.assert_allclose(
        body.angular_momentum, angular, atol=most * float(np.linalg.norm(angular))
    )


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize(("shape", "spin"), SPINS)
def test_a_spin_keeps_its_size(shape: str, spin: Vector, precision: Precision) -> None:
    """A straight path would make them larger by 12 to 80 %, and lend them 18 times their energy."""
    keeps(spinning(SHAPES[shape], spin, precision=precision), 60)


@pytest.mark.parametrize(
    "options",
    [
        {"tangent": "conserving"},
        {"tangent": "exact"},
        {"elements": "smoothed"},
        {"newton_iterations": 2},
        {"newton_iterations": 3, "tangent": "exact"},
        {"threads": 2},
    ],
    ids=str,
)
def test_whatever_the_scheme(options: dict[str, Any]) -> None:
    keeps(spinning(SHAPES["brick"], (20.0, 40.0, 60.0), precision="float64", **options), 60)


@pytest.mark.parametrize("damping", [0.0, 0.05])
@pytest.mark.parametrize("step", [1.0 / 240.0, 1.0 / 60.0])
def test_whatever_the_damping_and_the_step(damping: float, step: float) -> None:
    material = Material(young_modulus=1e6, poisson_ratio=0.3, stiffness_damping=damping)
    keeps(spinning(SHAPES["cube"], (10.0, 40.0, 40.0), material, time_step=step), 60)


def test_damping_of_the_mass_slows_a_spin() -> None:
    material = Material(young_modulus=1e6, poisson_ratio=0.3, mass_damping=0.5)
    body = spinning(SHAPES["brick"], (20.0, 40.0, 60.0), material, precision="float64")
    left = (1.0 + 0.5 / 120.0) ** -60 * body.angular_momentum
    body.step(60)
    np.testing.assert_allclose(body.angular_momentum, left, rtol=1e-9)


def test_a_slender_body_wobbles_without_gain() -> None:
    """Its wobble about the long axis turns 13 times as far in a step as its spin."""
    body = spinning(box((16, 1, 1), (0.4, 0.02, 0.02)), (0.0, 0.0, 40.0), time_step=1.0 / 60.0)
    begun = energy(body)
    for _ in range(60):
        body.step()
        assert energy(body) < begun
    assert volume(body) == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize("step", [1.0 / 60.0, 1.0 / 120.0, 1.0 / 240.0])
def test_a_rod_stretches_by_its_centrifugal_load(step: float) -> None:
    """Each half by rho w^2 L^3 / (3 E), but for mesh, strain and (w dt)^4 of it."""
    speed, half = 20.0, 0.2
    material = Material(young_modulus=1e6, poisson_ratio=0.0, stiffness_damping=0.01)
    mesh = box((16, 1, 1), (2.0 * half, 0.02, 0.02))
    body = spinning(mesh, (0.0, 0.0, speed), material, time_step=step, **EXACT)
    body.step(round(1.0 / step))
    ends = [body.positions[np.abs(mesh.points[:, 0] - x) < 1e-9].mean(axis=0) for x in (0.0, 0.4)]
    stretch = 0.5 * float(np.linalg.norm(ends[1] - ends[0])) - half
    spin = float(np.linalg.norm(spin_of(body)))
    expected = 1000.0 * spin**2 * half**3 / (3.0 * material.young_modulus)
    assert stretch == pytest.approx(expected, rel=0.02 + (spin * step) ** 4)


def test_the_stretch_is_that_of_short_steps() -> None:
    """Off by (w dt)^4 of it: at half the step there is hardly anything left to mend."""
    material = Material(young_modulus=3e5, poisson_ratio=0.3, stiffness_damping=0.01)
    swellings = []
    for step in (1.0 / 60.0, 1.0 / 120.0, 1.0 / 960.0):
        body = spinning(SHAPES["cube"], (0.0, 0.0, 40.0), material, time_step=step)
        body.step(round(0.25 / step))
        swellings.append(volume(body) - 1.0)
    assert swellings[0] == pytest.approx(swellings[2], rel=0.2)
    assert swellings[1] == pytest.approx(swellings[2], rel=0.02)


def test_a_spin_turns_as_far_as_it_should() -> None:
    """A stiff cube about an axis of symmetry, 0.4 rad a step, ten turns and more."""
    material = Material(young_modulus=1e9, poisson_ratio=0.3, stiffness_damping=0.01)
    speed, axis = 48.0, np.full(3, 3.0**-0.5)
    body = spinning(box((2, 2, 2)), speed * axis, material, (0.0, 0.0, 0.0), **EXACT)
    start = body.positions - body.center
    body.step(180)
    across = np.cross(axis, start[1])
    across /= np.linalg.norm(across)
    flat = np.cross(across, axis)
    now = body.positions[1] - body.center
    angle = np.arctan2(now @ across, now @ flat)
    expected = speed * 1.5 % (2.0 * np.pi)
    missed = (angle - expected + np.pi) % (2.0 * np.pi) - np.pi
    assert abs(missed) < 1e-3 * speed * 1.5


def test_a_push_turns_a_spin() -> None:
    """A couple on the ends of a spinning rod adds its moments."""
    body = spinning(SHAPES["rod"], (0.0, 0.0, 30.0), velocity=(0.0, 0.0, 0.0), precision="float64")
    forces = np.zeros_like(body.positions)
    forces[0], forces[-1] = (0.0, 4.0, 1.0), (0.0, -4.0, -1.0)
    body.push(forces)
    expected = body.angular_momentum
    for _ in range(20):
        expected = expected + np.cross(body.positions, forces).sum(axis=0) / 120.0
        body.step()
    np.testing.assert_allclose(body.angular_momentum, expected, rtol=1e-9, atol=1e-12)


def test_a_slow_spin_takes_the_straight_path() -> None:
    """x+ = x + dt v+ to the last bit, where it swells by less than a thousandth."""
    body = spinning(SHAPES["cube"], (0.0, 0.0, 3.0), velocity=(0.0, 0.0, 0.0), precision="float64")
    before = body.positions
    body.step()
    np.testing.assert_array_equal(body.positions, before + body.velocities * (1.0 / 120.0))


def test_a_planned_step_takes_the_straight_path() -> None:
    """Until it is off by some hundredths: the plan's linear maps are its."""
    for speed, straight in ((9.0, True), (90.0, False)):
        body = rig(muscular_bar(RUBBER), time_step=1.0 / 120.0, **EXACT)
        arms = body.positions - body.center
        body.place(velocities=np.cross([0.0, speed, 0.0], arms))
        before = body.positions
        dynamics, rows = ReducedDynamics(body.stepper), np.eye(3 * len(before))[:2]
        body.stepper.step(
            *(body.state, body.control, body.contacts, body.after),
            decide=lambda: dynamics.solve(rows, free=True),  # noqa: B023
        )
        body.state, body.after = body.after, body.state
        path = before + body.velocities / 120.0
        assert np.allclose(body.positions, path, atol=1e-12) == straight


def spun_up(offset: float, speed: float, young_modulus: float, step: float) -> Simulation:
    """Two cubes that meet off their centres."""
    one = cube("one", 3, 0.0, young_modulus)
    two = placed(cube("two", 3, 0.0, young_modulus), translation=(0.3, offset, 0.03))
    scene = Scene(
        character=one,
        others=(Body(character=two, velocity=(-speed, 0.0, 0.0)),),
        gravity=NO_GRAVITY,
        body_friction=0.4,
    )
    return Simulation(scene, options=SimulationOptions(time_step=step), fps=1.0 / step)


@pytest.mark.parametrize("offset", [0.02, 0.1, 0.18])
@pytest.mark.parametrize(
    ("speed", "young_modulus", "step"),
    [
        (10.0, 1e5, 1.0 / 60.0),
        (30.0, 1e6, 1.0 / 60.0),
        (100.0, 1e6, 1.0 / 240.0),
        (100.0, 1e6, 1.0 / 120.0),
        (100.0, 1e7, 1.0 / 60.0),
    ],
)
def test_a_collision_off_centre_leaves_the_volume(
    offset: float, speed: float, young_modulus: float, step: float
) -> None:
    """They leave at up to 180 rad/s; on straight paths they were up to ten times as large."""
    simulation = spun_up(offset, speed, young_modulus, step)
    masses, tets = simulation.model.masses, simulation.model.body.mesh.tets
    parts = [part.tets for part in simulation.model.scene.parts]
    rest = np.array([simulation.model.body.mesh.volumes[part].sum() for part in parts])
    frames = list(simulation.run(0.3 / speed + 0.5))
    begun = masses @ (frames[0].velocities ** 2).sum(axis=1)
    turning = [masses @ np.cross(frame.positions, frame.velocities) for frame in frames]
    touching = max(k for k, frame in enumerate(frames) if len(frame.contacts.points))
    for k, frame in enumerate(frames):
        assert masses @ (frame.velocities**2).sum(axis=1) <= begun * (1.0 + 1e-3)
        sizes = tet_volumes(frame.positions, tets)
        volumes = np.array([sizes[part].sum() for part in parts]) / rest
        assert volumes.max() < 1.1
        if k > touching:
            np.testing.assert_allclose(volumes, 1.0, atol=0.1)
    reach = masses @ (
        np.linalg.norm(frames[-1].positions, axis=1) * np.linalg.norm(frames[-1].velocities, axis=1)
    )
    np.testing.assert_allclose(turning[-1], turning[0], atol=MOST["float32"] * reach)


def test_the_ground_beside_a_spin_is_as_it_was() -> None:
    """A body at rest on the ground is not touched by the second solve of one in flight."""
    flying = placed(cube("spin", 2, 0.0), translation=(0.0, 0.0, 2.0))
    ground = Plane(offset=-0.1)
    scene = Scene(character=cube("rest", 2, 0.0), others=(Body(character=flying),), ground=ground)
    simulation = Simulation(scene, options=SimulationOptions(time_step=1.0 / 120.0))
    for _ in range(30):
        simulation.step()
    own = simulation.model.scene.parts[1].nodes
    positions = simulation.state.positions.numpy().astype(float)
    velocities = simulation.state.velocities.numpy().astype(float)
    arms = positions[own] - positions[own].mean(axis=0)
    velocities[own] += np.cross([0.0, 30.0, 30.0], arms)
    simulation.state.velocities.assign(velocities)
    kept = positions[: own.start]
    for _ in range(20):
        simulation.step()
    now = simulation.state.positions.numpy().astype(float)[: own.start]
    np.testing.assert_allclose(now, kept, atol=1e-4)
    assert simulation.summary().findings.doubts == ()
