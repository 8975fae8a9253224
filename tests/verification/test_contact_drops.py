"""Drops: nothing sinks, no energy is gained, the weight is carried, and friction ends the slide."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.verification.dropped_cube import G, cube, energy


@pytest.mark.parametrize("dt", [1 / 240, 1 / 100, 1 / 30])
@pytest.mark.parametrize("damping", [0.0, 0.005])
@pytest.mark.parametrize("young_modulus", [1e5, 1e7])
def test_a_drop_of_a_metre(young_modulus: float, damping: float, dt: float) -> None:
    """In no step does energy grow by more than what float32 positions hide.

    A position is rounded by 6e-8 of a metre, over which the weight does 6e-8 of m g; a hundred of
    these are allowed for the stresses that answer too.
    """
    body = cube(1.0, young_modulus, damping, dt)
    rounding = 100 * 6e-8 * body.masses.sum() * G
    lowest, last = 0.0, energy(body)
    for _ in range(round(1.5 / dt)):
        body.step()
        now = energy(body)
        assert now < last + rounding
        lowest, last = min(lowest, body.positions[:, 2].min()), now
    assert lowest > -1e-4


@pytest.mark.parametrize("young_modulus", [1e5, 1e7])
def test_dropped_cube_comes_to_rest_and_is_carried(young_modulus: float) -> None:
    """Largest node speed below 1e-4 m/s, and the weight to 1e-4."""
    body = cube(0.05, young_modulus, 0.02, 0.01)
    body.place(velocities=(1.0, 0.0, 0.0))
    body.step(200)
    assert np.linalg.norm(body.velocities, axis=1).max() < 1e-4
    normal = body.contacts.impulses.numpy().astype(np.float64)[:, 2].sum()
    assert normal == pytest.approx(body.masses.sum() * G * 0.01, rel=1e-4)


def rigid_way(height: float, speed: float, friction: float) -> float:
    """Flight, an impact that takes mu times the falling speed, and the slide to rest, m."""
    falling = math.sqrt(2.0 * G * height)
    left = speed - friction * falling
    return speed * falling / G + left**2 / (2.0 * friction * G)


def test_a_stiff_cube_slides_as_far_as_a_rigid_one() -> None:
    """By 3 %; the rest is elastic, and a step of flight more or less, 0.25 % of a metre."""
    body = cube(0.05, 1e9, 0.002, 0.0025, precision="float64")
    body.place(velocities=(1.0, 0.0, 0.0))
    start = body.center[0]
    body.step(400)
    assert body.center[0] - start == pytest.approx(rigid_way(0.05, 1.0, 0.5), rel=0.03)


def test_a_soft_cube_slides_as_far_at_any_time_step() -> None:
    """By 3 %, and less far than a rigid one.

    Its base sticks at the impact: the shear wave asks for a friction of rho c_s v = 6 kPa, and the
    pressure wave grants mu rho c_p v = 7 kPa.
    """
    ways = []
    for dt in (0.01, 0.0025):
        body = cube(0.05, 1e5, 0.02, dt)
        body.place(velocities=(1.0, 0.0, 0.0))
        start = body.center[0]
        body.step(round(2.0 / dt))
        ways.append(body.center[0] - start)
    assert ways[0] == pytest.approx(ways[1], rel=0.03)
    assert ways[0] < rigid_way(0.05, 1.0, 0.5)
