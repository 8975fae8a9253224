"""Rayleigh damping of a body's own eigenmodes, found by SciPy, over many steps.

A mode of frequency w obeys q'' = -(mu + lambda w^2) q' - w^2 q; a step is implicit Euler's:
(1 + dt mu + (dt lambda + dt^2) w^2) v+ = v - dt w^2 q, q+ = q + dt v+.
"""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.bodies import EXACT, Rig, box, epsilon, rig
from tests.verification.accuracy import Modes, modes_of, orders, recurrence, rest_stiffness
from warp_softbody.body.material import Material

SIZE = (0.5, 0.2, 0.15)
MESH = box((5, 2, 2), SIZE, jitter=0.2)
CLAMPED = np.flatnonzero(MESH.points[:, 0] < 1e-9)
COUNT = 10
AMPLITUDE = 1e-7
CELL = 0.05

# the last is beyond critical for the upper modes
DAMPINGS = [(0.0, 0.0), (2.0, 0.0), (0.0, 5e-3), (2.0, 5e-3), (2.0, 5e-2)]
each_damping = pytest.mark.parametrize(("mass_damping", "stiffness_damping"), DAMPINGS)
clamped_or_free = pytest.mark.parametrize("clamped", [True, False], ids=["clamped", "free"])


def eigenmodes(clamped: bool) -> Modes:
    """The lowest that move the body's shape: bending, twist, stretch."""
    plain = Material(young_modulus=1e5, poisson_ratio=0.3)
    return modes_of(MESH, plain, COUNT, CLAMPED if clamped else (), skip=0 if clamped else 6)


def damped(mass_damping: float, stiffness_damping: float, clamped: bool, step: float) -> Rig:
    material = Material(
        young_modulus=1e5,
        poisson_ratio=0.3,
        mass_damping=mass_damping,
        stiffness_damping=stiffness_damping,
    )
    fixed = CLAMPED if clamped else ()
    return rig(MESH, material=material, fixed=fixed, time_step=step, **EXACT)


def margin(steps: int) -> float:
    """Of coordinates, relative to the largest: turns of the tets and rounding of positions."""
    return AMPLITUDE / CELL + steps * epsilon("float64") * SIZE[0] / AMPLITUDE


@each_damping
@clamped_or_free
def test_many_modes_follow_the_scheme_at_once(
    mass_damping: float, stiffness_damping: float, clamped: bool
) -> None:
    """Ten modes, a displacement and a velocity of its own for each, at every one of 60 steps."""
    modes, steps = eigenmodes(clamped), 60
    w = modes.frequencies
    step = 0.1 / float(w[0])
    body = damped(mass_damping, stiffness_damping, clamped, step)
    rng = np.random.default_rng(7)
    q, v = rng.uniform(-1.0, 1.0, (2, COUNT)) * np.array([np.ones(COUNT), w])
    scale = AMPLITUDE / np.abs(np.tensordot(q, modes.shapes, 1)).max()
    q, v = scale * q, scale * v
    body.place(MESH.points + np.tensordot(q, modes.shapes, 1), np.tensordot(v, modes.shapes, 1))
    decay = 1.0 + step * mass_damping + step * (stiffness_damping + step) * w**2
    bound = margin(steps) * float(np.abs(q).max() + step * np.abs(v).max())
    for _ in range(steps):
        v = (v - step * w**2 * q) / decay
        q = q + step * v
        body.step()
        np.testing.assert_allclose(modes.coordinates(body.positions - MESH.points), q, atol=bound)
        np.testing.assert_allclose(modes.coordinates(body.velocities), v, atol=bound / step)


@pytest.mark.parametrize(("mass_damping", "stiffness_damping"), DAMPINGS[:4])
@clamped_or_free
@pytest.mark.parametrize("index", [0, 4, 9])
def test_decay_tends_to_the_damping_ratio(
    index: int, clamped: bool, mass_damping: float, stiffness_damping: float
) -> None:
    """To zeta = mu / (2 w) + lambda w / 2 as dt falls, with first order."""
    modes = eigenmodes(clamped)
    w = float(modes.frequencies[index])
    zeta = mass_damping / (2.0 * w) + stiffness_damping * w / 2.0
    turns, errors = (0.1, 0.05), []
    for turn in turns:
        body = damped(mass_damping, stiffness_damping, clamped, turn / w)
        body.place(velocities=AMPLITUDE * w * modes.shapes[index])
        samples = []
        for _ in range(round(4.0 / turn)):
            body.step()
            samples.append(modes.coordinates(body.positions - MESH.points)[index])
        found = -np.log(abs(recurrence(samples))) / turn
        # the scheme's own; a root is as good as second differences of the samples
        expected = np.log(1.0 + 2.0 * zeta * turn + turn**2) / (2.0 * turn)
        bound = AMPLITUDE / CELL / turn + epsilon("float64") * SIZE[0] / AMPLITUDE / turn**2
        assert found == pytest.approx(expected, abs=bound)
        errors.append(found - zeta)
    # which is zeta + (w dt) (1/2 - zeta^2) (1 + r), r up to 2 zeta w dt / (1 - 2 zeta^2)
    assert zeta < 0.3
    r = 2.5 * zeta * turns[0] + turns[0] ** 2
    assert orders(errors)[0] == pytest.approx(1.0, abs=np.log2((1.0 - 0.5 * r) / (1.0 - r)))


@each_damping
@clamped_or_free
def test_every_step_balances_its_energy(
    mass_damping: float, stiffness_damping: float, clamped: bool
) -> None:
    """Loss: dt v+ (mu M + lambda K) v+, and the scheme's |v+ - v|^2_M / 2 + dt^2 |v+|^2_K / 2.

    None of the three can be negative, so energy never grows.
    """
    step, steps = 5e-3, 40
    body = damped(mass_damping, stiffness_damping, clamped, step)
    K = rest_stiffness(MESH, body.model.scene.character.material)
    M = np.repeat(body.masses, 3)
    rng = np.random.default_rng(11)
    throw = AMPLITUDE / step * rng.uniform(-1.0, 1.0, MESH.points.shape)
    throw[CLAMPED if clamped else []] = 0.0
    body.place(velocities=throw)
    start = 0.5 * float(M @ throw.ravel() ** 2)
    for _ in range(steps):
        x, v = (body.positions - MESH.points).ravel(), body.velocities.ravel()
        body.step()
        y, u = (body.positions - MESH.points).ravel(), body.velocities.ravel()
        gain = 0.5 * (M @ u**2 + y @ K @ y - M @ v**2 - x @ K @ x)
        damping = step * (mass_damping * (M @ u**2) + stiffness_damping * (u @ K @ u))
        scheme = 0.5 * (M @ (u - v) ** 2 + step**2 * (u @ K @ u))
        assert damping >= 0.0 and scheme > 0.0
        assert gain + damping + scheme == pytest.approx(0.0, abs=2.0 * margin(steps) * start)
