"""Index arrays of random meshes, against the same counted by sets and dense matrices."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import numpy.typing as npt
from hypothesis import given
from hypothesis import strategies as st

from warp_softbody.linear.aggregation import REGULARISATION, build_aggregation, coarse_matrix
from warp_softbody.linear.block_sparsity import Topology, build_topology
from warp_softbody.linear.symbolic_ldlt import build_elimination

NODES = 10
corners = st.permutations(range(NODES)).map(lambda nodes: nodes[:4])
meshes = st.lists(corners, min_size=1, max_size=8).map(np.array)
fixed_nodes = st.sets(st.integers(0, NODES - 1), max_size=NODES - 2)


def mask_of(nodes: set[int]) -> npt.NDArray[np.bool_]:
    mask = np.zeros(NODES, dtype=bool)
    mask[list(nodes)] = True
    return mask


def neighbours(tets: npt.NDArray[np.int64]) -> list[set[int]]:
    """Each node and those that share a tet with it."""
    around = [{node} for node in range(NODES)]
    for tet in tets.tolist():
        for node in tet:
            around[node].update(tet)
    return around


def rows_of(topology: Topology) -> npt.NDArray[np.intp]:
    return np.repeat(np.arange(NODES), np.diff(topology.row_start))


@given(meshes)
def test_a_row_holds_who_shares_a_tet(tets: npt.NDArray[np.int64]) -> None:
    topology = build_topology(tets, NODES)
    start, column = topology.row_start, topology.column
    rows = [column[a:b].tolist() for a, b in pairwise(start)]
    assert rows == [sorted(around) for around in neighbours(tets)]
    assert column[topology.diagonal_slot].tolist() == list(range(NODES))


@given(meshes)
def test_gather_lists_name_each_corner_once(tets: npt.NDArray[np.int64]) -> None:
    topology = build_topology(tets, NODES)
    nodes = np.repeat(np.arange(NODES), np.diff(topology.node_start))
    np.testing.assert_array_equal(tets.ravel()[topology.node_corners], nodes)
    assert sorted(topology.node_corners) == list(range(tets.size))
    edges = np.repeat(np.arange(len(topology.edge_slots)), np.diff(topology.edge_start))
    low, high = tets.ravel()[topology.edge_corners].T
    assert (low < high).all()
    rows, slots = rows_of(topology), topology.edge_slots[edges]
    np.testing.assert_array_equal(rows[slots], np.stack([low, high], axis=1))
    np.testing.assert_array_equal(topology.column[slots], np.stack([high, low], axis=1))
    np.testing.assert_array_equal(np.sort(topology.tet_edges.ravel()), np.sort(edges))


@given(meshes, fixed_nodes)
def test_the_factor_has_the_fill_of_its_order(tets: npt.NDArray[np.int64], fixed: set[int]) -> None:
    """Eliminating a node joins those of its neighbours that are left."""
    topology = build_topology(tets, NODES)
    found = build_elimination(topology, mask_of(fixed))
    assert sorted(found.order) == list(range(NODES))
    left = [
        around - fixed if node not in fixed else {node}
        for node, around in enumerate(neighbours(tets))
    ]
    place = np.argsort(found.order)
    lower: set[tuple[int, int]] = set()
    for step, node in enumerate(found.order.tolist()):
        later = {other for other in left[node] if place[other] > step}
        lower |= {(int(place[other]), step) for other in later}
        for other in later:
            left[other] |= later
    rows = np.repeat(np.arange(NODES), np.diff(found.row_start))
    blocks = list(zip(rows.tolist(), found.column.tolist(), strict=True))
    assert set(blocks) == lower and len(blocks) == len(lower)
    owner = np.repeat(np.arange(NODES), np.diff(found.column_start))
    by_column = list(zip(found.column_row.tolist(), owner.tolist(), strict=True))
    assert [by_column[place] for place in found.column_place] == blocks
    assert by_column == sorted(blocks, key=lambda block: block[::-1])
    shared = ((row, column, k) for row, column in lower for k in range(column))
    updates = sum((row, k) in lower and (column, k) in lower for row, column, k in shared)
    assert found.update_count == updates


@given(meshes, fixed_nodes, st.integers(0, 2**32 - 1))
def test_aggregates_share_the_free_nodes_and_make_the_coarse_matrix(
    tets: npt.NDArray[np.int64], fixed: set[int], seed: int
) -> None:
    """The coarse matrix is P^T A P with the rigid motions P of the aggregates."""
    random = np.random.default_rng(seed)
    topology, points = build_topology(tets, NODES), random.normal(size=(NODES, 3))
    found = build_aggregation(topology, mask_of(fixed), points)
    assert set(np.flatnonzero(found.aggregate_of < 0)) == fixed
    owner = np.repeat(np.arange(found.count), np.diff(found.start))
    np.testing.assert_array_equal(found.aggregate_of[found.nodes], owner)
    assert sorted(found.nodes) == sorted(set(range(NODES)) - fixed)

    dense = random.normal(size=(NODES, 3, NODES, 3))
    dense += dense.transpose(2, 3, 0, 1)
    rows = rows_of(topology)
    values = dense[rows, :, topology.column, :]
    matrix = np.zeros_like(dense)
    matrix[rows, :, topology.column, :] = values
    motions = np.zeros((NODES, 3, 2 * found.count, 3))
    for node in found.nodes.tolist():
        x, y, z = found.offsets[node]
        motions[node, :, 2 * found.aggregate_of[node]] = np.eye(3)
        turn = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
        motions[node, :, 2 * found.aggregate_of[node] + 1] = turn
    flat = motions.reshape(3 * NODES, -1)
    wanted = flat.T @ matrix.reshape(3 * NODES, -1) @ flat
    coarse, pattern = coarse_matrix(found, topology, values), found.pattern
    size = 2 * found.count
    result = np.zeros((size, 3, size, 3))
    coarse_rows = np.repeat(np.arange(size), np.diff(pattern.row_start))
    result[coarse_rows, :, pattern.column, :] = coarse
    difference = result.reshape(3 * size, -1) - wanted
    off_diagonal = difference - np.diag(np.diag(difference))
    np.testing.assert_allclose(off_diagonal, 0.0, atol=1e-12 * max(1.0, np.abs(wanted).max()))
    largest = np.abs(wanted).max(initial=0.0)
    assert (np.abs(np.diag(difference)) <= 2.0 * REGULARISATION * largest + 1e-12).all()
