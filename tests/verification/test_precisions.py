"""Single precision against double: no further apart than rounding and the solves' tolerance."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pytest

from tests.support.bodies import EXACT, Rig, box, epsilon, rig
from warp_softbody.arrays import FloatArray
from warp_softbody.body.material import Material
from warp_softbody.engine.options import Tangent

ROUNDINGS = 10
"""Places of a step where single precision rounds about as much as where it stores the state.

The differences of positions, F, R, strain, stress, force, their sum, matrix, residual and update.
"""


def swinging_beam(**options: Any) -> Rig:
    """A clamped beam of 0.8 m let go under gravity; half a second is 100 steps."""
    material = Material(young_modulus=2e5, poisson_ratio=0.4, stiffness_damping=0.01)
    mesh = box((8, 2, 2), (0.8, 0.2, 0.2))
    clamped = np.flatnonzero(mesh.points[:, 0] < 1e-9)
    gravity = (0.0, 0.0, -9.81)
    return rig(mesh, material=material, fixed=clamped, gravity=gravity, time_step=5e-3, **options)


def spinning_bar(**options: Any) -> Rig:
    """A free bar that tumbles at 23 rad/s without damping; 100 steps are two radians."""
    material = Material(young_modulus=1e6, poisson_ratio=0.3, stiffness_damping=0.0)
    body = rig(box((3, 2, 1), (0.3, 0.2, 0.1)), material=material, time_step=1e-3, **options)
    arms = body.positions - body.center
    body.place(arms, np.cross([10.0, 20.0, 5.0], arms))
    return body


def run(body: Rig, noise: np.random.Generator | None = None) -> FloatArray:
    """Positions and velocities after each of 100 steps, (100, 2, n, 3).

    With ``noise`` they are shaken before each step by at most what rounding to single moves them.
    """
    states = []
    for _ in range(100):
        if noise is not None:
            state = np.array([body.positions, body.velocities])
            half = 0.5 * epsilon("float32") * np.abs(state)
            body.place(*(state + half * noise.uniform(-1.0, 1.0, state.shape)))
        assert body.step().converged
        states.append([body.positions, body.velocities])
    return np.array(states)


def distance(states: FloatArray, others: FloatArray) -> FloatArray:
    """Largest at any node and time, in m and in m/s."""
    return np.asarray(np.abs(states - others).max(axis=(0, 2, 3)))


CASES: list[tuple[Tangent, float]] = [
    ("conserving", 1e-5),
    ("conserving", 1e-6),
    ("warped", 1e-6),
    ("exact", 1e-6),
]


@pytest.mark.parametrize(("tangent", "tolerance"), CASES)
@pytest.mark.parametrize("scene", [swinging_beam, spinning_bar], ids=["beam", "spinning"])
def test_single_precision_follows_double(
    scene: Callable[..., Rig], tangent: Tangent, tolerance: float
) -> None:
    scene = partial(scene, tangent=tangent)
    exact = run(scene(**EXACT))
    noises = [np.random.default_rng(seed) for seed in range(3)]
    shaken = np.max([distance(run(scene(**EXACT), noise), exact) for noise in noises], axis=0)
    # stopping at a tolerance leaves an error of a size, in either precision, not of a direction
    loose = distance(run(scene(precision="float64", tolerance=tolerance)), exact)
    single = distance(run(scene(precision="float32", tolerance=tolerance)), exact)
    bound = ROUNDINGS * shaken + 2.0 * loose
    assert (single < bound).all()
    # and the bound means something: a hundred steps with the tolerance
    assert (bound < 100.0 * tolerance * np.abs(exact).max(axis=(0, 2, 3))).all()
