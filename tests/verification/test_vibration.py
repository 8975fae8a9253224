"""A vibrating cantilever: its period against eigenvalues and against beam theory.

Implicit Euler turns a mode of frequency w by atan(w dt) a step and shrinks it by
sqrt(1 + (w dt)^2), so both follow from w, and w from both.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq

from tests.support.bodies import box, epsilon, rig
from tests.verification.accuracy import Modes, modes_of, orders, recurrence
from warp_softbody.arrays import FloatArray
from warp_softbody.body.material import Material
from warp_softbody.body.mesh import TetMesh

LENGTH, SIDE = 0.5, 0.1
SPEED = 1e-7
# without lateral contraction a clamped end is what beam theory takes it for
MATERIAL = Material(young_modulus=1e6, poisson_ratio=0.0, stiffness_damping=0.0)


def cantilever(cells: int) -> TetMesh:
    return box((5 * cells, cells, cells), (LENGTH, SIDE, SIDE))


@cache
def eigenmodes(cells: int) -> Modes:
    """Of first bending in the two planes that the tets' diagonals single out."""
    mesh = cantilever(cells)
    return modes_of(mesh, MATERIAL, 2, clamped(mesh))


def clamped(mesh: TetMesh) -> npt.NDArray[np.intp]:
    return np.flatnonzero(mesh.points[:, 0] < 1e-9)


@cache
def vibration(cells: int) -> tuple[tuple[complex, ...], float]:
    """Roots z of the two modes and the time step; thrown into a parabola, which has all modes."""
    mesh, modes = cantilever(cells), eigenmodes(cells)
    step = 0.25 / float(modes.frequencies[0])
    options: dict[str, Any] = {"time_step": step, "precision": "float64", "tolerance": 1e-12}
    body = rig(mesh, material=MATERIAL, fixed=clamped(mesh), **options)
    body.place(velocities=SPEED * np.outer((mesh.points[:, 0] / LENGTH) ** 2, [0.0, 1.0, 0.3]))
    samples = []
    for _ in range(25):
        assert body.step().converged
        samples.append(modes.coordinates(body.positions - mesh.points))
    return tuple(recurrence(sample) for sample in np.transpose(samples)), step


def measured(cells: int) -> FloatArray:
    """Frequencies of the two modes in the engine, rad/s."""
    roots, step = vibration(cells)
    return np.array([np.tan(np.angle(z)) / step for z in roots])


@pytest.mark.parametrize("cells", [2, 4, 8])
def test_period_and_decay_are_those_of_the_eigenvalue(cells: int) -> None:
    roots, step = vibration(cells)
    expected = eigenmodes(cells).frequencies
    # The tets turn by up to amplitude / cell. Positions are rounded to an eps of the length, and a
    # second difference, of which the roots are made, is (w dt)^2 of the amplitude.
    amplitude = SPEED / expected[0]
    rounding = epsilon("float64") * LENGTH / amplitude / (expected[0] * step) ** 2
    margin = float(amplitude * cells / SIDE + rounding)
    assert margin < 1e-6
    np.testing.assert_allclose(measured(cells), expected, rtol=margin)
    np.testing.assert_allclose(np.abs(roots), 1.0 / np.hypot(1.0, expected * step), rtol=margin)


def timoshenko_frequency() -> float:
    """Lowest frequency of a clamped beam with shear (5/6 of the area) and rotary inertia, rad/s."""
    area, inertia = SIDE**2, SIDE**4 / 12.0
    E, rho = MATERIAL.young_modulus, MATERIAL.density
    shear = 5.0 / 6.0 * MATERIAL.lame_mu * area

    def end_loads(w: float) -> float:
        # deflection, turn, moment and shear force along the beam; both loads vanish at the tip
        rates = np.zeros((4, 4))
        rates[0, 1], rates[0, 3], rates[1, 2] = 1.0, 1.0 / shear, 1.0 / (E * inertia)
        rates[2, 1], rates[2, 3] = -rho * inertia * w**2, -1.0
        rates[3, 0] = -rho * area * w**2
        return float(np.linalg.det(expm(rates * LENGTH)[2:, 2:]))

    euler_bernoulli = 1.8751040687**2 * np.sqrt(E * inertia / (rho * area)) / LENGTH**2
    # slender enough for shear and rotary inertia to lower it by a few percent only
    return float(brentq(end_loads, 0.9 * euler_bernoulli, euler_bernoulli))


def test_period_converges_to_that_of_a_beam() -> None:
    """Order 2 in the mesh, in both planes, to one frequency."""
    squares = np.array([measured(cells) ** 2 for cells in (2, 4, 8)])
    limit = (4.0 * squares[2] - squares[1]) / 3.0
    coarser = (4.0 * squares[1] - squares[0]) / 3.0
    errors = squares / limit - 1.0
    assert (errors > 0.0).all()
    # the error is e = C h^2 and a next term of its square, seen where e is that of the middle mesh
    margin = float(np.log2(1.0 + errors[1].max()))
    differences = [squares[0] - squares[1], squares[1] - squares[2]]
    np.testing.assert_allclose(orders(differences), 2.0, atol=margin)
    # extrapolation leaves order 4, a fifteenth of what it changes; the theory leaves the clamped
    # end, whose length is one side and whose share of the work is that of shear, (side / length)^2
    beam = timoshenko_frequency() ** 2
    left = np.abs(coarser - limit) / 15.0 / beam + (SIDE / LENGTH) ** 3
    assert (np.abs(limit / beam - 1.0) < left).all()
    assert (left < 0.01).all()
