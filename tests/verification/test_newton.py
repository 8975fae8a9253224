"""Newton iterations of a step: the implicit Euler equation they solve, their order, contact."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.sparse.linalg import spsolve

from tests.support.bodies import (
    EXACT,
    Rig,
    box,
    crumpled,
    epsilon,
    given_back,
    muscular_bar,
    numbers,
    rig,
)
from tests.verification import reference
from tests.verification.accuracy import rest_stiffness
from tests.verification.implicit_euler import elastic_forces, residual, rounding, step_matrix
from tests.verification.smoothed_reference import smoothed_stiffness
from warp_softbody.body.material import Material
from warp_softbody.body.mesh import TetMesh
from warp_softbody.engine.options import TANGENTS, Elements, Tangent
from warp_softbody.world.ground import Plane

MESH = box((2, 2, 3), (0.2, 0.3, 0.4), jitter=0.2)
UNDAMPED = Material(young_modulus=1e5, poisson_ratio=0.4, stiffness_damping=0.0, mass_damping=0.7)
DAMPED = Material(young_modulus=1e5, poisson_ratio=0.3, stiffness_damping=0.01, mass_damping=0.7)
GRAVITY = (1.0, 2.0, -9.81)
DIFFERENCES = 1e-9
"""Share of K that a central difference of step 1e-5 may miss: its square, and eps over it."""

each_tangent = pytest.mark.parametrize("tangent", TANGENTS)


def in_tension(iterations: int, material: Material = UNDAMPED, **options: Any) -> Rig:
    """A body stretched by 1.3, shaken, still growing, pushed, after one step."""
    rng = np.random.default_rng(1)
    options = {"time_step": 0.01, "gravity": GRAVITY, **options}
    body = rig(MESH, material=material, newton_iterations=iterations, **options, **EXACT)
    points = 1.3 * crumpled(MESH, amount=0.05)
    velocities = rng.uniform(-1.0, 1.0, points.shape) + 5.0 * points
    fixed = body.model.fixed
    velocities[fixed] = 0.0
    body.place(points, velocities)
    body.push(rng.uniform(-1.0, 1.0, points.shape))
    assert body.step().converged
    # the state before the step is the other one now
    assert (numbers(body.after.velocities) == velocities).all()
    return body


def test_exact_tangent_converges_quadratically() -> None:
    """Each reduction is the square of the one before, times what the direction changes (ten)."""
    bodies = [in_tension(count, tangent="exact") for count in (1, 2, 3, 4, 8)]
    left = [float(np.linalg.norm(residual(body))) for body in bodies]
    floor = rounding(bodies[-1])
    reductions = np.array(left[1:4]) / left[:3]
    assert reductions[0] < 0.1
    assert reductions[1] < 10.0 * reductions[0] ** 2
    assert left[3] < max(floor, 10.0 * reductions[1] ** 2 * left[2])
    # three more lose nothing
    assert left[3] < floor and left[4] < floor


@pytest.mark.parametrize(
    ("elements", "tangent"),
    [("linear", "warped"), ("linear", "conserving"), ("smoothed", "warped")],
)
def test_other_matrices_converge_linearly(elements: Elements, tangent: Tangent) -> None:
    """At the rate of ``M~^-1 dt^2 (K - H)``, H the energy's Hessian, in the norm of M~^-1.

    Symmetric in that norm, it shrinks no residual by a larger factor, and none by less than before.
    """
    options: dict[str, Any] = {"elements": elements, "tangent": tangent}
    limit = in_tension(150, **options)
    assert np.linalg.norm(residual(limit)) < rounding(limit)
    step, dt = step_matrix(limit), limit.model.options.time_step
    moves = 1e-6 * np.eye(len(step)).reshape(-1, *MESH.points.shape)
    ends = [
        [elastic_forces(limit, limit.positions + s * move) for s in (-1.0, 1.0)] for move in moves
    ]
    H = np.array([(behind - ahead).ravel() for behind, ahead in ends]) / 2e-6
    implicit = (1.0 + dt * UNDAMPED.mass_damping) * np.diag(np.repeat(limit.masses, 3))
    rate = float(np.abs(eigh(step - implicit - dt**2 * 0.5 * (H + H.T), step)[0]).max())
    assert rate < 1.0
    gaps = [residual(in_tension(count, **options)).ravel() for count in (4, 5, 6, 7, 8)]
    sizes = np.sqrt([gap @ np.linalg.solve(step, gap) for gap in gaps])
    ratios = sizes[1:] / sizes[:-1]
    # the matrices of these iterates are off by their distance over the smallest tet's height
    height = 1.0 / np.linalg.norm(reference.rest_gradients(MESH), axis=2).max()
    positions = in_tension(4, **options).positions
    off = 4.0 * float(np.abs(positions - limit.positions).max()) / height
    assert off < 0.1
    assert (ratios < rate * (1.0 + off)).all()
    assert (np.diff(ratios) > -off * ratios[:-1]).all()


def test_fixed_point_does_not_depend_on_the_tangent() -> None:
    velocities = [in_tension(60, tangent=tangent).velocities for tangent in TANGENTS]
    for other in velocities[1:]:
        np.testing.assert_allclose(other, velocities[0], atol=1e-10 * np.abs(other).max())


@each_tangent
@pytest.mark.parametrize("clamped", [False, True], ids=["free", "clamped"])
def test_damped_step_solves_the_implicit_euler_equation(tangent: Tangent, clamped: bool) -> None:
    """With pushes, gravity and both dampings; the damping's K is that of the end of the step."""
    fixed = np.flatnonzero(MESH.points[:, 2] < 1e-9) if clamped else ()
    body = in_tension(60, DAMPED, tangent=tangent, fixed=fixed)
    np.testing.assert_array_equal(body.velocities[body.model.fixed], 0.0)
    assert np.linalg.norm(residual(body)) < rounding(body, DIFFERENCES)


