"""How a rolling body leans and heads, and how it is steered below its lean."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.support.wheels import SCENE, wheel
from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.body_units import BodyUnits, in_si
from warp_softbody.controllers.motions.axle import FULL, Axle
from warp_softbody.controllers.motions.roll_gains import RollGains
from warp_softbody.world.view import BodyView

GAINS = RollGains(
    steer=4.0, steer_rate=3.0, course=0.03, steer_follow=2.0, steer_weight=0.3, lean_weight=0.1
)
MIDDLE = np.array([0.0, 0.0, 0.5])


def turned(roll: float, lean: float, heading: float, rate: FloatArray) -> BodyView:
    """A rigid wheel that has rolled, leans its top towards y and heads towards y; rate in rad/s."""
    arms = SCENE.character.mesh.points - MIDDLE
    arms = Rotation.from_euler("yxz", [roll, -lean, heading]).apply(arms)
    still = wheel(0.0, 0.0, 0.0)
    return replace(still, positions=MIDDLE + arms, velocities=np.cross(rate, arms))


@pytest.mark.parametrize("roll", [0.0, 1.3, 4.0])
def test_lean_and_heading_of_a_rigid_wheel(roll: float) -> None:
    """However far it has rolled, to the second order of what it is off by."""
    lean, heading = 0.03, -0.02
    axle = Axle.of(turned(roll, lean, heading, np.array([-0.5, 0.0, 0.7])))
    assert (axle.lean, axle.heading) == pytest.approx((lean, heading), abs=1e-3)
    assert (axle.leaning, axle.turning) == pytest.approx((0.5, 0.7), abs=0.02)


def test_rows_are_the_rates() -> None:
    view = turned(0.7, 0.02, 0.01, np.array([-0.3, 0.0, 0.2]))
    axle, units = Axle.of(view), BodyUnits.of(view)
    objective = axle.objective(view, in_si(GAINS, units), 1.0)
    found = objective.rows @ view.velocities.ravel() / units.time
    np.testing.assert_allclose(found, [axle.turning, axle.leaning], rtol=1e-9)


def test_it_is_steered_into_its_lean_and_comes_back_to_its_way() -> None:
    """A thin ring without spin of its own, lean'' = g lean / R - speed turning, either way along x.

    Its characteristic polynomial is s^3 + (b c - k) s^2 + (b d - a) s + a k
    with a = g / R, b = speed (rad/s), c = steer_rate, d = steer, k = d course: stable while
    (b c - k) (b d - a) > a k.
    """
    units = BodyUnits.of(turned(0.0, 0.0, 0.0, np.zeros(3)))
    gains = in_si(GAINS, units)
    for way in (1.0, -1.0):
        speed, radius = way * 2.0, 0.5
        lean, leaning, heading, dt = 0.05, 0.0, 0.1, 1e-3
        for _ in range(12_000):
            axle = Axle(heading, lean, 0.0, leaning, np.zeros(0))
            rate = axle.steering(gains, speed, units)
            leaning += dt * (9.81 * lean - speed * radius * rate) / radius
            lean += dt * leaning
            heading += dt * rate
        assert abs(lean) < 1e-3
        assert abs(heading) < 0.02


def test_one_that_stands_is_not_steered() -> None:
    units = BodyUnits.of(turned(0.0, 0.0, 0.0, np.zeros(3)))
    axle = Axle(0.0, 0.01, 0.0, 0.0, np.zeros(0))
    gains = in_si(GAINS, units)
    full, half, none = (
        axle.steering(gains, share * FULL / units.time, units) for share in (2.0, 0.5, 0.0)
    )
    assert full == pytest.approx(gains.steer * 0.01)
    assert (half, none) == pytest.approx((0.5 * full, 0.0))
