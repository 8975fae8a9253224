"""Rolling by given angles: the profile of speed, and what is asked of a body that follows it."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.wheels import STEP, wheel
from warp_softbody.controllers.controller import Goals
from warp_softbody.controllers.motions.roll import Roll
from warp_softbody.controllers.motions.roll_gains import Leg, RollGains
from warp_softbody.world.scene import STANDARD_GRAVITY

UNIT = float(np.sqrt(1.0 / STANDARD_GRAVITY))  # s
GAINS = RollGains(cruise=0.4, speedup=0.08, brake=0.05, closing=1.0, acceleration=0.2, hold=1.0)


def test_a_wheel_that_does_as_asked_stops_at_the_end_of_every_leg() -> None:
    """It comes up to the cruise evenly, stops within 2 degrees, rolls back, and is let go."""
    legs = (Leg(direction=1.0, turn=4.0), Leg(direction=-1.0, turn=3.0))
    roll = Roll(GAINS, legs=legs, rim="rim")
    angle = speed = time = fastest = furthest = 0.0
    while time < 30.0:
        goals = roll.goals(wheel(time, angle, speed))
        if goals is None:
            break
        speed += STEP * asked(goals, angle, speed)
        angle += STEP * speed
        time += STEP
        fastest, furthest = max(fastest, speed), max(furthest, angle)
    assert goals is None
    assert fastest == pytest.approx(GAINS.cruise / UNIT, rel=0.03)
    assert furthest == pytest.approx(4.0, abs=np.radians(2.0))
    assert angle == pytest.approx(furthest - 3.0, abs=np.radians(5.0))


def asked(goals: Goals, angle: float, speed: float) -> float:
    """The rate of the speed, rad/s^2, that the row of rolling asks for; none once let go."""
    if not goals.objectives:
        return -speed / STEP
    row = goals.objectives[0]
    unit = float((row.rows @ wheel(0.0, angle, 1.0).velocities.ravel())[0])
    return (float(row.target[0]) / unit - speed) / STEP


@pytest.mark.parametrize(("done", "speed", "ahead"), [(0.0, 0.0, True), (3.9, 1.2, False)])
def test_it_leans_ahead_to_start_and_back_to_brake(done: float, speed: float, ahead: bool) -> None:
    """Momentum about the contact and tilt of a round wheel are to change the same way."""
    roll = Roll(GAINS, legs=(Leg(direction=1.0, turn=4.0),), rim="rim")
    for angle in np.linspace(0.0, done, 5):
        goals = roll.goals(wheel(0.0, float(angle), speed))
    assert goals is not None
    assert (asked(goals, done, speed) > 0.0) == ahead
    assert (float(goals.objectives[-1].target[0]) > 0.0) == ahead