def test_muscles_stay_explicit() -> None:
    """Their forces are those of the state before the step, whatever the iteration."""
    character = muscular_bar(DAMPED)
    body = rig(character, newton_iterations=60, time_step=0.01, tangent="exact", **EXACT)
    body.place(crumpled(character.mesh, amount=0.05))
    lengths = body.activate(0.8)
    assert body.step().converged
    before = numbers(body.after.positions)
    rest = body.model.muscles.rest_lengths
    reach = np.maximum(reference.segment_lengths(character, before) - lengths, 0.0)
    weights = np.zeros((len(character.mesh.tets), len(rest)))
    layout = body.model.muscles
    weights[layout.pair_tet, layout.pair_segment] = layout.pair_weight
    pull = reference.muscle_forces(character, before, 2e5 / rest * reach, weights)
    assert np.abs(pull).max() > 1.0
    assert np.linalg.norm(residual(body, pull)) < rounding(body, DIFFERENCES)


@pytest.mark.parametrize("elements", ["linear", "smoothed"])
def test_one_iteration_is_the_linearly_implicit_step(elements: Elements) -> None:
    """``M~ v+ = M v + dt f(x)`` and the turn given back, and bit for bit what no option gives."""
    body = in_tension(1, elements=elements)
    dt, before = 0.01, numbers(body.after.positions)
    force = elastic_forces(body, before) + numbers(body.control.external_forces)
    force += body.masses[:, None] * np.array(GRAVITY)
    known = body.masses[:, None] * numbers(body.after.velocities) + dt * force
    body.stepper.assemble(body.after)
    step = reference.block_matrix(body.model, numbers(body.stepper.assembly.values))
    alone = np.linalg.solve(step, known.ravel()).reshape(-1, 3)
    damped = (1.0 + dt * UNDAMPED.mass_damping) * body.masses
    expected = given_back(damped, before, np.asarray(alone, dtype=np.float64), known)
    gap = np.linalg.norm(step @ (body.velocities - expected).ravel())
    assert gap < rounding(body)
    plain = rig(MESH, material=UNDAMPED, time_step=dt, elements=elements, gravity=GRAVITY, **EXACT)
    plain.place(before, numbers(body.after.velocities))
    plain.push(numbers(body.control.external_forces))
    plain.step()
    np.testing.assert_array_equal(plain.velocities, body.velocities)
    np.testing.assert_array_equal(plain.positions, body.positions)


