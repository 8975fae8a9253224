"""The head over the base of a balancing letter, for rigid motions with known answers."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from warp_softbody import Scene
from warp_softbody.arrays import FloatArray
from warp_softbody.characters import letter_i
from warp_softbody.controllers.motions.balance import SKIP_WEIGHT, Balance, BalanceGains
from warp_softbody.controllers.motions.body_measures import region_mean
from warp_softbody.controllers.objectives import Objective
from warp_softbody.world.view import BodyView

SCENE = Scene(character=letter_i())
POINTS = SCENE.character.mesh.points
STEP = 1.0 / 60.0  # s
G = 9.81


def tipping(angle: float, rate: float = 0.0, speed: float = 0.0) -> BodyView:
    """A firm letter that has turned about y, turns on, and moves along x."""
    cos, sin = np.cos(angle), np.sin(angle)
    places = POINTS @ np.array([[cos, 0.0, -sin], [0.0, 1.0, 0.0], [sin, 0.0, cos]])
    turning = rate * np.stack([places[:, 2], 0.0 * places[:, 1], -places[:, 0]], axis=1)
    return BodyView(
        scene=SCENE,
        time=0.0,
        time_step=STEP,
        masses=np.full(len(POINTS), 1.0 / len(POINTS)),
        positions=places,
        velocities=turning + np.array([speed, 0.0, 0.0]),
        touching=np.zeros(len(POINTS), dtype=bool),
        activations=np.ones(0),
    )


def upright(view: BodyView, **gains: Any) -> Objective:
    goals = Balance(BalanceGains(upright_weight=1.0, **gains)).goals(view)
    (found,) = (one for one in goals.objectives if one.name == "upright")
    return found


def missing(objective: Objective, view: BodyView) -> FloatArray:
    """By how much (3,) m/s the velocities miss what is wanted of them."""
    return np.asarray(
        (objective.rows @ view.velocities.ravel() - objective.target) * G * STEP, dtype=np.float64
    )


@pytest.mark.parametrize("angle", [-0.4, 0.1, 0.4])
def test_a_head_that_follows_the_base_is_left_alone_where_the_body_is_firm(angle: float) -> None:
    view = tipping(angle, rate=1.5)
    np.testing.assert_allclose(missing(upright(view, follow=1.0), view)[:2], 0.0, atol=1e-12)


@pytest.mark.parametrize("follow", [0.0, 0.3])
def test_a_head_over_the_base_comes_back_by_what_the_base_does_not_turn(follow: float) -> None:
    """By the rate times its way, and against its own speed."""
    angle, rate, back = 0.2, 1.5, 2.0
    view = tipping(angle, rate=rate)
    found = missing(upright(view, follow=follow, upright=back), view)
    height = region_mean(view, POINTS, "head")[2]
    ahead = height * (rate * np.cos(angle) + back * G**0.5 * np.sin(angle))
    assert found[0] == pytest.approx((1.0 - follow) * ahead, rel=1e-6)
    assert abs(found[1]) < 1e-12


def test_a_squat_goes_as_deep_as_the_capture_point_is_off_and_no_faster_than_asked() -> None:
    view = tipping(0.0, speed=0.3)
    middle = view.center_of_mass[2]
    offset = 0.3 * (middle / G) ** 0.5
    slow = upright(view, squat=1.0, height_weight=0.5, height_rate=1.0, height_acceleration=9.0)
    assert slow.target[2] * G * STEP == pytest.approx(-(G**0.5) * offset, rel=1e-6)
    assert slow.weight[2] == 0.5
    fast = upright(view, squat=1.0, height_weight=0.5, height_rate=9.0, height_acceleration=2.0)
    assert fast.target[2] == pytest.approx(-2.0)


def test_a_skip_begins_where_the_capture_point_is_far_off() -> None:
    """It asks for a fall of the head that is faster than the ground can follow."""
    stands, skips = (
        upright(tipping(0.0, speed=speed), height_weight=0.5, skip_from=0.22)
        for speed in (0.9, 1.1)
    )
    assert stands.weight[2] == 0.5 and stands.target[2] == pytest.approx(0.0, abs=1e-9)
    assert skips.weight[2] == SKIP_WEIGHT and skips.target[2] < -4.0
