"""Contact of surfaces with each other: between bodies, and of a body with itself.

The ground's contact is the independent solver: against a slab that cannot move, pairs must do what
the ground does.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.support.bodies import box, epsilon
from tests.verification.pair_bodies import (
    GRAVITY,
    SIDE,
    SOFT,
    cube,
    energy,
    hairpin,
    simulate,
    slab,
)
from warp_softbody import Plane, Push, Scene, Simulation, SimulationOptions
from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.engine.options import Precision
from warp_softbody.world.frame import GROUND
from warp_softbody.world.joined_bodies import Body


@pytest.mark.parametrize(("height", "speed"), [(0.05, 1.0), (0.3, 0.0)], ids=["sliding", "dropped"])
def test_fixed_slab_is_the_ground(height: float, speed: float) -> None:
    """The same laws, the same rules: paths differ by what counts as zero in them.

    Friction obeys its law by 5 % of its bound while sliding speeds change (docs/contact.md), so
    speeds differ by parts of the friction's change of velocity in a step, mu g dt = 0.05 m/s, in
    the steps of the impact; they are not kept, and places stay together to 0.2 mm.
    """
    body = cube(at=(0.0, 0.0, height))
    thrown = (speed, 0.0, 0.0)
    options: dict[str, Any] = {"precision": "float64", "tolerance": 1e-9}
    on_ground = Scene(character=body, ground=Plane(friction=0.5), initial_velocity=thrown)
    on_slab = replace(on_ground, ground=None, others=(Body(character=slab()),), body_friction=0.5)
    nodes = len(body.mesh.points)
    ground, pairs = (simulate(scene, 1.0, **options) for scene in (on_ground, on_slab))
    expected = ground.state.positions.numpy()
    np.testing.assert_allclose(pairs.state.positions.numpy()[:nodes], expected, atol=2e-4)
    assert pairs.state.positions.numpy()[:nodes, 2].min() > -1e-6


@pytest.mark.parametrize("degrees", [0.0, 30.0])
@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_stack_bears_its_weight(precision: Precision, degrees: float) -> None:
    """At rest each interface bears what is above it, to 1e-4."""
    bodies = [cube("a"), cube("b", (0.0, 0.0, SIDE), cells=4, degrees=degrees)]
    scene = Scene(
        character=bodies[0], others=(Body(character=bodies[1]),), ground=Plane(friction=0.5)
    )
    simulation = simulate(scene, 5.0, precision=precision)
    weight = SOFT.density * SIDE**3 * GRAVITY
    contacts = next(simulation.run(1.0)).contacts
    between = contacts.force_on("b", by="a")[2]
    below = contacts.force_on("a", by=GROUND)[2]
    assert between == pytest.approx(weight, rel=1e-4)
    assert below == pytest.approx(2.0 * weight, rel=1e-4)


def test_stack_stays_for_twenty_seconds() -> None:
    """No creep: less than 0.1 mm between 5 s, when it has come to rest, and 20 s."""
    scene = Scene(
        character=cube("a"),
        others=(Body(character=cube("b", (0.02, 0.01, SIDE), cells=4)),),
        ground=Plane(friction=0.5),
    )
    simulation = simulate(scene, 5.0)
    before = simulation.state.positions.numpy().copy()
    for _ in range(1500):
        simulation.step()
    assert np.abs(simulation.state.positions.numpy() - before).max() < 1e-4
    assert np.abs(simulation.state.velocities.numpy()).max() < 1e-4


@pytest.mark.parametrize("friction", [0.2, 0.6])
def test_friction_between_bodies(friction: float) -> None:
    """A flat block on a slab stays half a degree below the angle of friction and slides above it.

    Above, it gains g (sin - mu cos) of speed a second; it settles in the first 0.3 s, and the law
    is kept to 0.2 % in steady sliding.
    """
    flat = Character(
        name="flat",
        mesh=box((4, 4, 1), (0.4, 0.4, 0.1), (-0.2, -0.2, 0.0)),
        material=replace(SOFT, young_modulus=1e6),
    )
    nodes = len(flat.mesh.points)
    for offset, slides in ((-0.5, False), (5.0, True)):
        angle = np.arctan(friction) + np.radians(offset)
        pull = (GRAVITY * np.sin(angle), 0.0, -GRAVITY * np.cos(angle))
        scene = Scene(
            character=flat,
            others=(Body(character=slab()),),
            gravity=pull,
            body_friction=friction,
        )
        speeds = []
        simulation = simulate(scene, 0.3, precision="float64")
        for _ in range(2):
            mass = simulation.model.masses[:nodes]
            speeds.append(mass @ simulation.state.velocities.numpy()[:nodes, 0] / mass.sum())
            for _ in range(30):
                simulation.step()
        if slides:
            gained = GRAVITY * (np.sin(angle) - friction * np.cos(angle)) * 0.3
            assert speeds[1] - speeds[0] == pytest.approx(gained, rel=5e-3)
        else:
            assert abs(speeds[1]) < 1e-4


@pytest.mark.parametrize("friction", [0.0, 0.5, 1e3])
def test_collision_keeps_momentum_and_gains_no_energy(friction: float) -> None:
    """Two cubes meet off centre in free space: impulses are opposite to the last digit.

    Momentum changes only by what the solves leave, 1e-10 of it a step. Energy counts what is
    elastic, since it comes back as motion; turning bodies gain a little of that by the step's
    first-order error (docs/architecture.md), never beyond what there was at the start.
    """
    one = cube("one", (0.0, 0.0, 0.0))
    two = cube("two", (0.33, 0.1, 0.05), cells=4, degrees=20.0)
    scene = Scene(
        character=one,
        others=(Body(character=two, velocity=(-1.0, 0.0, 0.0)),),
        gravity=(0.0, 0.0, 0.0),
        initial_velocity=(1.0, 0.0, 0.0),
        body_friction=friction,
    )
    options = SimulationOptions(time_step=0.005, precision="float64", tolerance=1e-10)
    simulation = Simulation(scene, options=options, fps=200.0)
    masses = simulation.model.masses
    begun = energy(simulation)
    size = masses.sum() * 1.0
    before = masses @ simulation.state.velocities.numpy()
    met = 0
    for _ in range(120):
        simulation.step()
        assert energy(simulation) <= begun * (1.0 + 1e-6)
        met += bool((simulation.contacts.pairs.modes.numpy() != 0).any())  # type: ignore[union-attr]
    after = masses @ simulation.state.velocities.numpy()
    assert met > 5
    np.testing.assert_allclose(after, before, atol=120 * 1e-10 * size)
    nodes = len(one.mesh.points)
    velocities = simulation.state.velocities.numpy()
    apart = masses[nodes:] @ velocities[nodes:, 0] / masses[nodes:].sum()
    assert apart > masses[:nodes] @ velocities[:nodes, 0] / masses[:nodes].sum()


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_arms_of_one_body_meet(precision: Precision) -> None:
    """Pressed together, the arms touch and stop; without self-contact they pass each other."""
    body = hairpin()
    press = Push(region="tip", force=(0.0, 0.0, -12.0), start=0.0, duration=10.0)
    scene = Scene(character=body, gravity=(0.0, 0.0, 0.0), pushes=(press,))
    gaps = []
    for touches in (False, True):
        simulation = simulate(replace(scene, self_contact=touches), 1.5, precision=precision)
        gaps.append(smallest_gap(body, simulation.state.positions.numpy().astype(np.float64)))
    assert gaps[0] < -0.02
    # a node may enter by what its plane turns in a step, and come out at the next
    assert abs(gaps[1]) < 1e-4


def smallest_gap(body: Character, points: FloatArray) -> float:
    """Least height of the upper arm's nodes over the triangles of the lower arm, m."""
    _, _, z = body.mesh.points.T
    upper = points[(abs(z - 0.12) < 1e-9) & (points[:, 0] > 0.2)]
    facing = (abs(z[body.mesh.surface] - 0.06) < 1e-9).all(axis=1)
    corners = points[body.mesh.surface[facing]]
    a, b, c = corners[:, 0, :2], corners[:, 1, :2], corners[:, 2, :2]
    inverse = np.linalg.inv(np.stack([b - a, c - a], axis=2))
    inner = np.einsum("fij,pfj->pfi", inverse, upper[:, None, :2] - a)
    weights = np.concatenate([1.0 - inner.sum(axis=2, keepdims=True), inner], axis=2)
    node, face = np.nonzero((weights > -1e-9).all(axis=2))
    below = (weights[node, face] * corners[face, :, 2]).sum(axis=1)
    return float((upper[node, 2] - below).min())


