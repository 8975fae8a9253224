"""Handles move nodes along paths, and contact takes them for what moves with their velocity."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.support.bodies import box, exact_dynamics, muscular_bar, numbers, rig
from tests.verification.pair_bodies import SOFT
from warp_softbody import Handle, Material, MotionPath, Plane, Scene, Simulation, SimulationOptions
from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.engine.model import build_model
from warp_softbody.engine.state import Contacts, Control, State
from warp_softbody.engine.stepper import Stepper
from warp_softbody.errors import InputError
from warp_softbody.scenes.stairs import ball_mesh
from warp_softbody.world.joined_bodies import Body

RADIUS = 0.15
THICK = 0.1


def ball(at: tuple[float, float, float] = (0.3, 0.0, 0.0)) -> Character:
    return Character(name="ball", mesh=ball_mesh(RADIUS, np.array(at)), material=SOFT)


def paddle(cells: int = 4) -> Character:
    """Its front is the plane x = 0."""
    mesh = box((1, cells, cells), (THICK, 0.6, 0.6), (-THICK, -0.3, -0.3))
    return Character(name="paddle", mesh=mesh)


def struck(path: MotionPath, **more: Any) -> Scene:
    """A ball in front of a paddle that moves along a path, in free space."""
    given: dict[str, Any] = {
        "character": ball(),
        "others": (Body(character=paddle()),),
        "gravity": (0, 0, 0),
    }
    return Scene(handles=(Handle(region="paddle", path=path),), **(given | more))


def deepest(ball_nodes: FloatArray, front: float) -> float:
    """How deep nodes are behind a paddle's front, m, where they are beside its middle."""
    over = np.abs(ball_nodes[:, 1:]).max(axis=1) < 0.3
    return float((front - ball_nodes[over, 0]).max())


@pytest.mark.parametrize("speed", [1.0, 5.0])
@pytest.mark.parametrize("cells", [1, 4])
def test_paddle_does_not_sink_in_and_momenta_balance(speed: float, cells: int) -> None:
    """Not a micrometre at 5 m/s, and what the paddle gives is what the ball gets, to 1e-3.

    The ball's momentum is a sum of float32 velocities, 7 digits of some 5 m/s each. A light thing
    that springs off a heavy one goes at most at twice its speed.
    """
    scene = struck(MotionPath.straight((speed, 0.0, 0.0)), others=(Body(character=paddle(cells)),))
    simulation = Simulation(scene, time_step=0.01, fps=100.0)
    nodes = simulation.model.scene.parts[0].nodes
    masses, given = simulation.model.masses[nodes], np.zeros(3)
    while simulation.time < 0.2 / speed + 0.3:
        simulation.step()
        given += 0.01 * simulation.frame().contacts.force_on("ball", by="paddle")
        front = speed * simulation.time
        positions = numbers(simulation.state.positions)
        assert positions[nodes.stop :, 0].max() == pytest.approx(front, abs=1e-6)
        assert deepest(positions[nodes], front) < 1e-6
    momentum = masses @ numbers(simulation.state.velocities)[nodes]
    np.testing.assert_allclose(momentum, given, atol=1e-3 * np.abs(given).max())
    assert speed < momentum[0] / masses.sum() < 2.0 * speed
    assert simulation.summary().findings.doubts == ()


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_what_a_handle_gives_all_bodies_take(precision: Any) -> None:
    """The impulse of the handle is the momentum that paddle and ball have gained, at each step."""
    shifts = np.array([(0.0, 0.0, 0.0), (1.0, 0.2, 0.0)])
    path = MotionPath(times=np.array([0.0, 0.4]), shifts=shifts, between="ease")
    options = SimulationOptions(precision=precision)
    simulation = Simulation(struck(path), options=options, time_step=0.01, fps=100.0)
    masses = simulation.model.masses
    assert not simulation.handle_force("paddle").any()
    # the velocities at the start are those of the first step
    given = masses @ numbers(simulation.state.velocities)
    scale = masses.sum() * 5.0
    struck_once = False
    for _ in range(30):
        simulation.step()
        given += 0.01 * simulation.handle_force("paddle")
        momentum = masses @ numbers(simulation.state.velocities)
        np.testing.assert_allclose(momentum, given, atol=1e-4 * scale)
        struck_once |= bool(simulation.frame().contacts.force_on("ball").any())
    assert struck_once
    with pytest.raises(InputError, match="handle must be one of paddle, not 'ball'"):
        simulation.handle_force("ball")


