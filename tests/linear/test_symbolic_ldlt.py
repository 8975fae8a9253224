"""The factor and the solvers, against dense NumPy."""

from __future__ import annotations

import tracemalloc
from typing import Any

import numpy as np
import pytest

from tests.linear.matrices import (
    FIXED,
    NORMAL,
    STIFF,
    assembled,
    factor_of,
    freedom_of,
    preconditioned,
)
from tests.support.bodies import EXACT, box, crumpled, epsilon, given_back, numbers, rig, turn
from tests.verification import reference
from warp_softbody.engine.options import PRECONDITIONERS, Precision
from warp_softbody.linear.block_sparsity import build_topology
from warp_softbody.linear.preconditioner import WarpedFactor
from warp_softbody.linear.symbolic_ldlt import build_elimination


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("fixed", [(), FIXED])
def test_factor_solves_the_matrix_it_was_made_of(fixed: Any, precision: Precision) -> None:
    """|P A - I| is bounded by the condition number times eps."""
    body, matrix = assembled(box((2, 2, 3), jitter=0.2), fixed, precision=precision)
    inverse = preconditioned(body, factor_of(body), np.eye(len(matrix)))
    bound = 8 * np.linalg.cond(matrix) * epsilon(precision)
    assert bound < 0.1
    np.testing.assert_allclose(inverse @ matrix, np.eye(len(matrix)), atol=bound)


def test_factor_multiplies_out_to_the_matrix() -> None:
    """L D L^T in elimination order, fixed nodes as identity."""
    body, matrix = assembled(box((2, 2, 3), jitter=0.2), FIXED, precision="float64")
    e, n = body.model.system.elimination, body.model.node_count
    factor = factor_of(body)
    assert isinstance(factor, WarpedFactor)
    lower = np.zeros((n, 3, n, 3))
    rows = np.repeat(np.arange(n), np.diff(e.row_start))
    lower[rows, :, e.column, :] = numbers(factor.factor.lower)
    lower[np.arange(n), :, np.arange(n), :] = np.eye(3)
    pivots = np.zeros((n, 3, n, 3))
    pivots[np.arange(n), :, np.arange(n), :] = np.linalg.inv(numbers(factor.factor.pivot_inverse))
    L, D = lower.reshape(3 * n, 3 * n), pivots.reshape(3 * n, 3 * n)
    dofs = (3 * e.order[:, None] + np.arange(3)).ravel()
    expected = matrix[np.ix_(dofs, dofs)]
    np.testing.assert_allclose(L @ D @ L.T, expected, atol=1e-12 * np.abs(expected).max())


def test_order_is_a_permutation_and_fill_is_sparse() -> None:
    mesh = box((5, 5, 10), (0.5, 0.5, 1.0))
    count = len(mesh.points)
    e = build_elimination(build_topology(mesh.tets, count), np.zeros(count, dtype=bool))
    assert sorted(e.order) == list(range(len(mesh.points)))
    assert (e.column < np.repeat(np.arange(len(e.order)), np.diff(e.row_start))).all()
    # a band ordering of this grid would fill 396 nodes times a band of 36
    assert len(e.column) < 396 * 36


def test_factor_knows_what_contact_leaves_free() -> None:
    """On held, sliding and free nodes it is the inverse of S (A + G) S on the free velocities."""
    mesh = box((2, 2, 3), jitter=0.2)
    body, matrix = assembled(mesh, precision="float64")
    rng = np.random.default_rng(3)
    n = len(mesh.points)
    kinds = rng.integers(0, 3, n)
    roots = rng.standard_normal((n, 3, 3))
    slip = np.where((kinds == 1)[:, None, None], 50.0 * roots @ roots.transpose(0, 2, 1), 0.0)
    for node in range(n):
        span = slice(3 * node, 3 * node + 3)
        matrix[span, span] += slip[node]
    kept = [np.eye(3), np.linalg.svd(NORMAL[None])[2][1:], np.zeros((0, 3))]
    basis = np.concatenate(
        [np.kron(np.eye(n)[node], kept[kinds[node]]) for node in range(n) if kinds[node] < 2]
    ).T
    inverse = preconditioned(body, factor_of(body, kinds, slip), basis)
    expected = np.linalg.inv(basis.T @ matrix @ basis)
    np.testing.assert_allclose(basis.T @ inverse, expected, atol=1e-10 * np.abs(expected).max())


