"""A step's pairs settle, or end safe; what acts between bodies is told, and adds up."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.support.bodies import box
from tests.verification.pair_bodies import cube, energy, hairpin, simulate
from warp_softbody import Material, Plane, Push, Scene, Simulation, SimulationOptions
from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.engine.options import Precision
from warp_softbody.engine.step_statistics import StepStatistics
from warp_softbody.errors import InputError
from warp_softbody.scenes import make
from warp_softbody.world.frame import GROUND
from warp_softbody.world.joined_bodies import Body

NO_GRAVITY = (0.0, 0.0, 0.0)


def pressed_block(scale: float = 1.0) -> Scene:
    """A block of 0.06 m pushed with 20 times its weight onto a pad that is fixed at its back."""
    stiff = Material(young_modulus=1e6, poisson_ratio=0.3)
    small, large = 0.06 * scale, 0.1 * scale
    pad = box((4, 4, 4), (large,) * 3, (-large, -large / 2, -large / 2))
    block = box((2, 2, 2), (small,) * 3, (0.0, -small / 2, -small / 2))
    held = np.flatnonzero(pad.points[:, 0] < -large * (1.0 - 1e-9)).astype(np.int32)
    back = np.flatnonzero(block.points[:, 0] > small * (1.0 - 1e-9))
    press = -20.0 * 1000.0 * 0.06**3 * 9.81 * scale**2
    return Scene(
        character=Character(
            name="block",
            mesh=block,
            regions={"back": back.astype(np.int32)},
            material=replace(stiff, stiffness_damping=0.02),
        ),
        others=(
            Body(
                character=Character(
                    name="pad", mesh=pad, material=replace(stiff, density=100.0), fixed=held
                )
            ),
        ),
        body_friction=0.7,
        gravity=NO_GRAVITY,
        pushes=(Push(region="back", force=(press, 0.0, 0.0), start=0.0, duration=99.0),),
    )


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_pressed_pair_settles(precision: Precision) -> None:
    """At rest, every step of the second second settles, and nothing creeps."""
    simulation = simulate(pressed_block(), 1.0, precision=precision, time_step=1 / 120, sleep=False)
    before = simulation.summary().unconverged_steps
    positions = simulation.state.positions.numpy().copy()
    for _ in range(120):
        simulation.step()
    assert simulation.summary().unconverged_steps == before
    assert np.abs(simulation.state.positions.numpy() - positions).max() < 1e-6


def test_a_small_pair_settles_as_a_large_one() -> None:
    """The same block of 0.4 mm: with lengths and speeds scaled, pressures alike, the same shape."""
    scale = 0.4e-3 / 0.06
    shapes = []
    for size in (1.0, scale):
        options: dict[str, Any] = {"precision": "float64", "time_step": 1 / 120, "sleep": False}
        if size != 1.0:
            options["recovery_speed"] = 0.5 * size
        scene = pressed_block(size)
        simulation = simulate(scene, 1.0, **options)
        shapes.append(simulation.state.positions.numpy() / size)
    # inertia is less by the square of the scale; at rest it does not count
    np.testing.assert_allclose(shapes[0], shapes[1], atol=2e-4)


@pytest.mark.parametrize("passes", [1, 2, 12])
@pytest.mark.parametrize("friction", [0.0, 3.0])
def test_unsettled_steps_end_safe(passes: int, friction: float) -> None:
    """With too few passes: momentum holds, and no energy is gained.

    Turning bodies gain a little elastic energy by the step's first-order error, as they do where
    all steps settle (docs/architecture.md): within 2 % of what there is.
    """
    one, two = cube("one"), cube("two", (0.33, 0.1, 0.05), cells=4, degrees=20.0)
    scene = Scene(
        character=one,
        others=(Body(character=two, velocity=(-2.0, 0.0, 0.0)),),
        gravity=NO_GRAVITY,
        initial_velocity=(2.0, 0.0, 0.0),
        body_friction=friction,
    )
    options = SimulationOptions(
        time_step=0.005, precision="float64", tolerance=1e-10, max_contact_passes=passes
    )
    simulation = Simulation(scene, options=options, fps=200.0)
    masses = simulation.model.masses
    begun, momentum = energy(simulation), masses @ simulation.state.velocities.numpy()
    met = 0
    for _ in range(60):
        simulation.step()
        contacts = next(simulation.run(1.0)).contacts
        met += len(contacts.nodes) > 0
        assert energy(simulation) < begun * 1.02
    assert met > 3
    assert passes == 12 or simulation.summary().unconverged_steps > 3
    after = masses @ simulation.state.velocities.numpy()
    np.testing.assert_allclose(after, momentum, atol=1e-8 * masses.sum())


def test_unsettled_impulses_keep_the_laws() -> None:
    """The pairs' impulses after the end of an unsettled step, against their own normals."""
    scene = replace(pressed_block(), body_friction=0.7)
    options = {"precision": "float64", "time_step": 1 / 120, "max_contact_passes": 1}
    simulation = simulate(scene, 3 / 120, **options)
    pairs, contact = simulation.contacts.pairs, simulation.stepper.contact.pairs
    assert pairs is not None and contact is not None
    impulses, normals = pairs.impulses.numpy(), contact.normals.numpy()
    found = pairs.nodes.numpy()[:, 0] >= 0
    normal = np.einsum("ci,ci->c", impulses, normals)[found]
    friction = np.linalg.norm(impulses[found] - normal[:, None] * normals[found], axis=1)
    assert normal.min() >= -1e-15
    assert (friction <= 0.7 * normal * (1.0 + 1e-9) + 1e-15).all()
    assert normal.max() > 0.0


