"""Rows of the objectives against finite differences of what they stand for."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from tests.support.bodies import box, crumpled, muscular_bar
from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.body.mesh_geometry import lumped_masses
from warp_softbody.controllers import objectives
from warp_softbody.errors import InputError
from warp_softbody.world.ground import Plane
from warp_softbody.world.scene import STANDARD_GRAVITY, Scene
from warp_softbody.world.view import BodyView

DT = 0.01


def make_view(
    character: Character | None = None, ground: Plane | None = None, seed: int = 0
) -> BodyView:
    """A crumpled body with random velocities."""
    character = character or Character(name="box", mesh=box((2, 2, 2), jitter=0.2))
    mesh = character.mesh
    positions = crumpled(mesh, amount=0.05)
    return BodyView(
        scene=Scene(character=character, ground=ground),
        time=0.0,
        time_step=DT,
        masses=lumped_masses(mesh.tets, mesh.volumes, len(mesh.points), 1000.0),
        positions=positions,
        velocities=np.random.default_rng(seed).standard_normal(positions.shape),
        touching=np.zeros(len(positions), dtype=bool),
        activations=np.ones(character.segment_count),
    )


def rate_of(function: Callable[[FloatArray], FloatArray], view: BodyView) -> FloatArray:
    """Central difference of a function of the positions along the velocities."""
    step = 1e-6
    ahead = function(view.positions + step * view.velocities)
    return (ahead - function(view.positions - step * view.velocities)) / (2.0 * step)


def test_momentum_rows_are_the_rate_of_the_first_moment() -> None:
    view = make_view()
    found = objectives.momentum_rows(view) @ view.velocities.ravel()
    np.testing.assert_allclose(found, rate_of(lambda x: view.masses @ x, view), rtol=1e-8)
    np.testing.assert_allclose(found, view.linear_momentum, rtol=1e-12)


def test_angular_momentum_rows_are_the_power_of_a_turn() -> None:
    """E . H is the rate of the kinetic energy along the turn e x (x - c)."""
    view = make_view()
    rows = objectives.angular_momentum_rows(view)
    found = rows @ view.velocities.ravel()
    arms = view.positions - view.masses @ view.positions / view.masses.sum()
    for axis in range(3):
        turn = np.cross(np.eye(3)[axis], arms)
        step = 1e-4
        energies = [
            0.5 * view.masses @ ((view.velocities + sign * step * turn) ** 2).sum(axis=1)
            for sign in (1.0, -1.0)
        ]
        assert found[axis] == pytest.approx((energies[0] - energies[1]) / (2.0 * step), rel=1e-7)
    np.testing.assert_allclose(found, view.angular_momentum, rtol=1e-12)
    # about the centre of mass: a translation has none
    translations = np.tile(np.eye(3), (view.node_count, 1))
    np.testing.assert_allclose(rows @ translations, 0.0, atol=1e-12 * np.abs(rows).sum())


@pytest.mark.parametrize("normal", [None, (0.0, 0.0, 1.0), (0.3, -0.2, 0.9)])
def test_base_row_is_the_gradient_of_the_projected_area(
    normal: tuple[float, float, float] | None,
) -> None:
    """Relative to the present area; triangles facing either way count positive."""
    character = muscular_bar()
    view = make_view(character, None if normal is None else Plane(normal=normal))
    base = np.isin(character.mesh.surface, character.region("base")).all(axis=1)
    triangles = character.mesh.surface[base]
    axis = np.array(normal or (0.0, 0.0, 1.0))
    axis /= np.linalg.norm(axis)

    def area(positions: FloatArray) -> FloatArray:
        a, b, c = positions[triangles].transpose(1, 0, 2)
        return np.asarray(0.5 * np.abs(np.cross(b - a, c - a) @ axis).sum())

    objective = objectives.base_area(view, triangles, growth=0.02, weight=3.0)
    unit = np.sqrt(np.ptp(character.mesh.points, axis=0).max() / STANDARD_GRAVITY)
    found = objective.rows @ view.velocities.ravel() * area(view.positions) / unit
    np.testing.assert_allclose(found, rate_of(area, view), rtol=1e-7)
    np.testing.assert_allclose(objective.target, 0.02 * unit, rtol=1e-12)
    np.testing.assert_array_equal(objective.weight, [3.0])


def cost(objective: objectives.Objective, velocities: FloatArray) -> float:
    miss = objective.rows @ velocities.ravel() - objective.target
    return float(objective.weight @ (miss * miss))


def test_momentum_objectives_measure_the_step_s_mean_force() -> None:
    """Zero where dL/dt is as wanted; one where it misses by the weight, at weight one."""
    view = make_view()
    wanted = np.array([3.0, -1.0, 2.0])
    objective = objectives.linear_momentum(view, wanted, 2.0)
    reached = view.velocities + DT * wanted / view.mass
    assert cost(objective, reached) == pytest.approx(0.0, abs=1e-16)
    reached[:, 0] += DT * 9.81
    assert cost(objective, reached) == pytest.approx(2.0, rel=1e-9)


def test_angular_momentum_objective_measures_the_step_s_mean_torque() -> None:
    view = make_view()
    arms = view.positions - view.center_of_mass
    spin = np.array([0.2, 0.5, -0.1])
    rate = np.asarray(view.masses @ np.cross(arms, np.cross(spin, arms))) / DT
    objective = objectives.angular_momentum(view, rate, [1.0, 2.0, 3.0], arm=0.5)
    assert cost(objective, view.velocities + np.cross(spin, arms)) == pytest.approx(0.0, abs=1e-14)
    unit = view.weight * DT * 0.5
    expected = (np.array([1.0, 2.0, 3.0]) * (DT * rate / unit) ** 2).sum()
    assert cost(objective, view.velocities) == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize("kind", ["node", "mean", "centre of mass", "difference"])
def test_position_and_velocity_objectives(kind: str) -> None:
    """The distance of f(x + dt v+) and of f(v+) from the goal, whatever f picks."""
    view = make_view()
    n = view.node_count
    weights = {
        "node": np.eye(n)[4],
        "mean": np.where(np.arange(n) < 6, 1.0 / 6.0, 0.0),
        "centre of mass": view.masses / view.mass,
        "difference": np.eye(n)[2] - np.eye(n)[9],
    }[kind]
    goal, factor = np.array([0.3, -0.2, 0.5]), np.array([1.0, 4.0, 0.0])
    after = np.random.default_rng(8).standard_normal(view.positions.shape)
    length = float(np.ptp(view.scene.character.mesh.points, axis=0).max())
    found = cost(objectives.position(view, weights, goal, factor), after)
    miss = weights @ (view.positions + DT * after) - goal
    assert found == pytest.approx(float(factor @ (miss / length) ** 2), rel=1e-10)
    assert cost(objectives.position(view, weights, goal, factor, unit=1.0), after) == (
        pytest.approx(float(factor @ miss**2), rel=1e-10)
    )
    found = cost(objectives.velocity(view, weights, goal, factor), after)
    miss = weights @ after - goal
    assert found == pytest.approx(float(factor @ miss**2) / (STANDARD_GRAVITY * length), rel=1e-10)
    assert cost(objectives.velocity(view, weights, goal, factor, unit=2.0), after) == (
        pytest.approx(float(factor @ miss**2) / 4.0, rel=1e-10)
    )


def test_bad_goals_are_named() -> None:
    view = make_view()
    weights = view.masses / view.mass
    with pytest.raises(InputError, match="'velocity': target must be finite"):
        objectives.velocity(view, weights, np.array([0.0, np.nan, 0.0]))
    with pytest.raises(InputError, match="'position': weight must not be negative"):
        objectives.position(view, weights, np.zeros(3), -1.0)
