"""Bodies in free space: the fall, and what is conserved with and without muscles."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.bodies import EXACT, Rig, box, epsilon, muscular_bar, rig
from warp_softbody.arrays import FloatArray
from warp_softbody.body.material import Material
from warp_softbody.engine.options import Tangent

GRAVITY = (0.0, 0.0, -9.81)
DAMPED = Material(young_modulus=2e5, poisson_ratio=0.4, stiffness_damping=0.01)


def rates(errors: list[float]) -> FloatArray:
    """Observed orders of errors at step sizes halved from one to the next."""
    return np.asarray(np.log2(np.asarray(errors[:-1]) / np.asarray(errors[1:])))


def test_free_fall_is_the_scheme_s_to_rounding() -> None:
    """x_n = x_0 + v_0 t - g dt^2 n (n + 1) / 2 of the symplectic Euler method."""
    dt, count = 0.01, 50
    body = rig(box(), gravity=GRAVITY, time_step=dt, **EXACT)
    body.place(velocities=(0.2, 0.0, 1.0))
    start = body.positions
    body.step(count)
    fall = np.array([0.2, 0.0, 1.0]) * count * dt
    fall[2] -= 9.81 * dt**2 * count * (count + 1) / 2
    np.testing.assert_allclose(body.positions, start + fall, atol=1e-11)


def test_free_fall_in_single_precision() -> None:
    """Each step's velocity is off by the tolerance, and its position by an eps of where it is."""
    dt, count, tolerance = 0.01, 50, 1e-6
    body = rig(box(), gravity=GRAVITY, time_step=dt, precision="float32", tolerance=tolerance)
    start = body.positions
    body.step(count)
    fall = -9.81 * dt**2 * count * (count + 1) / 2
    drift = count * tolerance * (9.81 * dt * count) * dt * count
    bound = drift + count * epsilon("float32") * (abs(fall) + 0.2)
    np.testing.assert_allclose(body.positions[:, 2], start[:, 2] + fall, atol=bound)


def test_free_fall_converges_at_first_order() -> None:
    errors = []
    for count in (10, 20, 40):
        body = rig(box(), gravity=GRAVITY, time_step=0.4 / count, **EXACT)
        start = body.center[2]
        body.step(count)
        errors.append(abs(body.center[2] - start + 0.5 * 9.81 * 0.4**2))
    np.testing.assert_allclose(rates(errors), 1.0, atol=0.1)


def shaken_bar() -> FloatArray:
    """Velocities that twist, bend and stretch an upright bar of 0.6 m, and turn it."""
    points = muscular_bar().mesh.points
    middle = points - points.mean(axis=0)
    twist = np.cross([0.0, 0.0, 1.0], middle) * (3.0 * middle[:, 2:])
    bend = np.outer(middle[:, 2] ** 2, [4.0, 0.0, 0.0])
    stretch = middle * np.array([0.0, 0.0, 1.0])
    swing = twist + bend + stretch + np.cross([1.0, 0.5, 2.0], middle)
    return np.asarray(swing + np.array([0.3, 0.1, 0.8]))


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_linear_momentum_of_a_shaken_body_in_flight(precision: str) -> None:
    """As p_0 - m g t, up to the solves' residuals: |b| times the tolerance times sqrt(nodes)."""
    tolerance = 1e-6 if precision == "float32" else 1e-13
    body = rig(
        muscular_bar(DAMPED),
        gravity=GRAVITY,
        time_step=0.005,
        precision=precision,
        tolerance=tolerance,
    )
    body.place(velocities=shaken_bar())
    start, count = body.momentum, 100
    body.step(count)
    expected = start + body.masses.sum() * np.array(GRAVITY) * 0.005 * count
    size = float(np.sqrt(((body.masses[:, None] * shaken_bar()) ** 2).sum()))
    eps = 8 * epsilon("float32" if precision == "float32" else "float64")
    bound = count * np.sqrt(len(body.masses)) * (tolerance + eps) * size
    np.testing.assert_allclose(body.momentum, expected, atol=bound)


def turning_bar(
    steps: int, stretched: bool, damping: float = 0.0, tangent: Tangent = "warped"
) -> tuple[float, Rig]:
    """A bar that turns for 0.1 s and the relative change of its angular momentum.

    It swings because it starts stretched and sheared, or because one side contracts.
    """
    material = Material(young_modulus=2e4, poisson_ratio=0.3, stiffness_damping=damping)
    character = muscular_bar(material, strength=2e4)
    body = rig(character, time_step=0.1 / steps, tangent=tangent, **EXACT)
    points = body.positions - body.positions.mean(axis=0)
    if stretched:
        points = points @ np.array([[1.0, 0.2, 0.0], [0.0, 1.0, 0.0], [0.1, 0.0, 1.2]]).T
    else:
        body.activate(np.where(np.arange(12) < 6, 0.8, 1.0))
    body.place(points, np.cross([0.0, 1.0, 4.0], points))
    start = body.angular_momentum
    body.step(steps)
    change = np.linalg.norm(body.angular_momentum - start)
    return float(change / np.linalg.norm(start)), body


@pytest.mark.parametrize("stretched", [True, False], ids=["stretched", "contracting"])
def test_momentum_of_a_turning_body_is_kept(stretched: bool) -> None:
    """Linear and angular momentum to rounding, whatever the step."""
    runs = [turning_bar(steps, stretched) for steps in (25, 100, 400)]
    for change, body in runs:
        assert change < 1e-11
        np.testing.assert_allclose(body.momentum, 0.0, atol=1e-10)
    if not stretched:
        # and the muscles do contract
        lengths = runs[0][1].stepper.lengths.numpy() / body.model.muscles.rest_lengths
        assert lengths[:6].mean() < 0.97


@pytest.mark.parametrize("damping", [0.0, 0.02])
@pytest.mark.parametrize("stretched", [True, False], ids=["stretched", "contracting"])
def test_conserving_tangent_keeps_angular_momentum(stretched: bool, damping: float) -> None:
    """Its K takes every turn of the deformed body to zero: only the solver's residual is left."""
    for steps in (25, 100):
        change, body = turning_bar(steps, stretched, damping, "conserving")
        assert change < 1e-9
        np.testing.assert_allclose(body.momentum, 0.0, atol=1e-10)


@pytest.mark.parametrize("tangent", ["warped", "exact"])
@pytest.mark.parametrize("stretched", [True, False], ids=["stretched", "contracting"])
def test_stiffness_damping_does_not_turn_a_strained_body(stretched: bool, tangent: Tangent) -> None:
    """The matrices of these tangents would: by a few percent in 0.1 s, were it not given back."""
    change, _ = turning_bar(100, stretched, 0.02, tangent)
    assert change < 1e-11
