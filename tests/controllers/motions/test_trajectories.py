"""The smooth step, the eased cost, and what motions measure on a body."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.support.bodies import muscular_bar
from warp_softbody.controllers import ActivationCost
from warp_softbody.controllers.motions.body_measures import angle_turned, mean_weights, region_mean
from warp_softbody.controllers.motions.trajectories import eased_change, smooth_step, way_on
from warp_softbody.world.scene import Scene
from warp_softbody.world.view import BodyView


def test_the_smooth_step_begins_and_ends_at_rest_without_acceleration() -> None:
    assert smooth_step(0.0) == smooth_step(-3.0) == (0.0, 0.0, 0.0)
    assert smooth_step(1.0) == smooth_step(7.0) == (1.0, 0.0, 0.0)
    step, rate, bend = smooth_step(0.5)
    assert (step, bend) == (0.5, 0.0) and rate == pytest.approx(15.0 / 8.0, rel=1e-15)


@pytest.mark.parametrize("share", [0.1, 0.37, 0.5, 0.9])
def test_its_derivatives_are_those_of_finite_differences(share: float) -> None:
    h = 1e-5
    before, here, after = (np.array(smooth_step(share + k * h)) for k in (-1, 0, 1))
    # central differences are off by h^2 / 6 of the third derivative, at most 60, and by rounding
    np.testing.assert_allclose((after - before)[:2] / (2.0 * h), here[1:], atol=1e-8)


def test_a_way_on_begins_as_it_is_and_comes_to_rest_at_its_goal() -> None:
    assert way_on(0.3, -0.7, 1.1, 2.0, 0.0) == (0.3, -0.7)
    assert way_on(0.3, -0.7, 1.1, 2.0, 1.0) == (1.1, 0.0)
    # from rest it is the smooth step
    step, rate, _ = smooth_step(0.4)
    assert way_on(1.0, 0.0, 3.0, 2.0, 0.4) == pytest.approx((1.0 + 2.0 * step, rate), rel=1e-15)


@pytest.mark.parametrize("share", [0.0, 0.1, 0.37, 0.5, 0.9, 1.0])
def test_the_speed_of_a_way_on_is_that_of_finite_differences(share: float) -> None:
    seconds, h = 2.0, 1e-5
    near = np.clip([share - h, share + h], 0.0, 1.0)
    before, after = (way_on(0.3, -0.7, 1.1, seconds, at)[0] for at in near)
    middle = way_on(0.3, -0.7, 1.1, seconds, float(near.mean()))[1]
    assert (after - before) / (seconds * np.ptp(near)) == pytest.approx(middle, abs=1e-8)


@pytest.mark.parametrize("share", [0.0, 1.0])
def test_a_way_on_has_no_acceleration_at_its_ends(share: float) -> None:
    h = 1e-5
    speeds = [way_on(0.3, -0.7, 1.1, 2.0, abs(share - k * h))[1] for k in (0, 1)]
    # the acceleration is at most 60 units over the whole way, so that it grows to so much in h
    assert abs(speeds[1] - speeds[0]) < 60.0 * h**2 * 2.0


def test_a_change_is_dearest_at_first_and_costs_as_usual_from_share_one_on() -> None:
    usual = ActivationCost(effort=0.1, change=2.0)
    assert eased_change(usual, 3.0, 0.0) == ActivationCost(effort=0.1, change=8.0)
    assert eased_change(usual, 3.0, 0.5) == ActivationCost(effort=0.1, change=3.5)
    assert eased_change(usual, 3.0, 1.0) == eased_change(usual, 3.0, 2.0) == usual


def turned_bar(axis: str, angle: float) -> BodyView:
    """A bar that was turned about an axis through its corner, and moved."""
    character = muscular_bar()
    points = character.mesh.points
    return BodyView(
        scene=Scene(character=character),
        time=0.0,
        time_step=0.01,
        masses=np.random.default_rng(0).uniform(0.5, 1.0, len(points)),
        positions=points @ Rotation.from_euler(axis, angle).as_matrix().T
        + np.array([0.3, -0.2, 0.1]),
        velocities=np.zeros_like(points),
        touching=np.zeros(len(points), dtype=bool),
        activations=np.ones(character.segment_count),
    )


@pytest.mark.parametrize(("axis", "plane"), [("x", (1, 2)), ("y", (2, 0)), ("z", (0, 1))])
@pytest.mark.parametrize("angle", [-2.0, 0.3, 3.0])
def test_the_angle_of_a_rigid_turn_is_measured(
    axis: str, plane: tuple[int, int], angle: float
) -> None:
    assert angle_turned(turned_bar(axis, angle), *plane) == pytest.approx(angle, abs=1e-12)


def test_weights_of_a_region_give_its_mean() -> None:
    view = turned_bar("y", 0.4)
    expected = region_mean(view, view.positions, "top")
    found = mean_weights(view, ("top",)) @ view.positions
    np.testing.assert_allclose(found, expected, rtol=1e-13)
    assert mean_weights(view, ("top", "base")).sum() == pytest.approx(1.0, rel=1e-15)