@pytest.mark.parametrize("iterations", [1, 2])
def test_moving_paddle_is_the_resting_one_seen_from_elsewhere(iterations: int) -> None:
    """Galilei: a ball thrown at a paddle at rest, and a paddle that runs into a ball at rest."""
    options = SimulationOptions(precision="float64", tolerance=1e-10, newton_iterations=iterations)
    runs = []
    for speed, own in ((3.0, 0.0), (0.0, -3.0)):
        path = MotionPath.straight((speed, 0.0, 0.0))
        scene = struck(path, initial_velocity=(own, 0.0, 0.0))
        simulation = Simulation(scene, options=options, time_step=0.01, fps=100.0)
        for _ in range(20):
            simulation.step()
        runs.append(numbers(simulation.state.velocities) - [speed, 0.0, 0.0])
    np.testing.assert_allclose(runs[0], runs[1], atol=1e-6)


def test_belt_carries_a_block_along() -> None:
    """A block on a belt at 1 m/s gains mu g of speed a second until it goes with it."""
    slab = box((3, 3, 1), (6.0, 3.0, 0.3), (-1.5, -1.5, -0.3))
    flat = box((4, 4, 1), (0.4, 0.4, 0.1), (-0.2, -0.2, 0.0))
    scene = Scene(
        character=Character(
            name="flat", mesh=flat, material=Material(young_modulus=1e6, stiffness_damping=0.02)
        ),
        others=(Body(character=Character(name="belt", mesh=slab)),),
        handles=(Handle(region="belt", path=MotionPath.straight((1.0, 0.0, 0.0))),),
        body_friction=0.2,
    )
    simulation = Simulation(
        scene, options=SimulationOptions(precision="float64"), time_step=0.01, fps=100.0
    )
    masses = simulation.model.masses[: len(flat.points)]
    speeds = []
    for _ in range(100):
        simulation.step()
        own = numbers(simulation.state.velocities)[: len(masses), 0]
        speeds.append(float(masses @ own / masses.sum()))
    assert speeds[39] - speeds[19] == pytest.approx(0.2 * 9.81 * 0.2, rel=5e-3)
    assert speeds[-1] == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("iterations", [1, 2])
def test_bar_that_is_pulled_ends_as_statics_says(iterations: int) -> None:
    """A slender bar stretched by 1 % between a held end and a handle: u = 0.01 x, v = 0.

    With nu = 0 that is the exact solution of the discrete body.
    """
    mesh = box((8, 2, 2), (0.8, 0.2, 0.2))
    left: Any = mesh.points[:, 0] < 1e-9
    right: Any = mesh.points[:, 0] > 0.8 - 1e-9
    material = Material(young_modulus=1e5, poisson_ratio=0.0, stiffness_damping=0.05)
    body = Character(name="bar", mesh=mesh, material=material, fixed=left, regions={"end": right})
    shifts = np.array([(0.0, 0.0, 0.0), (0.008, 0.0, 0.0)])
    path = MotionPath(times=np.array([0.0, 0.5]), shifts=shifts, between="ease")
    scene = Scene(character=body, gravity=(0, 0, 0), handles=(Handle(region="end", path=path),))
    options = SimulationOptions(precision="float64", newton_iterations=iterations)
    simulation = Simulation(scene, options=options, time_step=0.01, fps=100.0)
    for _ in range(300):
        simulation.step()
    # E A e
    pull = simulation.handle_force("end")
    np.testing.assert_allclose(pull, (1e5 * 0.04 * 0.01, 0.0, 0.0), atol=0.02)
    expected = mesh.points * (1.01, 1.0, 1.0)
    np.testing.assert_allclose(numbers(simulation.state.positions), expected, atol=1e-7)


def test_turning_handle_ends_each_step_on_its_path() -> None:
    """A turning region is where its path says, to the rounding of a position, after any time."""
    bar = muscular_bar()
    path = MotionPath.spinning(720.0, (0.0, 0.0, 1.0), center=(0.1, 0.1, 0.0))
    scene = Scene(character=bar, handles=(Handle(region="top", path=path),), ground=Plane())
    simulation = Simulation(scene, time_step=0.01, fps=100.0)
    top = bar.region("top")
    for _ in range(50):
        simulation.step()
        expected = path.places(bar.mesh.points[top], simulation.time)
        np.testing.assert_allclose(numbers(simulation.state.positions)[top], expected, atol=1e-6)
    assert not simulation.asleep


