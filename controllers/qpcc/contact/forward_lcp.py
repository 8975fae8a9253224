"""The forward contact problem at given controls: Lemke's method on the polyhedral cone.

Unknowns per contact (f_n, beta_1..beta_m, lam) as in docs/method.md section 3. With factors of one
the matrix is copositive, so that Lemke's method ends in a solution wherever one exists (Anitescu
and Potra 1997); with others that is not known, and ``_sweep`` stands behind it.
Ties in the ratio test are broken by a tiny fixed perturbation of the offsets; the modes read off
the answer are then solved exactly, which takes the perturbation out again.
"""

from __future__ import annotations

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.qpcc.contact.force_elimination import ReducedProblem
from warp_softbody.controllers.qpcc.contact.mode_table import LIFT

PERTURBATION = 1e-9
"""Relative size of the offsets' perturbation: above rounding, below every tolerance."""


def lemke(
    matrix: FloatArray, offset: FloatArray, *, max_pivots: int | None = None
) -> FloatArray | None:
    """Find z >= 0 with ``M z + q >= 0`` and ``z'(M z + q) = 0``; None on a secondary ray.

    A condensed tableau: row i holds the basic variable ``basic[i]`` as affine in the nonbasic ones.
    Variables are numbered z: 0..n-1, w: n..2n-1, the artificial one: 2n.
    """
    n = len(offset)
    if n == 0 or float(np.min(offset)) >= 0.0:
        return np.zeros(n)
    # Irregular, fixed steps: no two rows can stay tied.
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
    """The row that first reaches zero as the column's variable grows; the artificial one first."""
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
    reduced: ReducedProblem, controls: FloatArray, guess: tuple[int, ...] | None = None
) -> tuple[tuple[int, ...], FloatArray] | None:
    """Modes and scaled forces (3K,) that obey the contact law at fixed scaled controls.

    ``guess`` is tried first: it costs one small solve. None if no method finds a consistent point.
    """
    k = reduced.problem.contact_count
    if guess is not None:
        found = _verified(reduced, controls, guess)
        if found is not None:
            return found
    matrix, offset = _contact_lcp(reduced, controls)
    solution = lemke(matrix, offset)
    if solution is None:
        return _sweep(reduced, controls)
    blocks = solution.reshape(k, len(reduced.problem.directions) + 2)
    own = reduced.problem
    force = np.empty((k, 3))
    force[:, 0] = blocks[:, 0]
    force[:, 1:] = (blocks[:, 1:-1] * own.factors) @ own.directions
    points = reduced.points_at(controls, force.reshape(-1))
    violation = reduced.table.violation(points)
    modes = tuple(int(mode) for mode in np.argmin(violation, axis=1))
    exact = _verified(reduced, controls, modes)
    if exact is not None:
        return exact
    if np.max(np.min(violation, axis=1), initial=0.0) <= 1e-7:
        return modes, force.reshape(-1)
    return _sweep(reduced, controls)


def _verified(
    reduced: ReducedProblem, controls: FloatArray, modes: tuple[int, ...]
) -> tuple[tuple[int, ...], FloatArray] | None:
    """The forces of given modes, if they satisfy the pieces' inequalities."""
    force = reduced.forces_at(modes, controls)
    if force is None:
        return None
    violation = reduced.table.violation(reduced.points_at(controls, force))
    worst = np.max(violation[np.arange(len(modes)), list(modes)], initial=0.0)
    return (modes, force) if worst <= 1e-9 else None


def _contact_lcp(reduced: ReducedProblem, controls: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The LCP (M, q) in scaled units, unknowns per contact (f_n, beta.., lam)."""
    own = reduced.problem
    k, m = own.contact_count, len(own.directions)
    generate = np.zeros((k, 3, k, m + 2))
    test = np.zeros((k, m + 2, k, 3))
    each = np.arange(k)
    generate[each, 0, each, 0] = test[each, 0, each, 0] = 1.0
    corners = own.directions * own.factors[:, :, None]
    generate[each, 1:, each, 1 : m + 1] = np.swapaxes(corners, 1, 2)
    test[each, 1 : m + 1, each, 1:] = own.directions
    rows = test.reshape(k * (m + 2), 3 * k)
    matrix = rows @ reduced.mobility @ generate.reshape(3 * k, k * (m + 2))
    blocks = matrix.reshape(k, m + 2, k, m + 2)
    blocks[each, 1 : m + 1, each, m + 1] += 1.0
    blocks[each, m + 1, each, 0] += own.friction
    blocks[each, m + 1, each, 1 : m + 1] -= 1.0
    return matrix, rows @ (reduced.free[:, 0] + reduced.free[:, 1:] @ controls)


def _sweep(
    reduced: ReducedProblem, controls: FloatArray, *, sweeps: int = 200
) -> tuple[tuple[int, ...], FloatArray] | None:
    """Block Gauss-Seidel over contacts, each solved by trying its pieces; for Lemke's failures."""
    k, table = reduced.problem.contact_count, reduced.table
    force, modes = np.zeros((k, 3)), [LIFT] * k
    start = reduced.free[:, 0] + reduced.free[:, 1:] @ controls
    for _ in range(sweeps):
        for i in range(k):
            own = slice(3 * i, 3 * i + 3)
            others = start[own] + reduced.mobility[own] @ force.reshape(-1)
            block = reduced.mobility[own, own]
            modes[i], force[i] = _one_contact(reduced, i, block, others - block @ force[i])
        found = _verified(reduced, controls, table.canonical(tuple(modes)))
        if found is not None:
            return found
    return None


def _one_contact(
    reduced: ReducedProblem, contact: int, block: FloatArray, free: FloatArray
) -> tuple[int, FloatArray]:
    """The piece of one contact that its local force satisfies best, and that force."""
    table = reduced.table
    best, answer = np.inf, (LIFT, np.zeros(3))
    for mode in np.flatnonzero(table.valid[contact]):
        count = int(table.count[contact, mode])
        basis = table.basis[contact, mode][:, :count]
        still = table.still[contact, mode][:count]
        amplitude = np.linalg.lstsq(still @ block @ basis, -(still @ free), rcond=None)[0]
        force = basis @ amplitude
        point = np.concatenate([force, free + block @ force])
        violation = -float((table.walls[contact, mode] @ point).min())
        if violation < best:
            best, answer = violation, (int(mode), force)
        if violation <= 1e-12:
            break
    return answer