def test_kept_factor_turns_with_the_body() -> None:
    """After a rigid turn the old factor, warped, is still exact for the new matrix."""
    mesh = box((2, 2, 3), jitter=0.2)
    body, _ = assembled(mesh, precision="float64")
    factor = factor_of(body)
    body.place(body.positions @ turn((1.0, 0.3, -2.0), 1.9).T)
    body.stepper.assemble(body.state)
    factor.prepare(freedom_of(body))
    matrix = reference.step_matrix(body.model, body.positions)
    inverse = preconditioned(body, factor, np.eye(len(matrix)))
    np.testing.assert_allclose(inverse @ matrix, np.eye(len(matrix)), atol=1e-9)


@pytest.mark.parametrize("fixed", [(), FIXED])
@pytest.mark.parametrize("preconditioner", ["factor", "two_level"])
def test_conjugate_gradients_equal_a_dense_solve(fixed: Any, preconditioner: str) -> None:
    """With the whole factor, and with two levels as for a large mesh."""
    mesh = box((2, 2, 3), jitter=0.2)
    body, matrix = assembled(mesh, fixed, preconditioner=preconditioner, **EXACT)
    rng = np.random.default_rng(1)
    # neither turns the body, so that the step takes the straight path
    masses, none = body.masses, np.zeros(mesh.points.shape)
    velocities = rng.standard_normal(mesh.points.shape)
    velocities = given_back(masses, body.positions, velocities, none)
    velocities[list(fixed)] = 0.0
    rates = 100.0 * rng.standard_normal(mesh.points.shape)
    pushes = masses[:, None] * given_back(masses, body.positions, rates, none)
    body.place(velocities=velocities)
    body.push(pushes)
    right = body.masses[:, None] * velocities + 0.01 * (
        pushes + reference.elastic_forces(mesh, STIFF, body.positions)
    )
    right[list(fixed)] = 0.0
    before = body.positions
    statistics = body.step()
    assert statistics.converged
    expected = np.linalg.solve(matrix, right.ravel()).reshape(-1, 3)
    if not fixed:
        expected = given_back(body.masses, before, np.asarray(expected, float), right)
    # |error| <= tolerance times the condition number
    bound = 1e-13 * np.linalg.cond(matrix) * np.abs(expected).max()
    np.testing.assert_allclose(body.velocities, expected, atol=10 * bound)


@pytest.mark.parametrize("cells", [(2, 2, 3), (11, 11, 8)])
def test_the_preconditioner_is_the_one_asked_for(cells: tuple[int, int, int]) -> None:
    """Of 36 nodes and of 1,296; automatic is the factor for few nodes alone."""
    aggregated = {
        choice: rig(box(cells), preconditioner=choice).model.system.coarse is not None
        for choice in PRECONDITIONERS
    }
    assert aggregated == {"auto": cells[0] > 2, "factor": False, "two_level": True}


def test_unconverged_solve_is_reported() -> None:
    mesh = box((2, 2, 3), jitter=0.2)
    body = rig(mesh, material=STIFF, max_iterations=2, preconditioner="two_level", **EXACT)
    body.place(crumpled(mesh))
    assert not body.step().converged


def test_a_pattern_takes_memory_by_blocks_not_by_updates() -> None:
    mesh = box((8, 8, 8))
    topology = build_topology(mesh.tets, len(mesh.points))
    tracemalloc.start()
    try:
        elimination = build_elimination(topology, np.zeros(len(mesh.points), dtype=bool))
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    # two numbers for each update would take more
    assert elimination.update_count > 10 * len(elimination.column)
    assert peak < 8.0 * elimination.update_count
