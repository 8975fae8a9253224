"""Smoothed tets with known answers: sag, patch test, order, conservation, recovery."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest
from scipy.sparse import csr_array, diags_array
from scipy.sparse.linalg import cg

from tests.support.bodies import EXACT, box, epsilon, numbers, rig
from tests.verification.accuracy import modes_of, orders, rest_stiffness
from tests.verification.manufactured import Manufactured
from tests.verification.smoothed_reference import smoothed_energy, smoothed_stiffness
from warp_softbody.arrays import FloatArray
from warp_softbody.body.material import Material

# Fall of the tip of a beam of 1 x 0.2 x 0.2 m, m: E = 1 MPa, rho = 1000 kg/m^3, g = 9.81 m/s^2. Of
# the same energy density, minimised by Newton's method with scikit-fem's hexahedra of 27 nodes and
# 64 Gauss points (MeshHex, ElementHex2, intorder 6), on 5, 10 and 15 x 2, 4 and 6 x 2, 4 and 6
# cells that shrink towards the clamp and the edges; extrapolated from the three with the order that
# they show, 2.2 to 2.6, by 0.0001 to 0.0006 m.
CONVERGED = {0.3: 0.3446, 0.4: 0.3415, 0.45: 0.3394, 0.49: 0.3372}


@pytest.mark.parametrize("poisson_ratio", CONVERGED)
def test_coarse_beam_sags_within_a_tenth_of_the_converged_value(poisson_ratio: float) -> None:
    """810 tets; linear ones reach 73, 64, 52 and 24 %."""
    mesh = box((15, 3, 3), (1.0, 0.2, 0.2))
    assert len(mesh.tets) == 810
    along = mesh.points[:, 0]
    body = rig(
        mesh,
        material=Material(young_modulus=1e6, poisson_ratio=poisson_ratio, stiffness_damping=0.0),
        fixed=np.flatnonzero(along < 1e-9),
        gravity=(0.0, 0.0, -9.81),
        time_step=0.5,
        precision="float64",
        elements="smoothed",
    )
    tip = along > 1.0 - 1e-9
    sag, last = 0.0, np.inf
    for _ in range(400):
        assert body.step().converged
        last, sag = sag, float((mesh.points - body.positions)[tip, 2].mean())
        if abs(sag - last) < 1e-5 * sag:
            break
    assert abs(sag - last) < 1e-5 * sag
    assert sag == pytest.approx(CONVERGED[poisson_ratio], rel=0.1)


def test_inner_nodes_find_the_affine_displacement() -> None:
    """Patch test: only the surface is given, statics finds the rest."""
    material = Material(young_modulus=1e5, poisson_ratio=0.3, stiffness_damping=0.0)
    mesh = box((3, 3, 3), (0.3, 0.3, 0.3), jitter=0.3)
    affine = np.array([[1.2, 0.1, 0.0], [0.0, 0.9, 0.2], [0.0, 0.0, 1.1]])
    surface = mesh.surface_nodes
    options: dict[str, Any] = {"fixed": surface, "time_step": 1.0, "elements": "smoothed"}
    body = rig(mesh, material=material, **options, **EXACT)
    expected = mesh.points @ affine.T
    start = mesh.points.copy()
    start[surface] = expected[surface]
    body.place(start)
    for _ in range(200):
        body.step()
        body.place(velocities=(0.0, 0.0, 0.0))
    np.testing.assert_allclose(body.positions, expected, atol=1e-9)


def static_errors(cells: int, solution: Manufactured) -> FloatArray:
    """Errors of the static answer of a cube whose faces are held at the displacement.

    The engine's forces are brought to balance the loads by Newton's method with the stiffness at
    rest; strains of 1e-6 leave 1e-6 of the displacement after the first step, 1e-12 after a second.
    """
    mesh = box((cells, cells, cells), (1.0, 1.0, 1.0))
    body = rig(mesh, material=solution.material, time_step=1.0, elements="smoothed", **EXACT)
    free = np.ones_like(mesh.points, dtype=bool)
    free[mesh.surface_nodes] = False
    dofs = np.flatnonzero(free)
    K = csr_array(smoothed_stiffness(mesh, solution.material)[dofs][:, dofs])
    loads = solution.loads(mesh)
    points = mesh.points + np.where(free, 0.0, solution.displacement(mesh.points))
    for _ in range(2):
        body.place(points, (0.0, 0.0, 0.0))
        body.stepper.assemble(body.state)
        residual = (numbers(body.stepper.assembly.momentum) + loads).ravel()[dofs]
        move, failed = cg(K, residual, rtol=1e-8, M=diags_array(1.0 / K.diagonal()))
        assert failed == 0
        points.ravel()[dofs] += move
    return solution.errors(mesh, points)


def test_displacement_converges_under_refinement() -> None:
    """Order 2 in L2 and at the nodes, there up to a logarithm, as of linear tets."""
    material = Material(young_modulus=1e5, poisson_ratio=0.3, stiffness_damping=0.0)
    solution = Manufactured(material, amplitude=1e-6 * np.array([1.0, -0.5, 0.7]))
    sizes = 1.0 / np.array([3, 6, 12])
    errors = np.array([static_errors(round(1.0 / h), solution) for h in sizes])
    # in a layer of one cell at the faces, 6 h of the cube, averages are one-sided: the next term is
    # 6 h of the first
    share = 6.0 * sizes[1:]
    margin = float(np.log2((1.0 + share[0]) / (1.0 + share[1])))
    in_square, in_energy, at_nodes = orders(errors)[1]
    assert in_square == pytest.approx(2.0, abs=margin)
    assert in_energy == pytest.approx(1.0, abs=margin)
    logarithm = float(np.log2(np.log(sizes[2]) / np.log(sizes[1])))
    assert 2.0 - logarithm - margin < at_nodes < 2.0 + margin
    # and it falls with h
    deviation = np.abs(orders(errors)[:, :2] - [2.0, 1.0])
    assert (deviation[1] < deviation[0]).all()


@pytest.mark.parametrize("poisson_ratio", [0.3, 0.49])
def test_every_step_balances_its_energy(poisson_ratio: float) -> None:
    """With the tets' K and the smoothed S: loss |v+ - v|^2_M / 2 + dt^2 (|v+|^2_K - |v+|^2_S / 2).

    K is an upper bound of S, so no term is negative and energy never grows.
    """
    mesh = box((4, 2, 2), (0.4, 0.2, 0.15), jitter=0.2)
    clamped = np.flatnonzero(mesh.points[:, 0] < 1e-9)
    material = Material(young_modulus=1e5, poisson_ratio=poisson_ratio, stiffness_damping=0.0)
    dt, steps, amplitude = 5e-3, 40, 1e-7
    options: dict[str, Any] = {"time_step": dt, "elements": "smoothed"}
    body = rig(mesh, material=material, fixed=clamped, **options, **EXACT)
    K, S = rest_stiffness(mesh, material), smoothed_stiffness(mesh, material)
    M = np.repeat(body.masses, 3)
    throw = amplitude / dt * np.random.default_rng(11).uniform(-1.0, 1.0, mesh.points.shape)
    throw[clamped] = 0.0
    body.place(velocities=throw)
    start = 0.5 * float(M @ throw.ravel() ** 2)
    # turns of the tets by amplitude over cell, and rounding of positions
    margin = amplitude / 0.05 + steps * epsilon("float64") * 0.4 / amplitude
    for _ in range(steps):
        x, v = (body.positions - mesh.points).ravel(), body.velocities.ravel()
        body.step()
        y, u = (body.positions - mesh.points).ravel(), body.velocities.ravel()
        gain = 0.5 * (M @ u**2 + y @ (S @ y) - M @ v**2 - x @ (S @ x))
        loss = 0.5 * (M @ (u - v) ** 2) + dt**2 * (u @ (K @ u) - 0.5 * (u @ (S @ u)))
        assert loss > 0.0
        assert gain + loss == pytest.approx(0.0, abs=2.0 * margin * start)


@pytest.mark.parametrize("poisson_ratio", [0.3, 0.45])
def test_wide_swing_gains_no_energy(poisson_ratio: float) -> None:
    """A beam of 0.6 m thrown at 2 m/s into bending, undamped; its tip moves by 0.2 m."""
    mesh = box((6, 2, 2), (0.6, 0.15, 0.15))
    clamped = np.flatnonzero(mesh.points[:, 0] < 1e-9)
    material = Material(young_modulus=2e4, poisson_ratio=poisson_ratio, stiffness_damping=0.0)
    options: dict[str, Any] = {"time_step": 3e-3, "elements": "smoothed"}
    body = rig(mesh, material=material, fixed=clamped, **options, **EXACT)
    bend = modes_of(mesh, material, 1, clamped).shapes[0]
    body.place(velocities=2.0 * bend / np.abs(bend).max())
    energies, falls = [], []
    for _ in range(130):
        kinetic = 0.5 * float(body.masses @ (body.velocities**2).sum(axis=1))
        energies.append(kinetic + smoothed_energy(mesh, material, body.positions))
        body.step()
        falls.append(np.abs(body.positions - mesh.points).max())
    assert max(falls) > 0.2
    assert (np.diff(energies) < 1e-12 * energies[0]).all()


REST = box((3, 2, 2), (0.3, 0.2, 0.2), jitter=0.2)
MIDDLE = REST.points.mean(axis=0)
STARTS: dict[str, FloatArray] = {
    "stretched": REST.points * [3.0, 1.0, 1.0],
    "mirrored": REST.points * [-1.0, 1.0, 1.0],
    "squashed": MIDDLE + (REST.points - MIDDLE) * [1.0, 1.0, 0.05],
    "random": np.random.default_rng(4).uniform((0.0, 0.0, 0.0), (0.3, 0.2, 0.2), REST.points.shape),
}
STEPS = (1e-3, 1e-2, 0.1, 0.5)


def cases() -> list[Any]:
    """All but one recover; that one has 1.06 % of volume to go after two seconds."""
    slow = pytest.mark.xfail(strict=True, reason="volume 0.01187 of 0.012 m^3 after 2 s")
    return [
        pytest.param(*case, marks=slow if case == ("mirrored", 0.499, 0.01) else ())
        for case in itertools.product(STARTS, (0.3, 0.45, 0.499), STEPS)
    ]


FLUNG = (("mirrored", 0.499, 0.5), ("random", 0.499, 0.1), ("random", 0.499, 0.5))
"""Where a few of the first steps, linearised about a tangle, make the body wider than its energy
would: 0.92, 1.1 and 1.1 m in double precision, 0.92, 1.1 and 1.7 m in single, of 0.9 m."""


@pytest.mark.parametrize(("start", "poisson_ratio", "step"), cases())
def test_body_recovers_from_any_shape(start: str, poisson_ratio: float, step: float) -> None:
    """Clamped at one end, two seconds or a hundred and fifty steps: its volume is back.

    Of a random start near incompressibility only that it stays in bounds is asked: linear tets stay
    inside out there as well.
    """
    material = Material(young_modulus=1e5, poisson_ratio=poisson_ratio, stiffness_damping=0.02)
    clamped = np.flatnonzero(REST.points[:, 0] < 1e-9)
    body = rig(REST, material=material, fixed=clamped, time_step=step, elements="smoothed")
    points = STARTS[start].copy()
    points[clamped] = REST.points[clamped]
    body.place(points)
    # kinetic and elastic energy fall, so no stretch exceeds a few times the largest at the start
    size = 3.0 * max(np.ptp(points, axis=0).max(), np.ptp(REST.points, axis=0).max())
    size *= 2.0 if (start, poisson_ratio, step) in FLUNG else 1.0
    for _ in range(max(150, round(2.0 / step))):
        body.step()
        assert np.ptp(body.positions, axis=0).max() < size
    if start == "random" and poisson_ratio == 0.499:
        return
    corners = body.positions[REST.tets]
    volumes = np.linalg.det(corners[:, 1:] - corners[:, :1]) / 6.0
    assert volumes.sum() == pytest.approx(REST.volumes.sum(), rel=0.01)
    assert volumes.min() > 0.0
