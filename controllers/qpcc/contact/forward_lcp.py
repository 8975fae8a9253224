"""The forward contact problem at given controls, a linear complementarity problem (LCP).

Its unknowns per contact are (f_n, beta_1..beta_m, lam), as in docs/method.md section 3, and it is
solved by Lemke's method. With factors of one the matrix is copositive, so that the method ends in a
solution wherever one exists (Anitescu and Potra 1997); with others that is not known, and where it
fails block Gauss-Seidel over the contacts follows. Ties in the ratio test are broken by a small
fixed perturbation of the offsets. The modes of the answer are then solved exactly, which removes
the perturbation again.
"""

from __future__ import annotations

import math
import time

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.qpcc.contact.mode_qp import ScaledContactQPCC
from warp_softbody.controllers.qpcc.contact.mode_table import LIFT

PERTURBATION = 1e-9
"""Relative size of the offsets' perturbation: above rounding, below every tolerance."""


def lemke(
    matrix: FloatArray, offset: FloatArray, *, max_pivots: int | None = None
) -> FloatArray | None:
    """Find z >= 0 with ``M z + q >= 0`` and ``z'(M z + q) = 0``; None where it ends on a ray.

    Row i of the condensed tableau holds the basic variable ``basic[i]`` as an affine function of
    the nonbasic ones. The variables z have the numbers 0 to n - 1, w = M z + q those from n to
    2n - 1, and the artificial variable 2n.
    """
    n = len(offset)
    if n == 0 or float(np.min(offset)) >= 0.0:
        return np.zeros(n)
    # Multiples of the golden ratio, modulo 1: no two rows stay tied.
    size = float(np.max(np.abs(offset)))
    shift = PERTURBATION * size * (1.0 + np.modf(np.arange(1, n + 1) * 0.6180339887498949)[0])
    tableau = np.empty((n, n + 2))
    tableau[:, :n], tableau[:, n], tableau[:, n + 1] = matrix, 1.0, offset + shift
    basic, nonbasic = np.arange(n, 2 * n), np.r_[np.arange(n), 2 * n]
    row, column = int(np.argmin(tableau[:, n + 1])), n
    for _ in range(max_pivots or 20 * n):
        leaving = int(basic[row])
        _pivot(tableau, row, column)
        basic[row], nonbasic[column] = nonbasic[column], leaving
        if leaving == 2 * n:
            z = np.zeros(2 * n + 1)
            z[basic] = np.maximum(tableau[:, n + 1], 0.0)
            return z[:n]
        entering = leaving - n if leaving >= n else leaving + n
        column = int(np.flatnonzero(nonbasic == entering)[0])
        chosen = _ratio_test(tableau, column, basic == 2 * n)
        if chosen is None:
            return None
        row = chosen
    return None


def _ratio_test(tableau: FloatArray, column: int, artificial: FloatArray) -> int | None:
    """The row that first reaches zero as the column's variable grows, of ties the artificial one.

    None if no row falls.
    """
    slope = tableau[:, column]
    falling = slope < -1e-11
    if not np.any(falling):
        return None
    ratio = np.full(len(slope), np.inf)
    ratio[falling] = np.maximum(tableau[falling, -1], 0.0) / -slope[falling]
    least = float(np.min(ratio))
    near = ratio <= least * (1.0 + 1e-12)
    if np.any(near & (artificial != 0)):
        return int(np.flatnonzero(artificial)[0])
    # Among ties the largest pivot keeps the tableau accurate.
    return int(np.argmin(np.where(near, slope, np.inf)))


def _pivot(tableau: FloatArray, row: int, column: int) -> None:
    """Exchange the basic variable of ``row`` with the nonbasic one of ``column``."""
    pivot = tableau[row, column]
    solved = tableau[row] / -pivot
    solved[column] = 1.0 / pivot
    factor = tableau[:, column].copy()
    tableau[:, column] = 0.0
    tableau += np.outer(factor, solved)
    tableau[row] = solved


def forward_contact(
    scaled: ScaledContactQPCC,
    controls: FloatArray,
    *,
    deadline: float = math.inf,
) -> tuple[tuple[int, ...], FloatArray] | None:
    """Modes and scaled forces (3K,) that obey the contact law at fixed scaled controls.

    None if no method finds a consistent point. Lemke's method, which costs about a QP, is tried in
    any case, block Gauss-Seidel only until the ``deadline`` on ``time.perf_counter``.
    """
    found = by_lemke(scaled, controls)
    if found is None:
        found = block_gauss_seidel(scaled, controls, deadline)
    return found


