"""Handles that let go: nodes keep their velocities, and all that follows is a free body's."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.support.bodies import box, muscular_bar, numbers
from tests.verification.pair_bodies import SOFT
from warp_softbody import Handle, Material, MotionPath, Plane, Scene, Simulation, SimulationOptions
from warp_softbody.body.character import Character
from warp_softbody.controllers import Balance
from warp_softbody.errors import InputError
from warp_softbody.scenes.stairs import ball_mesh
from warp_softbody.world.joined_bodies import Body

DT = 0.01
EXACT = SimulationOptions(precision="float64", tolerance=1e-12)


def bar(**more: Any) -> Character:
    """Of 0.8 m along x, with a region at either end."""
    mesh = box((8, 2, 2), (0.8, 0.2, 0.2))
    ends: Any = {"left": mesh.points[:, 0] < 1e-9, "right": mesh.points[:, 0] > 0.8 - 1e-9}
    material = Material(young_modulus=2e4, poisson_ratio=0.3, stiffness_damping=0.02)
    return Character(name="bar", mesh=mesh, material=material, regions=ends, **more)


def momenta(simulation: Simulation) -> tuple[np.ndarray, np.ndarray]:
    """Linear momentum, and angular momentum about the centre of mass."""
    masses = simulation.model.masses
    places, speeds = (
        numbers(array) for array in (simulation.state.positions, simulation.state.velocities)
    )
    arms = places - masses @ places / masses.sum()
    return masses @ speeds, masses @ np.cross(arms, speeds)


@pytest.mark.parametrize("preconditioner", ["factor", "two_level"])
def test_a_thrown_ball_flies_with_what_it_was_given(preconditioner: Any) -> None:
    """All nodes are moved at V and let go at 0.1 s: p = m V + m g t, to rounding."""
    ball = Character(name="ball", mesh=ball_mesh(0.15, np.zeros(3)), material=SOFT)
    path = MotionPath.straight((3.0, 0.0, 4.0))
    scene = Scene(character=ball, handles=(Handle(region="ball", path=path, until=0.1),))
    options = SimulationOptions(precision="float64", preconditioner=preconditioner)
    simulation = Simulation(scene, options=options, time_step=DT, fps=100.0)
    start = simulation.model.masses @ ball.mesh.points / simulation.model.masses.sum()
    for step in range(1, 41):
        simulation.step()
        linear, _ = momenta(simulation)
        free = max(0, step - 10)
        mean = linear / simulation.model.masses.sum()
        np.testing.assert_allclose(mean, (3.0, 0.0, 4.0 - 9.81 * DT * free), atol=1e-9)
        place = simulation.model.masses @ numbers(simulation.state.positions)
        place = place / simulation.model.masses.sum() - start
        # x+ = x + dt v+
        fallen = 9.81 * DT**2 * free * (free + 1) / 2
        way = np.array((3.0, 0.0, 4.0)) * DT * step - (0.0, 0.0, fallen)
        np.testing.assert_allclose(place, way, atol=1e-9)
    assert simulation.summary().findings.momentum_error < 1e-9


@pytest.mark.parametrize("iterations", [1, 8])
def test_a_bar_that_is_let_go_keeps_its_momenta(iterations: int) -> None:
    """Pulled and turned by both ends, it springs back: its momenta do not change from then on.

    What the handles gave until then is what it has. Newton's method solves implicit Euler, which
    keeps no angular momentum, for which the linear step has arcs.
    """
    turning = MotionPath.spinning(90.0, (0.0, 1.0, 0.0), center=(0.3, 0.0, 0.1))
    handles = (
        Handle(region="left", path=MotionPath.straight((-0.3, 0.1, 0.0)), until=0.2),
        Handle(region="right", path=turning, until=0.2),
    )
    scene = Scene(character=bar(), gravity=(0, 0, 0), handles=handles)
    options = SimulationOptions(precision="float64", tolerance=1e-12, newton_iterations=iterations)
    simulation = Simulation(scene, options=options, time_step=DT, fps=100.0)
    given = momenta(simulation)[0]
    kept = np.zeros(3)
    for step in range(1, 61):
        simulation.step()
        forces = [simulation.handle_force(name) for name in ("left", "right")]
        given = given + DT * np.sum(forces, axis=0)
        linear, angular = momenta(simulation)
        np.testing.assert_allclose(linear, given, atol=1e-8)
        if step < 20:
            assert np.linalg.norm(forces) > 0.1
        elif step == 20:
            kept = angular
        else:
            assert not np.any(forces)
            allowed = 1e-9 if iterations == 1 else 0.05
            np.testing.assert_allclose(angular, kept, atol=allowed * np.linalg.norm(kept))
    stretch = np.ptp(numbers(simulation.state.positions)[:, 0])
    assert np.linalg.norm(kept) > 0.01
    assert stretch != pytest.approx(0.8, abs=1e-6)


def test_what_is_let_go_moves_as_what_was_never_held() -> None:
    """From the same state on, a bar that is let go is the bar of a scene without handles."""
    handle = Handle(region="right", path=MotionPath.straight((0.4, 0.0, 0.2)), until=0.1)
    ground = Plane(offset=-0.05)
    scene = Scene(character=bar(), ground=ground, handles=(handle,))
    first = Simulation(scene, options=EXACT, time_step=DT, fps=100.0)
    for _ in range(10):
        first.step()
    free = Simulation(
        Scene(character=bar(), ground=ground), options=EXACT, time_step=DT, fps=100.0, after=first
    )
    for _ in range(30):
        first.step()
        free.step()
    there = numbers(free.state.positions)
    np.testing.assert_allclose(numbers(first.state.positions), there, atol=1e-9)
    assert first.summary().findings.depth < 1e-6


def test_pairs_and_sleep_know() -> None:
    """A block that is held above another falls onto it once it is let go, though all slept."""
    low = box((3, 3, 1), (0.3, 0.3, 0.1))
    high = box((2, 2, 2), (0.2, 0.2, 0.2), (0.05, 0.05, 0.15))
    material = Material(young_modulus=1e5, stiffness_damping=0.05)
    scene = Scene(
        character=Character(name="low", mesh=low, material=material),
        others=(Body(character=Character(name="high", mesh=high, material=material)),),
        ground=Plane(),
        handles=(Handle(region="high", path=MotionPath(times=np.zeros(1)), until=1.2),),
    )
    simulation = Simulation(scene, time_step=DT, fps=100.0)
    nodes = scene.parts[1].nodes
    for _ in range(120):
        simulation.step()
    assert simulation.asleep
    np.testing.assert_allclose(numbers(simulation.state.positions)[nodes], high.points, atol=1e-6)
    for _ in range(150):
        simulation.step()
    weight = simulation.model.masses[nodes].sum() * 9.81
    borne = simulation.frame().contacts.force_on("high", by="low")
    np.testing.assert_allclose(borne, (0.0, 0.0, weight), atol=0.02 * weight)
    lowest = numbers(simulation.state.positions)[nodes, 2].min()
    assert 0.09 < lowest < 0.1


def balance() -> Balance:
    return Balance(base="base", head="top", patches=("base",))


def test_motions_that_are_kept_know_what_was_let_go() -> None:
    """Bits are those of the run itself, from before and from after, in either simulation."""
    character = muscular_bar()
    handle = Handle(region="top", path=MotionPath.straight((0.0, 0.2, 0.0)), until=0.1)
    scene = Scene(character=character, ground=Plane(), handles=(handle,))

    def made() -> Simulation:
        return Simulation(scene, balance(), time_step=DT, fps=100.0)

    def stepped(simulation: Simulation, count: int) -> np.ndarray:
        for _ in range(count):
            simulation.step()
        return numbers(simulation.state.positions)

    one, other = made(), made()
    stepped(one, 5)
    before = one.save()
    stepped(one, 15)
    after = one.save()
    wanted = stepped(one, 5)
    other.restore(after)
    np.testing.assert_array_equal(stepped(other, 5), wanted)
    other.restore(before)
    np.testing.assert_array_equal(stepped(other, 20), wanted)


def test_times_that_are_none_are_refused() -> None:
    path = MotionPath.straight((1.0, 0.0, 0.0))
    with pytest.raises(InputError, match=r"Handle\.until must be a finite number of s, at least 0"):
        Handle(region="ball", path=path, until=-1.0)
