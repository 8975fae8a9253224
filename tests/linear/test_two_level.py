"""The two-level preconditioner of large bodies, against dense NumPy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.linear.dense_two_level import (
    MESH,
    TWO_LEVEL,
    dense_two_level,
    level_of,
    rigid_motions,
)
from tests.linear.matrices import FIXED, NORMAL, STIFF, assembled, factor_of, preconditioned
from tests.support.bodies import box, epsilon, rig, turn
from tests.verification import reference
from warp_softbody.engine.options import Precision
from warp_softbody.linear.aggregation import REGULARISATION
from warp_softbody.linear.preconditioner import TwoLevel
from warp_softbody.world.ground import Plane


@pytest.mark.parametrize("fixed", [(), FIXED])
def test_aggregates_part_the_free_nodes(fixed: Any) -> None:
    body = rig(MESH, fixed=fixed, **TWO_LEVEL)
    aggregation = level_of(body).aggregation
    assert sorted(aggregation.nodes) == sorted(set(range(len(MESH.points))) - set(fixed))
    assert (aggregation.aggregate_of[list(fixed)] == -1).all()
    owners = aggregation.aggregate_of[aggregation.nodes]
    assert (np.diff(owners) >= 0).all() and aggregation.count == owners.max() + 1
    sizes = np.diff(aggregation.start)
    assert sizes.min() >= 1 and sizes.mean() > 5


@pytest.mark.parametrize("fixed", [(), FIXED])
def test_coarse_matrix_is_the_rest_shape_s_on_rigid_motions(fixed: Any) -> None:
    options = {"time_step": 0.01, "precision": "float64", **TWO_LEVEL}
    body = rig(MESH, material=STIFF, fixed=fixed, **options)
    matrix = reference.step_matrix(body.model, MESH.points)
    motions = rigid_motions(body)
    expected = motions.T @ matrix @ motions
    pattern = body.model.system.elimination
    level = level_of(body)
    coarse = level.aggregation
    assert len(pattern.order) == 2 * coarse.count
    found = np.zeros((2 * coarse.count, 3, 2 * coarse.count, 3))
    rows = np.repeat(np.arange(2 * coarse.count), np.diff(coarse.pattern.row_start))
    found[rows, :, coarse.pattern.column, :] = level.values
    difference = found.reshape(expected.shape) - expected
    off = difference - np.diag(np.diag(difference))
    assert np.abs(off).max() <= 1e-12 * np.abs(expected).max()
    raised = np.diag(difference)
    assert raised.min() > 0.0 and raised.max() <= 1.01 * REGULARISATION * np.diag(expected).max()


@pytest.mark.parametrize("native", [True, False])
@pytest.mark.parametrize("fixed", [(), FIXED])
@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_application_is_two_sweeps_around_a_correction(
    fixed: Any, precision: Precision, native: bool
) -> None:
    options = {"precision": precision, "native_code": native, **TWO_LEVEL}
    body, matrix = assembled(MESH, fixed, **options)
    preconditioner = factor_of(body)
    assert isinstance(preconditioner, TwoLevel)
    free = np.eye(len(matrix))
    held = (3 * np.asarray(fixed, dtype=int)[:, None] + np.arange(3)).ravel()
    free[held] = 0.0
    found = preconditioned(body, preconditioner, free)
    expected = free @ dense_two_level(body, matrix) @ free
    bound = 8 * np.linalg.cond(matrix) * epsilon(precision)
    assert bound < 0.1
    np.testing.assert_allclose(found, expected, atol=bound * np.abs(expected).max())


@pytest.mark.parametrize("ground", [None, Plane(friction=0.5)])
def test_it_is_symmetric_and_positive_where_contact_holds_and_slides(ground: Any) -> None:
    body, _ = assembled(MESH, ground=ground, precision="float64", **TWO_LEVEL)
    n = len(MESH.points)
    rng = np.random.default_rng(3)
    kinds = rng.integers(0, 3, n)
    roots = rng.standard_normal((n, 3, 3))
    slip = np.where((kinds == 1)[:, None, None], 50.0 * roots @ roots.transpose(0, 2, 1), 0.0)
    kept = [np.eye(3), np.linalg.svd(NORMAL[None])[2][1:], np.zeros((0, 3))]
    basis = np.concatenate(
        [np.kron(np.eye(n)[node], kept[kinds[node]]) for node in range(n) if kinds[node] < 2]
    ).T
    applied = preconditioned(body, factor_of(body, kinds, slip), basis)
    # stays on the free velocities
    np.testing.assert_allclose(basis @ (basis.T @ applied), applied, atol=1e-14)
    inside = basis.T @ applied
    np.testing.assert_allclose(inside, inside.T, atol=1e-12 * np.abs(inside).max())
    assert np.linalg.eigvalsh(0.5 * (inside + inside.T)).min() > 0.0


def test_it_turns_with_the_body() -> None:
    """A rigid turn changes neither coarse space nor sweeps: P of the turned body is Q P Q^T."""
    body, _ = assembled(MESH, precision="float64", **TWO_LEVEL)
    before = preconditioned(body, factor_of(body), np.eye(3 * len(MESH.points)))
    rotation = turn((1.0, 0.3, -2.0), 1.9)
    body.place(body.positions @ rotation.T)
    body.stepper.assemble(body.state)
    after = preconditioned(body, factor_of(body), np.eye(3 * len(MESH.points)))
    turned = np.kron(np.eye(len(MESH.points)), rotation)
    expected = turned @ before @ turned.T
    np.testing.assert_allclose(after, expected, atol=1e-10 * np.abs(expected).max())


@pytest.mark.parametrize("fixed", [(), FIXED])
def test_blocks_are_treated_like_single_vectors(fixed: Any) -> None:
    body, _ = assembled(MESH, fixed, precision="float64", **TWO_LEVEL)
    preconditioner = factor_of(body)
    model, n = body.model, body.model.node_count
    vectors = np.random.default_rng(2).standard_normal((3 * n, 32))
    blocks = vectors.T.reshape(2, 16, 3 * n).transpose(0, 2, 1)
    result = model.zeros((2, 3 * n), model.types.block)
    work = model.zeros((2, 3 * n), model.types.block)
    residual = model.array(blocks, model.types.block)
    preconditioner.apply_block(residual, work, result)
    found = result.numpy().transpose(0, 2, 1).reshape(32, 3 * n).T
    expected = preconditioned(body, preconditioner, vectors)
    np.testing.assert_allclose(found, expected, atol=1e-13 * np.abs(expected).max())


def test_iterations_hardly_grow_with_the_mesh() -> None:
    """Two levels with rigid motions: bounded by the aggregate's size, not by the mesh's."""
    counts = []
    for cells in (2, 4, 8):
        mesh = box((4 * cells, cells, cells), (0.8, 0.2, 0.2))
        fixed = np.flatnonzero(mesh.points[:, 0] < 1e-9)
        options = {"gravity": (0.0, 0.0, -9.81), "time_step": 0.01, **TWO_LEVEL}
        body = rig(mesh, material=STIFF, fixed=fixed, **options)
        counts.append(np.mean([body.step().iterations for _ in range(20)]))
    assert counts[2] <= 2.0 * counts[0]
