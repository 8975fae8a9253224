"""Grounds that scenes can be set upon, and a walk over them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from warp_softbody import scenes
from warp_softbody.engine.options import SimulationOptions
from warp_softbody.run.simulation import Simulation
from warp_softbody.scenes.uneven_ground import BEGIN, MOST_UP, RISER, TREAD
from warp_softbody.world.friction_map import FrictionMap
from warp_softbody.world.ground import Plane
from warp_softbody.world.height_field import HeightField


def ground(**settings: float) -> Any:
    return scenes.make("walk-x", settings).scene.ground


def test_without_a_setting_it_is_a_plane() -> None:
    assert ground() == Plane(friction=0.8)


def test_a_slope_rises_by_its_angle_behind_a_level_place() -> None:
    field = ground(slope=15.0)
    assert isinstance(field, HeightField) and field.friction == 0.8
    height, slopes = field.surface(np.array([[BEGIN, 0.0], [-1.0, 1.0], [6.0, -2.0]]))
    np.testing.assert_allclose(height[:2], 0.0, atol=1e-15)
    np.testing.assert_allclose(slopes[2], [np.tan(np.radians(15.0)), 0.0], atol=1e-12)


def test_hills_are_as_high_as_told_and_differ_by_seed() -> None:
    one, same, other = (ground(roughness=0.05, ground_seed=seed).heights for seed in (1, 1, 2))
    np.testing.assert_array_equal(one, same)
    assert np.abs(one - other).max() > 0.01
    assert 0.03 < np.ptp(one) <= 0.05
    # nothing is under the body at first
    assert (one[:40] == 0.0).all()


def test_steps_are_as_high_as_told_and_as_steep_as_the_grid_has_them() -> None:
    field = ground(steps=0.05, ground_seed=4)
    assert isinstance(field, HeightField) and field.spacing[0] == RISER
    heights = field.heights[:, 0]
    assert (field.heights == heights[:, None]).all()
    x = field.origin[0] + RISER * np.arange(len(heights))
    jumps = np.diff(heights)
    at = np.flatnonzero(np.abs(jumps) > 1e-9)
    np.testing.assert_allclose(np.abs(jumps[at]), 0.05, atol=1e-12)
    # nothing is under the body at first, and the first step is one up
    assert x[at[0]] >= BEGIN and jumps[at[0]] > 0.0
    treads = np.diff(x[at])
    assert (treads > TREAD[0] - RISER).all() and (treads < TREAD[1] + RISER).all()
    assert np.abs(heights).max() < (MOST_UP + 0.5) * 0.05
    assert (jumps < 0.0).any()
    assert not np.array_equal(heights, ground(steps=0.05, ground_seed=5).heights[:, 0])


def test_stripes_lack_some_of_the_friction_ahead() -> None:
    plane = ground(friction_stripes=0.6, ground_seed=2)
    assert isinstance(plane, Plane) and plane.friction == 0.8
    placed = plane.friction_map
    assert isinstance(placed, FrictionMap)
    body = scenes.make("walk-x").scene.character.mesh.points
    np.testing.assert_array_equal(placed.at(body), 1.0)
    factors = placed.at(np.column_stack([np.linspace(1.0, 10.0, 50), np.zeros(50)]))
    assert 0.4 <= factors.min() < 0.5 and 0.9 < factors.max() <= 1.0
    mixed = ground(friction_stripes=0.6, ground_seed=2, steps=0.05, roughness=0.02, slope=5.0)
    assert mixed.friction_map == placed


def going(seconds: float, **settings: float) -> tuple[Simulation, np.ndarray[Any, Any]]:
    """A walk, and frame by frame how far its middle has come and how far the hub is clear, m."""
    plan = scenes.make("walk-x", settings)
    options = SimulationOptions(time_step=plan.time_step)
    simulation = Simulation(plan.scene, plan.controller, options=options, fps=5.0, name="walk-x")
    character = plan.scene.character
    hub, start = character.region("hub"), character.mesh.points[:, 0].mean()
    field = plan.scene.ground
    assert field is not None
    rows = [
        (frame.positions[:, 0].mean() - start, field.measure(frame.positions[hub])[0].min())
        for frame in simulation.run(seconds)
    ]
    return simulation, np.array(rows)


@pytest.mark.parametrize("slope", [15.0, -15.0])
@pytest.mark.long
def test_it_walks_over_hills_up_and_down(slope: float) -> None:
    """As far as on level ground, which is 3.5 m, with its middle off the ground."""
    simulation, rows = going(20.0, slope=slope, roughness=0.05, ground_seed=7)
    assert rows[-1, 0] > 3.1
    assert rows[:, 1].min() > 0.03
    findings = simulation.summary().findings
    assert findings.momentum_error < 1e-3 and findings.inverted_tets == 0


def test_it_steps_onto_a_slope() -> None:
    _, rows = going(6.0, slope=12.0, roughness=0.03)
    assert rows[-1, 0] > 0.75
    assert rows[:, 1].min() > 0.08


@pytest.mark.long
def test_it_walks_over_steps_as_fast_as_on_level_ground() -> None:
    """Steps of 5 % up and down: on level ground it goes 2.05 m in 12 s."""
    simulation, rows = going(12.0, steps=0.05, ground_seed=1, friction_stripes=0.5)
    assert rows[-1, 0] > 1.9
    assert simulation.summary().findings.inverted_tets == 0


def crawled(seconds: float, **settings: float) -> float:
    """How far, m, the earthworm comes ahead."""
    plan = scenes.make("crawl-i", settings)
    options = SimulationOptions(time_step=plan.time_step)
    simulation = Simulation(plan.scene, plan.controller, options=options, fps=5.0)
    frames = [frame.positions[:, 0].mean() for frame in simulation.run(seconds)]
    assert simulation.summary().findings.inverted_tets == 0
    return float(frames[-1] - frames[0])


@pytest.mark.long
def test_the_earthworm_crawls_up_a_slope_and_over_a_step() -> None:
    """As far as on level ground, which is 1.75 m in 18 s, and at least half as far over steps."""
    assert crawled(18.0, slope=15.0, friction=0.4) > 1.5
    assert crawled(18.0, steps=0.05) > 0.9
