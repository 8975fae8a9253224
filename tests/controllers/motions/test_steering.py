"""Steering: frames along arcs, trails that are followed, and what is refused."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from warp_softbody.controllers import DIAGONAL_PAIRS, Steering, Trail, Walk
from warp_softbody.controllers.motions.guidance import Feet, Guidance
from warp_softbody.controllers.motions.moving_frame import MovingFrame, Rates
from warp_softbody.controllers.motions.steering import TrailFollower, checked_guide
from warp_softbody.controllers.motions.walk_course import Course, TurnTaking
from warp_softbody.errors import InputError

ORIGIN = np.zeros(2)
HASTENING = Rates(1.0, 1.0, 1.0)


def test_a_frame_that_turns_goes_round_a_circle() -> None:
    rates = Rates(0.3, 0.0, 0.5)
    frame = MovingFrame(ORIGIN, 0.0, rates).on(math.pi, 0.0)
    # a quarter of a circle of radius v / w = 0.6 m about (0, 0.6)
    np.testing.assert_allclose(frame.place, [0.6, 0.6], atol=1e-12)
    assert frame.yaw == pytest.approx(math.pi / 2.0)
    np.testing.assert_allclose(frame.on(-math.pi, 0.0).place, ORIGIN, atol=1e-12)
    np.testing.assert_allclose(frame.velocity(0.0), [0.0, 0.3], atol=1e-12)


def test_a_heading_turns_what_is_forward() -> None:
    frame = MovingFrame(ORIGIN, 0.0, Rates(0.2, 0.1)).on(1.0, math.pi / 2.0)
    np.testing.assert_allclose(frame.place, [-0.1, 0.2], atol=1e-12)


@pytest.mark.parametrize("parts", [1, 7])
def test_rates_change_evenly(parts: int) -> None:
    """From rest to v at the acceleration a it goes v^2 / 2 a, in steps of any length."""
    frame, wanted = MovingFrame(ORIGIN), Rates(0.5)
    for _ in range(parts):
        frame = frame.steered(2.0 / parts, wanted, HASTENING, 0.0)
    assert frame.rates == wanted
    assert frame.place[0] == pytest.approx(0.5**2 / 2.0 + 0.5 * 1.5)


def test_a_foot_keeps_its_place_in_a_frame() -> None:
    frame = MovingFrame(np.array([1.0, 2.0]), math.pi / 2.0)
    np.testing.assert_allclose(frame.at(np.array([0.3, 0.1])), [0.9, 2.3], atol=1e-12)


def test_a_trail_is_followed_to_its_end() -> None:
    angle = np.linspace(0.0, math.pi, 50)
    trail = Trail(points=np.column_stack([np.sin(angle), 1.0 - np.cos(angle)]))
    assert trail.length == pytest.approx(math.pi, rel=1e-3)
    follower, frame, off = TrailFollower(trail, 1.0), MovingFrame(ORIGIN), []
    for _ in range(2000):
        asked = follower.steering(frame.place, frame.yaw, 0.3)
        rates = Rates(asked.forward or 0.0, asked.aside, asked.turning)
        frame = frame.steered(0.01, rates, HASTENING, 0.0)
        off.append(abs(math.dist(frame.place, (0.0, 1.0)) - 1.0))
    assert max(off) < 0.03
    assert math.dist(frame.place, (0.0, 2.0)) < 0.05
    assert frame.rates == Rates()


@pytest.mark.parametrize("aside", [0.0, 0.05, 0.1])
def test_it_comes_to_the_end_of_a_trail_as_it_leads(aside: float) -> None:
    """A body beside the trail does not turn to its last point when that is near."""
    follower = TrailFollower(Trail(points=np.array([(0.0, 0.0), (0.6, 0.0)])), 1.0)
    frame = MovingFrame(np.array([0.0, aside]))
    for _ in range(2000):
        asked = follower.steering(frame.place, frame.yaw, 0.2)
        rates = Rates(asked.forward or 0.0, asked.aside, asked.turning)
        frame = frame.steered(0.01, rates, HASTENING, 0.0)
    assert follower.arrived
    assert abs(frame.yaw) < 0.3
    assert math.dist(frame.place, (0.6, 0.0)) < aside + 0.03


def test_turning_leaves_less_to_go_ahead() -> None:
    feet = Feet(length=1.0, reach=0.5, cycle=2.0, stride=0.5, most_stride=0.6)
    for asked, forward in ((Steering(), 0.25), (Steering(turning=0.4), 0.1)):
        assert Guidance(asked, feet, 0.0)._possible(asked).forward == pytest.approx(forward)
    too_much: tuple[Any, ...] = (
        Steering(turning=1.0),
        (Steering(), Steering(start=9.0, forward=1.0)),
        Trail(points=np.eye(2), forward=5.0),
    )
    for guide in too_much:
        with pytest.raises(InputError, match=r"this walk moves its feet by at most 0\.3 m/s"):
            Guidance(guide, feet, 0.0)


def test_only_a_walk_along_a_trail_ends() -> None:
    walk = Walk(gait=DIAGONAL_PAIRS)
    assert not hasattr(walk, "finished")
    trail = Walk(gait=DIAGONAL_PAIRS, steering=Trail(points=np.eye(2)))
    assert trail.finished is False


def test_what_lies_behind_is_turned_to() -> None:
    follower = TrailFollower(Trail(points=np.array([(0.0, 0.0), (-2.0, 0.0)])), 1.0)
    frame = MovingFrame(ORIGIN)
    for _ in range(4000):
        asked = follower.steering(frame.place, frame.yaw, 0.3)
        rates = Rates(asked.forward or 0.0, asked.aside, asked.turning)
        frame = frame.steered(0.01, rates, HASTENING, 0.0)
    assert math.dist(frame.place, (-2.0, 0.0)) < 0.05


def test_a_body_that_is_told_to_stand_moves_every_foot_once_more() -> None:
    taking = TurnTaking(((0,), (1,), (2,)))
    moved = [taking.turn(number, standing=number >= 2) for number in range(7)]
    assert moved == [(0,), (1,), (2,), (0,), (1,), (), ()]
    assert taking.turn(7, standing=False) == (1,)


def course(steps_ahead: int, count: int) -> Course:
    """Of a walk that is turned from rest, after a count of steps of 0.1 s over so many."""
    feet = Feet(length=1.0, reach=0.5, cycle=2.0, stride=0.5, most_stride=0.6)
    going = Course(feet, ((0,), (1,)), ORIGIN, guide=Steering(turning=0.4), heading=0.0)
    for step in range(count):
        view: Any = SimpleNamespace(
            time=0.1 * step / steps_ahead,
            time_step=0.1 / steps_ahead,
            horizon=0.1,
            steps_ahead=steps_ahead,
            center_of_mass=np.zeros(3),
        )
        going.go_on(view, 0)
    return going


@pytest.mark.parametrize("steps_ahead", [2, 4])
@pytest.mark.parametrize("count", [2, 9])
def test_a_course_knows_its_frame_one_horizon_before_and_ahead(
    steps_ahead: int, count: int
) -> None:
    """However many steps that is: rates that change evenly go as far in steps of any length."""
    whole, parts = course(1, count), course(steps_ahead, 1 + (count - 1) * steps_ahead)
    for name in ("before", "now", "ahead"):
        one, other = getattr(whole, name), getattr(parts, name)
        np.testing.assert_allclose(other.place, one.place, atol=2e-4)
        assert other.yaw == pytest.approx(one.yaw, abs=1e-9)
    assert parts.ahead.yaw > parts.now.yaw >= parts.before.yaw
    shift = np.array([1.0, 0.0])
    parts.shift(shift)
    np.testing.assert_allclose(parts.before.place, whole.before.place + shift, atol=2e-4)


def test_feet_reach_the_speed_of_their_longest_stride() -> None:
    feet = Feet(length=1.0, reach=0.5, cycle=2.0, stride=0.4, most_stride=0.6)
    assert (feet.usual, feet.most) == pytest.approx((0.2, 0.3))
    assert feet.speed(Rates(0.3, 0.4, -1.0)) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: Steering(forward=math.nan), "Steering.forward must be a finite number"),
        (lambda: Steering(turning=math.inf), "Steering.turning must be a finite number"),
        (lambda: Steering(start=-1.0), "Steering.start must be"),
        (lambda: Trail(points=np.zeros((1, 2))), "Trail.points must be two points or more, got 1"),
        (lambda: Trail(points=np.zeros((3, 2))), r"Trail.points\[0\] and \[1\] are the same"),
        (lambda: Trail(points=np.zeros((3, 3))), "Trail.points must"),
        (lambda: Trail(points=np.eye(2), forward=0.0), "Trail.forward must be"),
        (lambda: checked_guide("steering", "left"), "steering must be a Steering, several"),
        (lambda: checked_guide("steering", ()), "steering must be a Steering, several"),
        (lambda: checked_guide("steering", (Steering(), 1)), r"steering\[1\] must be"),
        (lambda: checked_guide("steering", (Steering(), Steering())), r"\[1\].start must be after"),
    ],
)
def test_what_is_no_steering_is_refused(make: Any, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        make()
