"""Runs of columns and their panels, against the factor that they were laid out from."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import warp as wp

from tests.support.bodies import box, crumpled, numbers, rig
from warp_softbody.device.workspace import Workspace
from warp_softbody.engine.options import Precision
from warp_softbody.kernels.precision import BLOCK
from warp_softbody.linear.block_ldlt import BlockFactor, Freedom
from warp_softbody.linear.block_sparsity import build_topology
from warp_softbody.linear.preconditioner import WarpedFactor
from warp_softbody.linear.supernodes import WIDEST, build_supernodes
from warp_softbody.linear.symbolic_ldlt import Elimination, build_elimination


def elimination_of(cells: tuple[int, int, int]) -> Elimination:
    mesh = box(cells, jitter=0.1)
    count = len(mesh.points)
    return build_elimination(build_topology(mesh.tets, count), np.zeros(count, dtype=bool))


def test_parents_come_after_whole_families() -> None:
    """In a postorder the columns below each one in the elimination tree stand right before it."""
    e = elimination_of((4, 3, 5))
    count = len(e.order)
    rows = np.repeat(np.arange(count), np.diff(e.row_start))
    parent = np.full(count, count)
    np.minimum.at(parent, e.column, rows)
    family, first = np.ones(count + 1, dtype=int), np.arange(count + 1)
    for k in range(count):
        family[parent[k]] += family[k]
        first[parent[k]] = min(first[parent[k]], first[k])
    np.testing.assert_array_equal(np.arange(count) - first[:-1] + 1, family[:-1])


@pytest.mark.parametrize("cells", [(1, 1, 1), (2, 2, 3), (4, 3, 5)])
def test_every_block_has_one_place(cells: tuple[int, int, int]) -> None:
    """Within a run or below it; runs cover the columns and are as wide as a register at most."""
    e = elimination_of(cells)
    runs = build_supernodes(e)
    widths = np.diff(runs.first)
    assert (widths >= 1).all() and (widths <= WIDEST).all()
    assert runs.first[0] == 0 and runs.first[-1] == len(e.order)
    inner = np.concatenate(
        [np.arange(a, b) for a, b in zip(runs.inner_start, e.row_start[1:], strict=True)]
    )
    placed = runs.below_slot[runs.below_slot >= 0]
    np.testing.assert_array_equal(
        np.sort(np.concatenate([inner, placed])), np.arange(len(e.column))
    )
    lane_row, lane_column = np.nonzero(runs.below_slot >= 0)
    slots = runs.below_slot[lane_row, lane_column]
    rows = np.repeat(np.arange(len(e.order)), np.diff(e.row_start))
    np.testing.assert_array_equal(rows[slots], runs.below[lane_row])
    np.testing.assert_array_equal(e.column[slots], runs.first[runs.owner[lane_row]] + lane_column)
    groups = -(-3 * np.diff(runs.below_start) // BLOCK)
    np.testing.assert_array_equal(np.diff(runs.panel_start), groups * 3 * widths)


@pytest.mark.parametrize("native_code", [True, False])
@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_panels_solve_as_the_blocks_do(precision: Precision, native_code: bool) -> None:
    """Against the walk over blocks that the 16 right-hand sides of the reduced dynamics take."""
    mesh = box((3, 3, 4), jitter=0.2)
    body = rig(mesh, time_step=0.01, precision=precision)
    body.place(crumpled(mesh))
    body.stepper.assemble(body.state)
    assembly, model, n = body.stepper.assembly, body.model, len(mesh.points)
    system = replace(model.system, native_code=native_code)
    matrix = (system, assembly.values, assembly.node_rotations)
    factor = WarpedFactor(*matrix, Workspace())
    alone = WarpedFactor(*matrix, Workspace(), serves="vectors")
    freedom = Freedom(
        model.zeros(n, wp.int32),
        model.zeros(n, model.types.vec3),
        model.zeros(n, model.types.mat33),
    )
    for each in (factor, alone):
        each.renew(freedom)
        each.prepare(freedom)
    vectors = np.random.default_rng(2).standard_normal((3 * n, BLOCK))
    shape = (1, 3 * n)
    right = model.array(vectors[None].astype(precision), model.types.block)
    work, result = (model.zeros(shape, model.types.block) for _ in range(2))
    factor.apply_block(right, work, result)
    one = model.zeros(n, model.types.vec3)
    columns = []
    for column in vectors.T:
        factor.apply(model.array(column.reshape(n, 3), model.types.vec3), one)
        columns.append(numbers(one).ravel())
    alone.apply(model.array(vectors.T[-1].reshape(n, 3), model.types.vec3), one)
    np.testing.assert_array_equal(numbers(one).ravel(), columns[-1])
    expected = result.numpy()[0]
    # both end in rounding of sums of up to 3 n products, in another order
    bound = 3 * n * np.finfo(precision).eps * np.abs(expected).max()
    np.testing.assert_allclose(np.stack(columns, axis=1), expected, atol=bound)


def test_panels_in_half_precision_are_a_factor_close_by() -> None:
    """Of a matrix that is symmetric, positive definite and off by roundings of half precision."""
    mesh = box((3, 4, 5), jitter=0.2)
    body = rig(mesh, time_step=0.01, precision="float32")
    body.place(crumpled(mesh))
    body.stepper.assemble(body.state)
    model, n = body.model, len(mesh.points)
    types, system = model.types, model.system
    unturned = model.array(np.tile(np.eye(3), (n, 1, 1)), types.mat33)
    freedom = Freedom(
        model.zeros(n, wp.int32), model.zeros(n, types.vec3), model.zeros(n, types.mat33)
    )
    inverses = []
    for half in (False, True):
        factor = BlockFactor(system.elimination, types, system.device, half=half)
        factor.factorise(body.stepper.assembly.values, freedom)
        one, columns = model.zeros(n, types.vec3), []
        for column in np.eye(3 * n):
            factor.solve(unturned, model.array(column.reshape(n, 3), types.vec3), one)
            columns.append(numbers(one).ravel())
        inverses.append(np.stack(columns, axis=1))
    exact, near = inverses
    np.testing.assert_allclose(near, near.T, atol=1e-5 * np.abs(near).max())
    # eigenvalues of the one in the metric of the other are 1 where they are the same
    scaled = np.linalg.solve(np.linalg.cholesky(exact), near)
    scaled = np.linalg.solve(np.linalg.cholesky(exact), scaled.T)
    found = np.linalg.eigvalsh(0.5 * (scaled + scaled.T))
    rounding = np.finfo(np.float16).eps
    assert np.abs(found - 1.0).max() < 20.0 * rounding
    assert np.abs(found - 1.0).max() > 0.1 * rounding
