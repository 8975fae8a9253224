"""Forces of a script: momentum by their impulse, equal to a push, refused where they are wrong."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import warp_softbody as wsb
from tests.support.bodies import EXACT, box
from warp_softbody.arrays import FloatArray
from warp_softbody.errors import InputError

DT = 1.0 / 60.0
MESH = box((1, 1, 2), (0.1, 0.1, 0.2))
TOP = np.flatnonzero(MESH.points[:, 2] > 0.15)
FORCE = (3.0, -1.0, 0.5)


def bar(**scene: Any) -> wsb.Simulation:
    """A bar in free space, unless another scene is asked for; its damping is of strain alone."""
    regions: dict[str, Any] = {"top": TOP}
    character = wsb.Character(name="bar", mesh=MESH, muscles=(), regions=regions)
    given = {"character": character, "gravity": (0.0, 0.0, 0.0), **scene}
    options = wsb.SimulationOptions(time_step=DT, **EXACT)
    return wsb.Simulation(wsb.Scene(**given), options=options)


def momentum(simulation: wsb.Simulation) -> FloatArray:
    return np.asarray(simulation.model.masses @ simulation.state.velocities.numpy())


def take_steps(simulation: wsb.Simulation, count: int) -> None:
    for _ in range(count):
        simulation.step()


def test_momentum_is_the_impulse_until_the_force_is_removed() -> None:
    """F t of a constant force, however the body is deformed; the solves are exact to 1e-13."""
    simulation = bar()
    force = simulation.apply_force("top", FORCE)
    take_steps(simulation, 6)
    np.testing.assert_allclose(momentum(simulation), 6 * DT * np.array(FORCE), rtol=1e-10)
    force.force = (0.0, 0.0, 2.0)
    take_steps(simulation, 2)
    impulse = 6 * DT * np.array(FORCE) + 2 * DT * np.array((0.0, 0.0, 2.0))
    np.testing.assert_allclose(momentum(simulation), impulse, rtol=1e-10)
    force.remove()
    take_steps(simulation, 3)
    np.testing.assert_allclose(momentum(simulation), impulse, rtol=1e-10)


def test_a_region_s_force_is_that_of_a_push() -> None:
    """Bit for bit, as both are shared by mass; nodes and a mask name the same as the region."""
    push = wsb.Push(region="top", force=FORCE, start=0.0, duration=1.0)
    pushed = bar(pushes=(push,))
    mask = MESH.points[:, 2] > 0.15
    ways: list[Any] = ["top", TOP, TOP[::-1].tolist(), mask]
    applied = [bar() for _ in ways]
    for simulation, nodes in zip(applied, ways, strict=True):
        simulation.apply_force(nodes, FORCE)
    for simulation in (pushed, *applied):
        take_steps(simulation, 4)
    for simulation in applied:
        np.testing.assert_array_equal(
            simulation.state.positions.numpy(), pushed.state.positions.numpy()
        )


def test_weights_place_a_force() -> None:
    """Its torque about the centre of mass is that of the weighted mean of its nodes."""
    simulation = bar()
    weights = np.arange(1.0, 1.0 + len(TOP))
    simulation.apply_force(TOP, FORCE, weights=weights)
    simulation.step()
    masses, points = simulation.model.masses, MESH.points
    arms = points - masses @ points / masses.sum()
    place = weights @ arms[TOP] / weights.sum()
    velocities = simulation.state.velocities.numpy()
    spin = np.cross(arms, masses[:, None] * velocities).sum(axis=0)
    # a step's matrix is symmetric and does not resist a turn: only rounding is left
    np.testing.assert_allclose(spin, DT * np.cross(place, FORCE), atol=1e-10)


def test_two_forces_and_a_push_add_up() -> None:
    push = wsb.Push(region="top", force=(1.0, 0.0, 0.0), start=0.0, duration=2 * DT)
    simulation = bar(pushes=(push,))
    simulation.apply_force([0], (0.0, 2.0, 0.0))
    simulation.apply_force("top", (0.0, 0.0, 3.0))
    take_steps(simulation, 2)
    np.testing.assert_allclose(momentum(simulation), 2 * DT * np.array((1, 2, 3)), rtol=1e-10)


def test_a_sleeping_body_wakes() -> None:
    plan = wsb.scenes.make("drop-block")
    simulation = wsb.Simulation(plan.scene, time_step=plan.time_step)
    while not simulation.asleep:
        simulation.step()
    before = simulation.frame().positions
    weight = simulation.model.masses.sum() * 9.81
    everything = np.arange(simulation.model.node_count)
    simulation.apply_force(everything, (0.0, 0.0, 2.0 * weight))
    take_steps(simulation, 5)
    assert not simulation.asleep
    assert (simulation.frame().positions - before)[:, 2].min() > 0.0


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("bottom", FORCE), "no region 'bottom'"),
        (([99], FORCE), "nodes of apply_force must be node indices from 0 to 11"),
        (([], FORCE), "nodes of apply_force must be a region or nodes"),
        (("top", (1.0, 2.0)), "force of an AppliedForce"),
        (("top", (np.nan, 0.0, 0.0)), "force of an AppliedForce"),
    ],
)
def test_wrong_arguments_are_refused(arguments: tuple[Any, ...], words: str) -> None:
    simulation = bar()
    with pytest.raises(InputError, match=words):
        simulation.apply_force(*arguments)
    simulation.step()
    np.testing.assert_allclose(momentum(simulation), 0.0, atol=1e-12)


@pytest.mark.parametrize("weights", [[1.0], [1.0, -1.0, 1.0, 1.0], [0.0] * 4, "heavy"])
def test_wrong_weights_are_refused(weights: Any) -> None:
    with pytest.raises(InputError, match="weights of apply_force"):
        bar().apply_force("top", FORCE, weights=weights)


def test_a_force_that_is_set_wrong_stays_as_it_was() -> None:
    force = bar().apply_force("top", FORCE)
    with pytest.raises(InputError, match="force of an AppliedForce"):
        force.force = (np.inf, 0.0, 0.0)
    assert force.force == FORCE and "nodes=4" in repr(force)