def test_open_arms_do_not_notice() -> None:
    """What does not touch moves the same with self-contact looked for."""
    body = hairpin()
    paths = []
    for touches in (False, True):
        scene = Scene(character=body, self_contact=touches)
        simulation = simulate(scene, 0.1, precision="float64")
        assert touches == (simulation.contacts.pairs is not None)
        paths.append(simulation.state.positions.numpy().copy())
    np.testing.assert_array_equal(paths[0], paths[1])


def test_bodies_spawned_in_each_other_come_apart_slowly() -> None:
    """Half a cell deep: pushed out, at about the recovery speed of 0.5 m/s and not shot."""
    one = cube("one")
    two = cube("two", (0.0, 0.0, SIDE - 0.05), cells=4)
    scene = Scene(character=one, others=(Body(character=two),), gravity=(0.0, 0.0, 0.0))
    simulation = Simulation(scene, time_step=0.01, fps=100.0)
    fastest = 0.0
    for _ in range(100):
        simulation.step()
        fastest = max(fastest, float(np.abs(simulation.state.velocities.numpy()).max()))
    points = simulation.state.positions.numpy()
    nodes = len(one.mesh.points)
    assert points[nodes:, 2].min() > points[:nodes, 2].max() - 2e-3
    assert fastest < 2.0


def test_runs_repeat_bit_for_bit() -> None:
    scene = Scene(
        character=cube("a"),
        others=(Body(character=cube("b", (0.05, 0.0, SIDE + 0.01), degrees=10.0)),),
        ground=Plane(friction=0.5),
    )
    first, second = (simulate(scene, 0.3).state.positions.numpy().copy() for _ in range(2))
    np.testing.assert_array_equal(first, second)


def test_precisions_agree() -> None:
    """A cube put on another, in single and double precision, for the 0.1 s of its first bounce.

    Rounding of the right side leaves 1e-4 of a step's momentum (docs/architecture.md), and ten
    steps of 0.1 m/s add to 0.1 mm.
    """
    scene = Scene(
        character=cube("a"),
        others=(Body(character=cube("b", (0.0, 0.0, SIDE), cells=4)),),
        ground=Plane(friction=0.5),
    )
    single, double = (
        simulate(scene, 0.1, precision=precision).state.positions.numpy()
        for precision in ("float32", "float64")
    )
    assert epsilon("float32") * SIDE < np.abs(single - double).max() < 1e-4
