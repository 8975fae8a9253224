"""Bodies that collide in free space: what one gains the others lose, and no energy comes of it."""

from __future__ import annotations

import numpy as np
import pytest

from tests.verification.conservation.cubes import NO_GRAVITY, colliding, cube
from tests.verification.conservation.flight import MOST, PRECISIONS
from warp_softbody import (
    Body,
    Scene,
    Simulation,
    SimulationOptions,
    placed,
)
from warp_softbody.engine.options import Precision


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize(("count", "speed"), [(2, 1.0), (2, 10.0), (5, 1.0), (5, 5.0)])
@pytest.mark.parametrize("young_modulus", [1e5, 1e7])
def test_momentum_of_colliding_bodies(
    count: int, speed: float, young_modulus: float, precision: Precision
) -> None:
    scene = colliding(count, speed, young_modulus)
    options = SimulationOptions(time_step=min(5e-3, 5e-3 / speed), precision=precision)
    simulation = Simulation(scene, options=options, fps=200.0)
    masses = simulation.model.masses
    frames = simulation.run(0.5 / speed + 0.05)
    first = next(frames)
    start, begun = masses @ first.velocities, masses @ (first.velocities**2).sum(axis=1)
    met = False
    for frame in frames:
        met |= bool(len(frame.contacts.points))
        kinetic = masses @ (frame.velocities**2).sum(axis=1)
        assert kinetic <= begun * (1.0 + 1e-3)
    assert met
    size = masses.sum() * speed
    np.testing.assert_allclose(masses @ frame.velocities, start, atol=MOST[precision] * size)


@pytest.mark.parametrize("speed", [10.0, 100.0])
def test_a_fast_collision_leaves_the_volume(speed: float) -> None:
    """Face to face at 100 m/s: within a tenth of its volume after it has sprung back."""
    one, two = cube("one", 4, 0.0), placed(cube("two", 4, 0.0), translation=(0.3, 0.0, 0.0))
    scene = Scene(
        character=one,
        others=(Body(character=two, velocity=(-speed, 0.0, 0.0)),),
        gravity=NO_GRAVITY,
    )
    simulation = Simulation(scene, options=SimulationOptions(time_step=1.0 / 120.0))
    for _ in simulation.run(0.5):
        pass
    volumes = simulation.shapes.volumes
    np.testing.assert_allclose(volumes, 1.0, atol=0.1)