def by_lemke(
    scaled: ScaledContactQPCC, controls: FloatArray
) -> tuple[tuple[int, ...], FloatArray] | None:
    """The same by Lemke's method alone."""
    k = scaled.problem.contact_count
    matrix, offset = _contact_lcp(scaled, controls)
    solution = lemke(matrix, offset)
    if solution is None:
        return None
    blocks = solution.reshape(k, len(scaled.problem.directions) + 2)
    own = scaled.problem
    force = np.empty((k, 3))
    force[:, 0] = blocks[:, 0]
    force[:, 1:] = (blocks[:, 1:-1] * own.factors) @ own.directions
    points = scaled.points_at(controls, force.reshape(-1))
    violation = scaled.table.violation(points)
    modes = tuple(int(mode) for mode in np.argmin(violation, axis=1))
    exact = _verified(scaled, controls, modes)
    if exact is None and np.max(np.min(violation, axis=1), initial=0.0) <= 1e-7:
        exact = modes, force.reshape(-1)
    return exact


def _verified(
    scaled: ScaledContactQPCC, controls: FloatArray, modes: tuple[int, ...]
) -> tuple[tuple[int, ...], FloatArray] | None:
    """Modes and their forces, if these satisfy the inequalities of the modes."""
    force = scaled.forces_at(modes, controls)
    if force is None:
        return None
    violation = scaled.table.violation(scaled.points_at(controls, force))
    worst = np.max(violation[np.arange(len(modes)), list(modes)], initial=0.0)
    return (modes, force) if worst <= 1e-9 else None


def _contact_lcp(scaled: ScaledContactQPCC, controls: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Matrix and offset of the LCP in scaled units."""
    own = scaled.problem
    k, m = own.contact_count, len(own.directions)
    generate = np.zeros((k, 3, k, m + 2))
    test = np.zeros((k, m + 2, k, 3))
    each = np.arange(k)
    generate[each, 0, each, 0] = test[each, 0, each, 0] = 1.0
    corners = own.directions * own.factors[:, :, None]
    generate[each, 1:, each, 1 : m + 1] = np.swapaxes(corners, 1, 2)
    test[each, 1 : m + 1, each, 1:] = own.directions
    rows = test.reshape(k * (m + 2), 3 * k)
    matrix = rows @ scaled.delassus @ generate.reshape(3 * k, k * (m + 2))
    blocks = matrix.reshape(k, m + 2, k, m + 2)
    blocks[each, 1 : m + 1, each, m + 1] += 1.0
    blocks[each, m + 1, each, 0] += own.friction
    blocks[each, m + 1, each, 1 : m + 1] -= 1.0
    return matrix, rows @ (scaled.free_velocity[:, 0] + scaled.free_velocity[:, 1:] @ controls)


def block_gauss_seidel(
    scaled: ScaledContactQPCC,
    controls: FloatArray,
    deadline: float = math.inf,
    *,
    sweeps: int = 200,
) -> tuple[tuple[int, ...], FloatArray] | None:
    """Block Gauss-Seidel over the contacts, each solved by trying all its modes."""
    k, table = scaled.problem.contact_count, scaled.table
    force, modes = np.zeros((k, 3)), [LIFT] * k
    start = scaled.free_velocity[:, 0] + scaled.free_velocity[:, 1:] @ controls
    for _ in range(sweeps):
        for i in range(k):
            if time.perf_counter() >= deadline:
                return None
            own = slice(3 * i, 3 * i + 3)
            others = start[own] + scaled.delassus[own] @ force.reshape(-1)
            block = scaled.delassus[own, own]
            modes[i], force[i] = _one_contact(scaled, i, block, others - block @ force[i])
        found = _verified(scaled, controls, table.canonical(tuple(modes)))
        if found is not None:
            return found
    return None


def _one_contact(
    scaled: ScaledContactQPCC, contact: int, block: FloatArray, free: FloatArray
) -> tuple[int, FloatArray]:
    """The mode of one contact whose force violates its inequalities least, and that force."""
    table = scaled.table
    best, answer = np.inf, (LIFT, np.zeros(3))
    for mode in np.flatnonzero(table.valid[contact]):
        count = int(table.force_dimensions[contact, mode])
        basis = table.force_basis[contact, mode][:, :count]
        still = table.velocity_constraints[contact, mode][:count]
        amplitude = np.linalg.lstsq(still @ block @ basis, -(still @ free), rcond=None)[0]
        force = basis @ amplitude
        point = np.concatenate([force, free + block @ force])
        violation = -float((table.halfspaces[contact, mode] @ point).min())
        if violation < best:
            best, answer = violation, (int(mode), force)
        if violation <= 1e-12:
            break
    return answer
