"""A world that is turned about the vertical, and what its controller wants there."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.robustness.turned_world import rotation, turned_back, turned_plan
from benchmarks.robustness.variation import Variation
from warp_softbody import scenes
from warp_softbody.errors import InputError
from warp_softbody.run.simulation import Simulation
from warp_softbody.stage_exports import StageWriter, read_take


def simulation_of(scene: str, degrees: float) -> Simulation:
    plan = scenes.make(scene)
    plan = turned_plan(plan, degrees) if degrees else plan
    return Variation(name="exact", options={"precision": "float64"}).simulation(plan)


def test_every_part_of_the_scene_is_turned(tmp_path: Path) -> None:
    shipped = scenes.make("crawl-i", {"push": 0.2}).scene
    turned = turned_plan(scenes.make("crawl-i", {"push": 0.2}), 90.0).scene
    quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    assert rotation(90.0) == pytest.approx(quarter, abs=1e-15)

    def check(new: object, old: object) -> None:
        assert np.asarray(new) == pytest.approx(np.asarray(old) @ quarter.T, abs=1e-12)

    check(turned.character.mesh.points, shipped.character.mesh.points)
    check(turned.pushes[0].force, shipped.pushes[0].force)
    for new, old in zip(turned.character.fibers, shipped.character.fibers, strict=True):
        check(new.vertices, old.vertices)
    (new_friction,), (old_friction,) = (
        scene.character.directional_friction for scene in (turned, shipped)
    )
    check(new_friction.direction, old_friction.direction)
    assert turned.ground == shipped.ground


@pytest.mark.parametrize("scene", ["walk-x", "crawl-i"])
def test_goals_mean_the_same_of_turned_velocities(scene: str) -> None:
    degrees = 37.0
    turn = rotation(degrees)
    plan, turned = scenes.make(scene), turned_plan(scenes.make(scene), degrees)
    simulations = [simulation_of(scene, 0.0), simulation_of(scene, degrees)]
    own, other = (
        one.controller.goals(simulation.view())
        for one, simulation in zip((plan, turned), simulations, strict=True)
        if one.controller is not None
    )
    if own is None or other is None:
        # slack at the start, both
        assert own is other
        return
    velocities = np.random.default_rng(1).normal(size=(simulations[0].model.node_count, 3))
    for a, b in zip(own.objectives, other.objectives, strict=True):
        found = b.rows @ (velocities @ turn.T).ravel()
        assert found == pytest.approx(a.rows @ velocities.ravel(), rel=1e-9, abs=1e-9)
        assert b.target == pytest.approx(a.target, rel=1e-9, abs=1e-9)
    for p, q in zip(own.patches, other.patches, strict=True):
        assert q.frame == pytest.approx(p.frame @ turn.T, abs=1e-9)


@pytest.mark.parametrize("degrees", [11.0, 22.5, 37.0, 61.0, 90.0])
def test_a_turn_changes_nothing_but_the_axes(degrees: float) -> None:
    """The polygons of friction lie along the motion, and so turn with it; in double precision."""
    own, turned = simulation_of("slide-f", 0.0), simulation_of("slide-f", degrees)
    # the pull begins at 0.5 s
    for _ in range(50):
        own.step()
        turned.step()
    back = turned.view().positions @ rotation(degrees)
    moved = np.abs(own.view().positions - own.model.scene.whole.mesh.points).max()
    assert moved > 1e-3
    assert np.abs(back - own.view().positions).max() < 1e-4 * moved


def test_a_stage_is_turned_back(tmp_path: Path) -> None:
    plan = turned_plan(scenes.make("slide-f"), 37.0)
    stage = tmp_path / "turned.usdc"
    simulation = Simulation(plan.scene, plan.controller, time_step=plan.time_step, fps=60.0)
    with StageWriter(stage, plan.scene, fps=60.0) as writer:
        for frame in simulation.run(0.05):
            writer.write(frame)
    take = turned_back(read_take(stage), 37.0)
    points = scenes.make("slide-f").scene.character.mesh.points
    # stages are in single precision
    assert take.rest == pytest.approx(points, abs=1e-6)
    assert take.tet_points[0] == pytest.approx(points, abs=1e-6)


def test_what_cannot_be_turned_is_refused() -> None:
    with pytest.raises(InputError, match="level plane"):
        turned_plan(scenes.make("rough-ground"), 37.0)
    with pytest.raises(InputError, match="one body"):
        turned_plan(scenes.make("stack"), 37.0)