def test_unsettled_steps_tell_which_bodies() -> None:
    scene = pressed_block()
    simulation = Simulation(scene, options=SimulationOptions(max_contact_passes=1), fps=120.0)
    told: list[StepStatistics] = []
    simulation.observe(lambda step: told.append(step.statistics))
    for _ in range(3):
        simulation.step()
    unsettled = [statistics for statistics in told if not statistics.contact_converged]
    assert unsettled
    assert {statistics.worst_pair for statistics in unsettled} <= {
        ("block", "pad"),
        ("pad", "block"),
    }


@pytest.mark.parametrize("speed", [10.0, 100.0])
def test_fast_collision(speed: float) -> None:
    """Face to face: momentum to the solver's tolerance, energy lost, shape as before."""
    material = Material(young_modulus=5e5, poisson_ratio=0.3, stiffness_damping=0.02)
    mesh = box((4, 4, 4), (0.2, 0.2, 0.2))
    other = box((3, 3, 3), (0.2, 0.2, 0.2), (0.5, 0.0, 0.0))
    scene = Scene(
        character=Character(name="one", mesh=mesh, material=material),
        others=(
            Body(
                character=Character(name="two", mesh=other, material=material),
                velocity=(-speed / 2.0, 0.0, 0.0),
            ),
        ),
        gravity=NO_GRAVITY,
        initial_velocity=(speed / 2.0, 0.0, 0.0),
    )
    simulation = Simulation(
        scene, options=SimulationOptions(precision="float64", tolerance=1e-10), fps=120.0
    )
    masses = simulation.model.masses
    begun = energy(simulation)
    for _ in range(60):
        simulation.step()
        assert energy(simulation) < begun * (1.0 + 1e-9)
    velocities = simulation.state.velocities.numpy()
    assert np.abs(masses @ velocities).max() < 60 * 1e-10 * masses.sum() * speed
    points = simulation.state.positions.numpy()
    for part, body in zip(scene.parts, (mesh, other), strict=True):
        a, b, c, d = (points[part.nodes][body.tets[:, k]] for k in range(4))
        volume = np.einsum("ij,ij->i", b - a, np.cross(c - a, d - a)).sum() / 6.0
        assert volume == pytest.approx(body.volume, rel=0.1)
    apart = points[len(mesh.points) :, 0].min() - points[: len(mesh.points), 0].max()
    assert apart > -1e-3


