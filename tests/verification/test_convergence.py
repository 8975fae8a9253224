"""Orders of the method: two in the mesh (one in energy), one in the time step."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.support.bodies import EXACT, Rig, box, given_back, rig
from tests.verification import reference
from tests.verification.accuracy import (
    damping_forces,
    highest_frequency,
    modes_of,
    next_term,
    order_margin,
    orders,
)
from tests.verification.manufactured import WAVE_NUMBER, Manufactured
from warp_softbody.arrays import FloatArray
from warp_softbody.body.material import Material
from warp_softbody.engine.options import Tangent

STATIC = Material(young_modulus=1e5, poisson_ratio=0.3, stiffness_damping=0.0)


def static_errors(cells: int, solution: Manufactured) -> FloatArray:
    """Errors of the static answer of a cube whose faces are held at the displacement.

    One step of 1000 s is a Newton step, M being 1e-8 of dt^2 K; the second removes what the strain
    of 1e-6 leaves of the first, which is 1e-6 of the displacement.
    """
    mesh = box((cells, cells, cells), (1.0, 1.0, 1.0))
    faces = mesh.surface_nodes
    options: dict[str, Any] = {"time_step": 1e3, "precision": "float64", "tolerance": 1e-10}
    body = rig(mesh, material=solution.material, fixed=faces, **options)
    start = mesh.points.copy()
    start[faces] += solution.displacement(mesh.points[faces])
    body.place(start)
    body.push(solution.loads(mesh))
    for _ in range(2):
        assert body.step().converged
        body.place(velocities=(0.0, 0.0, 0.0))
    return solution.errors(mesh, body.positions)


def test_static_displacement_converges_under_refinement() -> None:
    """Linear tets: order 2 in L2, 1 in energy, 2 up to a logarithm at the nodes."""
    solution = Manufactured(STATIC, amplitude=1e-6 * np.array([1.0, -0.5, 0.7]))
    sizes = 1.0 / np.array([4, 8, 16])
    errors = np.array([static_errors(round(1.0 / h), solution) for h in sizes])
    in_square, in_energy, at_nodes = orders(errors[1:])[0]
    # the error is C h^p (1 + c h^2) with c at most the square of the wave number
    square = (WAVE_NUMBER * sizes[1:]) ** 2
    margin = float(np.log2((1.0 + square[0]) / (1.0 + square[1])))
    assert in_square == pytest.approx(2.0, abs=margin)
    assert in_energy == pytest.approx(1.0, abs=margin)
    # in the maximum norm the bound is h^2 |log h|
    logarithm = float(np.log2(np.log(sizes[2]) / np.log(sizes[1])))
    assert 2.0 - logarithm - margin < at_nodes < 2.0 + margin
    # and the next order shows: the deviation from the order falls from one pair to the next
    deviation = np.abs(orders(errors)[:, :2] - [2.0, 1.0])
    assert (deviation[1] < deviation[0]).all()


CASES: list[tuple[Tangent, float, float]] = [
    ("conserving", 0.0, 0.0),
    ("conserving", 0.01, 0.0),
    ("conserving", 0.0, 2.0),
    ("conserving", 0.01, 2.0),
    ("warped", 0.01, 2.0),
    ("exact", 0.01, 2.0),
]
DURATION = 0.2
COARSEST = 400


def swinging_beam(material: Material, steps: int, tangent: Tangent) -> Rig:
    """A clamped beam of 0.6 m thrown at 1 m/s into its two lowest modes; the tip moves by 0.2 m."""
    mesh = box((4, 1, 1), (0.6, 0.15, 0.15))
    clamped = np.flatnonzero(mesh.points[:, 0] < 1e-9)
    options = {"time_step": DURATION / steps, "tangent": tangent, **EXACT}
    body = rig(mesh, material=material, fixed=clamped, **options)
    throw = modes_of(mesh, material, 2, clamped).shapes
    body.place(velocities=bend(throw, 1.0))
    return body


def spinning_bar(material: Material, steps: int, tangent: Tangent) -> Rig:
    """A free bar of 0.4 m that turns by two radians while it bends and its spin stretches it."""
    mesh = box((4, 1, 1), (0.4, 0.15, 0.15))
    options = {"time_step": DURATION / steps, "tangent": tangent, **EXACT}
    body = rig(mesh, material=material, **options)
    arms = mesh.points - body.center
    throw = modes_of(mesh, material, 2, skip=6).shapes
    body.place(arms, bend(throw, 0.5) + np.cross([2.0, 4.0, 9.0], arms))
    return body


def bend(shapes: FloatArray, speed: float) -> FloatArray:
    """Velocities of two modes together, at most ``speed``."""
    field = shapes[0] + 0.5 * shapes[1]
    return np.asarray(speed * field / np.abs(field).max())


def exact_motion(body: Rig, tangent: Tangent) -> FloatArray:
    """Positions and velocities after DURATION, (2, n, 3), by a Runge-Kutta method of order 8."""
    character = body.model.scene.character
    mesh, material = character.mesh, character.material
    free = np.ones((len(mesh.points), 1))
    free[character.fixed] = 0.0

    def rate(_: float, state: FloatArray) -> FloatArray:
        x, v = state.reshape(2, -1, 3)
        force = reference.elastic_forces(mesh, material, x)
        if material.stiffness_damping > 0.0:
            damping = damping_forces(mesh, material, tangent, x, v)
            force += damping if len(character.fixed) else torque_free(body.masses, x, damping)
        acceleration = force / body.masses[:, None] - material.mass_damping * v
        return np.concatenate([v, free * acceleration]).ravel()

    start = np.concatenate([body.positions, body.velocities]).ravel()
    run = solve_ivp(rate, (0.0, DURATION), start, method="DOP853", rtol=1e-7, atol=1e-8)
    return np.asarray(run.y[:, -1].reshape(2, -1, 3))


def torque_free(masses: FloatArray, x: FloatArray, forces: FloatArray) -> FloatArray:
    """Forces (n, 3) and the turn that a step gives back where they would change a free spin."""
    resting = np.zeros_like(forces)
    return np.asarray(forces - masses[:, None] * given_back(masses, x, resting, forces))


@pytest.mark.parametrize(("tangent", "stiffness_damping", "mass_damping"), CASES)
@pytest.mark.parametrize("scene", [swinging_beam, spinning_bar], ids=["beam", "spinning"])
def test_motion_converges_at_first_order(
    scene: Callable[[Material, int, Tangent], Rig],
    tangent: Tangent,
    stiffness_damping: float,
    mass_damping: float,
) -> None:
    """To the motion of the same tets by another integrator and another implementation."""
    material = Material(
        young_modulus=5e3 if scene is swinging_beam else 1e4,
        poisson_ratio=0.3,
        stiffness_damping=stiffness_damping,
        mass_damping=mass_damping,
    )
    errors: list[Any] = []
    ends: list[FloatArray] = []
    for steps in COARSEST * 2 ** np.arange(3):
        body = scene(material, int(steps), tangent)
        if not ends:
            exact = exact_motion(body, tangent)
        body.step(int(steps))
        ends.append(np.array([body.positions, body.velocities]))
        errors.append(np.linalg.norm(ends[-1] - exact, axis=(1, 2)))
    highest = highest_frequency(body.model.scene.character.mesh, material)
    span = (highest, DURATION, DURATION / COARSEST / 2)
    np.testing.assert_allclose(orders(errors)[-1], 1.0, atol=order_margin(*span))
    # extrapolation to dt = 0 leaves half the next term
    left = np.linalg.norm(2.0 * ends[2] - ends[1] - exact, axis=(1, 2))
    assert (left < next_term(*span) * errors[1]).all()