def test_statistics_count_every_iteration() -> None:
    """A tight solve takes conjugate gradients anew in every iteration."""
    found = [in_tension(count).statistics for count in (1, 2, 3, 4)]
    assert [s.passes for s in found if s is not None] == [1, 2, 3, 4]
    iterations = [s.iterations for s in found if s is not None]
    assert (np.diff(iterations) > 0).all()


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("elements", ["linear", "smoothed"])
@pytest.mark.parametrize("iterations", [2, 4])
def test_dropped_block_lands_and_never_sinks(
    iterations: int, elements: Elements, precision: str
) -> None:
    """Thrown down and sideways; a settled step ends with every gap closed or open."""
    mesh = box((3, 3, 3), (0.2, 0.2, 0.2), (0.0, 0.0, 0.05))
    material = Material(young_modulus=1e5, poisson_ratio=0.4, stiffness_damping=0.01)
    scene: dict[str, Any] = {"ground": Plane(friction=0.5), "gravity": (0.0, 0.0, -9.81)}
    options: dict[str, Any] = {"time_step": 0.01, "precision": precision, "elements": elements}
    body = rig(mesh, material=material, newton_iterations=iterations, **scene, **options)
    body.place(velocities=(0.5, 0.2, -1.0))
    weight = body.masses.sum() * 9.81 * 0.01
    # speeds off by 1e-5 m/s count as closed, and positions are rounded
    sunk = 1e-5 * 0.01 + 8 * epsilon("float32") * 0.25
    settled = 0
    for _ in range(120):
        statistics = body.step()
        assert statistics.converged and statistics.finite
        assert iterations <= statistics.passes <= 12 * iterations
        if statistics.contact_converged:
            settled += 1
            assert body.positions[:, 2].min() > -sunk
    assert settled > 0.9 * 120
    assert statistics.touching == 16
    # the impulses of all iterations are the same step's: at rest the last carries the weight
    impulse = numbers(body.contacts.impulses).sum(axis=0)
    np.testing.assert_allclose(impulse, [0.0, 0.0, weight], atol=1e-2 * weight)


@pytest.mark.parametrize("friction", [0.0, 0.5])
@each_tangent
def test_step_with_contact_solves_its_equation(tangent: Tangent, friction: float) -> None:
    """Thrown on the ground and along it: what the forces at x+ leave is the contact's impulses."""
    mesh = box((3, 3, 3))
    scene: dict[str, Any] = {"ground": Plane(friction=friction), "gravity": (0.0, 0.0, -9.81)}
    options: dict[str, Any] = {"time_step": 0.01, "tangent": tangent, "newton_iterations": 40}
    body = rig(mesh, material=UNDAMPED, **scene, **options, **EXACT)
    body.place(velocities=(0.5, 0.2, -1.0))
    assert body.step().contact_converged
    impulses = np.zeros_like(mesh.points)
    impulses[mesh.surface_nodes] = numbers(body.contacts.impulses)
    assert impulses[:, 2].sum() > 1.0 and impulses[:, 2].min() >= 0.0
    np.testing.assert_array_equal(impulses[body.positions[:, 2] > 1e-6], 0.0)
    assert np.linalg.norm(residual(body) - impulses) < rounding(body)


def first_maximum(mesh: TetMesh, material: Material, iterations: int) -> float:
    """Of the fall of a beam's tip, let go under gravity, m."""
    along = mesh.points[:, 0]
    fixed, tip = np.flatnonzero(along < 1e-9), along > 1.0 - 1e-9
    options: dict[str, Any] = {"time_step": 0.01, "elements": "smoothed", "fixed": fixed}
    gravity = (0.0, 0.0, -9.81)
    body = rig(mesh, material=material, gravity=gravity, newton_iterations=iterations, **options)
    falls = [0.0, 1e-9]
    while falls[-1] > falls[-2] and len(falls) < 100:
        assert body.step().converged
        falls.append(float((mesh.points - body.positions)[tip, 2].mean()))
    return falls[-2]


def test_swing_comes_nearer_to_that_of_implicit_euler() -> None:
    """Near incompressibility the tets' matrix is several times too stiff for smoothed bending.

    An iteration closes at least the share of the gap that the tets' deflection is of the smoothed.
    """
    mesh = box((10, 2, 2), (1.0, 0.2, 0.2))
    material = Material(young_modulus=1e6, poisson_ratio=0.49, stiffness_damping=0.0)
    free = np.flatnonzero(np.repeat(mesh.points[:, 0] > 1e-9, 3))
    load = np.tile([0.0, 0.0, 1.0], len(mesh.points))[free]
    sags = [
        load @ spsolve(K[free][:, free], load)
        for K in (rest_stiffness(mesh, material), smoothed_stiffness(mesh, material).tocsc())
    ]
    limit = first_maximum(mesh, material, 20)
    gaps = limit - np.array([first_maximum(mesh, material, count) for count in (1, 2, 3)])
    assert (gaps > 0.0).all()
    assert (gaps[1:] < (1.0 - sags[0] / sags[1]) * gaps[:-1]).all()