def test_friction_from_afar_does_not_turn_bodies() -> None:
    """Off centre at 50 m/s, in one step over many edges' lengths: angular momentum holds."""
    one, two = cube("one"), cube("two", (0.6, 0.05, 0.04), cells=4)
    scene = Scene(
        character=one,
        others=(Body(character=two, velocity=(-25.0, 0.0, 0.0)),),
        gravity=NO_GRAVITY,
        initial_velocity=(25.0, 0.0, 0.0),
    )
    options = SimulationOptions(
        time_step=0.01, precision="float64", tolerance=1e-10, tangent="conserving"
    )
    simulation = Simulation(scene, options=options, fps=100.0)
    masses = simulation.model.masses[:, None]

    def spin() -> FloatArray:
        state = simulation.state
        return np.asarray(
            (masses * np.cross(state.positions.numpy(), state.velocities.numpy())).sum(axis=0)
        )

    before = spin()
    simulation.step()
    speeds = masses[:, 0] @ simulation.state.velocities.numpy()
    assert len(next(simulation.run(1.0)).contacts.nodes) > 0 and np.abs(speeds).max() < 1e-6
    np.testing.assert_allclose(spin(), before, atol=1e-6 * np.abs(before).max())


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_forces_on_each_body_sum_to_its_weight(precision: Precision) -> None:
    """Three cubes as a stack at rest: by the samples alone, with the other side of each."""
    plan = make("stack", {"count": 3})
    options = SimulationOptions(time_step=plan.time_step, precision=precision)
    *_, frame = Simulation(plan.scene, options=options).run(5.0)
    contacts = frame.contacts
    weight = plan.scene.character.mesh.volume * plan.scene.character.material.density * 9.81
    for number, name in enumerate(contacts.names):
        expected = [0.0, 0.0, weight]
        np.testing.assert_allclose(contacts.force_on(name), expected, atol=1e-3 * weight)
        np.testing.assert_allclose(contacts.force_on(number), contacts.force_on(name))
        own = contacts.seen_by(number, frame.positions)
        np.testing.assert_allclose(
            own.forces.sum(axis=0), contacts.force_on(name), atol=1e-6 * weight
        )
        part = plan.scene.parts[number].nodes
        assert ((own.nodes >= part.start) & (own.nodes < part.stop)).all()
    below = contacts.force_on("cube_0", by=GROUND)[2]
    above = contacts.force_on("cube_0", by="cube_1")[2]
    assert below == pytest.approx(3.0 * weight, rel=1e-3)
    assert above == pytest.approx(-2.0 * weight, rel=1e-3)
    held = contacts.partners != GROUND
    np.testing.assert_allclose(contacts.partner_weights[held].sum(axis=1), 1.0, atol=1e-6)
    places = np.einsum(
        "ka,kax->kx", contacts.partner_weights[held], frame.positions[contacts.partner_nodes[held]]
    )
    # what touches is at the same place, but for the ends of an edge
    node = (contacts.partner_nodes[held] >= 0).all(axis=1)
    assert np.abs(places - contacts.points[held])[node].max() < 1e-3
    with pytest.raises(InputError, match="no body of these contacts is named 'cube_9'"):
        contacts.force_on("cube_9")


def test_self_contact_names_itself() -> None:
    press = Push(region="tip", force=(0.0, 0.0, -12.0), start=0.0, duration=10.0)
    scene = Scene(character=hairpin(), gravity=NO_GRAVITY, pushes=(press,), self_contact=True)
    *_, frame = Simulation(scene, time_step=0.01).run(1.0)
    assert len(frame.contacts.nodes) > 0
    assert (frame.contacts.partners == 0).all()
    np.testing.assert_allclose(frame.contacts.force_on("hairpin"), 0.0, atol=1e-9)


def test_order_in_the_scene_does_not_matter() -> None:
    """A stack named from below and from above: the same to the solver's tolerance."""
    bodies = [cube("a"), cube("b", (0.02, 0.01, 0.31), cells=4), cube("c", (0.0, 0.0, 0.62))]
    heights = []
    for order in ((0, 1, 2), (2, 1, 0), (1, 2, 0)):
        first, *others = [bodies[k] for k in order]
        scene = Scene(
            character=first,
            others=tuple(Body(character=body) for body in others),
            ground=Plane(friction=0.5),
        )
        simulation = simulate(scene, 1.0, precision="float64", tolerance=1e-9)
        where = dict(zip((p.name for p in scene.parts), scene.parts, strict=True))
        points = simulation.state.positions.numpy()
        heights.append(np.concatenate([points[where[name].nodes] for name in "abc"]))
    np.testing.assert_allclose(heights[1], heights[0], atol=1e-5)
    np.testing.assert_allclose(heights[2], heights[0], atol=1e-5)


def test_crushed_bodies_are_not_shot_away() -> None:
    """Cubes too soft to bear their own fall: tets invert, steps do not settle, speeds stay.

    From 0.6 m they fall at 3.4 m/s; nothing but that, and what their own weight stored, is there.
    """
    plan = make("stack", {"count": 2, "young_modulus": 1e3, "height": 0.6})
    simulation = Simulation(plan.scene, time_step=plan.time_step)
    fastest = max(float(np.abs(frame.velocities).max()) for frame in simulation.run(0.5))
    assert fastest < 15.0