def test_controller_s_maps_know_of_handles() -> None:
    """J v+ without muscles is that of a slack step, with a moving region."""
    path = MotionPath.straight((0.3, -0.2, 0.5))
    scene = Scene(character=muscular_bar(), handles=(Handle(region="top", path=path),))
    options = SimulationOptions(precision="float64", tolerance=1e-13, muscles="explicit")
    model = build_model(scene, options)
    body = rig(muscular_bar())
    body.model, body.stepper = model, Stepper(model)
    body.state, body.after = State.at_rest(model), State.at_rest(model)
    body.control, body.contacts = Control.slack(model), Contacts.none(model)
    handled = np.zeros((model.node_count, 3))
    handled[scene.handle_nodes[0]] = (0.3, -0.2, 0.5)
    body.control.handled.assign(handled)
    rows = np.random.default_rng(1).normal(size=(5, 3 * model.node_count))
    found = []
    dynamics = exact_dynamics(body)

    def decide() -> None:
        found.append(dynamics.solve(rows).free_velocity)

    body.stepper.step(body.state, body.control, body.contacts, body.after, decide=decide)
    expected = rows @ numbers(body.after.velocities).ravel()
    np.testing.assert_allclose(found[0], expected, rtol=1e-9)


def test_continued_handle_goes_on_beside_its_path() -> None:
    """Where a simulation goes on with another handle, nothing jumps."""
    first = Simulation(struck(MotionPath.straight((0.0, 1.0, 0.0))), time_step=0.01, fps=100.0)
    for _ in range(10):
        first.step()
    second = Simulation(
        struck(MotionPath.straight((0.0, 0.0, 2.0))), time_step=0.01, fps=100.0, after=first
    )
    second.step()
    moved = numbers(second.state.positions) - numbers(first.state.positions)
    start = len(ball().mesh.points)
    np.testing.assert_allclose(
        moved[start:], np.broadcast_to((0, 0, 0.02), moved[start:].shape), atol=1e-6
    )


def test_spin_at_the_start() -> None:
    """Of a free body: v = V + w x r about its centre of mass, and its angular momentum stays."""
    spin = (0.0, 0.0, 4.0)
    other = Body(character=paddle(), velocity=(0.0, 1.0, 0.0), spin=(1.0, 0.0, 0.0))
    scene = Scene(
        character=ball((2.0, 0.0, 0.0)), others=(other,), gravity=(0, 0, 0), initial_spin=spin
    )
    simulation = Simulation(scene, time_step=0.01, fps=100.0)
    for part, (velocity, rate) in zip(scene.parts, scene.starts, strict=True):
        masses = simulation.model.masses[part.nodes]
        places = scene.whole.mesh.points[part.nodes]
        arms = places - masses @ places / masses.sum()
        expected = np.asarray(velocity) + np.cross(rate, arms)
        found = numbers(simulation.state.velocities)[part.nodes]
        np.testing.assert_allclose(found, expected, atol=1e-6)


@pytest.mark.parametrize(
    ("region", "fixed", "sentence"),
    [
        ("nowhere", (), "no region or body of the scene is named 'nowhere'"),
        ("paddle", (3,), "the Handle of 'paddle' holds node"),
    ],
)
def test_what_cannot_be_held_is_refused(region: str, fixed: Any, sentence: str) -> None:
    path = MotionPath.straight((1.0, 0.0, 0.0))
    held = Character(name="paddle", mesh=paddle().mesh, fixed=fixed)
    with pytest.raises(InputError, match=sentence):
        Scene(
            character=ball(),
            others=(Body(character=held),),
            handles=(Handle(region=region, path=path),),
        )


def test_two_handles_of_one_node_are_refused() -> None:
    handle = Handle(region="paddle", path=MotionPath.straight((1.0, 0.0, 0.0)))
    with pytest.raises(InputError, match="which the Handle of 'paddle' holds too"):
        Scene(character=ball(), others=(Body(character=paddle()),), handles=(handle, handle))
