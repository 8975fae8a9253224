"""Grounds that scenes can be set upon, and a walk over them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from warp_softbody import scenes
from warp_softbody.engine.options import SimulationOptions
from warp_softbody.run.simulation import Simulation
from warp_softbody.scenes.uneven_ground import BEGIN
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
