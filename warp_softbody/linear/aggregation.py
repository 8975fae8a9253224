"""Aggregates of nodes and the matrix of their rigid motions: the coarse level of large bodies."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import sparse

from warp_softbody.arrays import FloatArray
from warp_softbody.linear.block_sparsity import Pattern, starts

IntArray = npt.NDArray[np.int32]

REGULARISATION = 1e-4
"""Added to the coarse diagonal, relative to it: an aggregate of one or two nodes has motions that
move nothing."""


@dataclass(frozen=True, kw_only=True)
class Aggregation:
    """Which nodes move together on the coarse level.

    Attributes:
        aggregate_of: (n,) aggregate of each node, -1 for a fixed node.
        start, nodes: CSR lists of the nodes of each aggregate.
        offsets: (n, 3) rest place about the middle of the aggregate, over the aggregates' size.
        pattern: of the coarse matrix, whose nodes 2 I and 2 I + 1 are the translation and the
            turn of aggregate I.
    """

    aggregate_of: IntArray
    start: IntArray
    nodes: IntArray
    offsets: FloatArray
    pattern: Pattern

    @property
    def count(self) -> int:
        """Number of aggregates."""
        return len(self.start) - 1


def build_aggregation(
    pattern: Pattern, fixed: npt.NDArray[np.bool_], points: FloatArray
) -> Aggregation:
    """Aggregates of a mesh: a node and its neighbours where none of them is taken yet."""
    aggregate_of = _join_leftovers(pattern, _seed(pattern, fixed))
    free = np.flatnonzero(aggregate_of >= 0)
    nodes = free[np.argsort(aggregate_of[free], kind="stable")].astype(np.int32)
    count = int(aggregate_of.max(initial=-1)) + 1
    offsets = np.zeros(points.shape)
    owner = aggregate_of[nodes]
    sizes = np.bincount(owner, minlength=count)
    middles = np.stack(
        [np.bincount(owner, points[nodes, axis], count) / sizes for axis in range(3)], axis=1
    )
    offsets[nodes] = points[nodes] - middles[owner]
    scale = np.sqrt((offsets[nodes] ** 2).sum(axis=1).mean()) if len(nodes) else 1.0
    return Aggregation(
        aggregate_of=aggregate_of,
        start=starts(owner, count),
        nodes=nodes,
        offsets=offsets / max(scale, 1e-300),
        pattern=_coarse_pattern(pattern, aggregate_of, count),
    )


def _seed(pattern: Pattern, fixed: npt.NDArray[np.bool_]) -> IntArray:
    """Aggregates around nodes in order; what is left over keeps -1 and fixed nodes get -2."""
    aggregate_of = np.where(fixed, -2, -1).astype(np.int32)
    taken = fixed.copy()
    count = 0
    row_start, column = pattern.row_start.tolist(), pattern.column
    for node in range(len(fixed)):
        if taken[node]:
            continue
        ring = column[row_start[node] : row_start[node + 1]]
        if (aggregate_of[ring] >= 0).any():
            continue
        members = ring[~fixed[ring]]
        aggregate_of[members] = count
        taken[members] = True
        count += 1
    return aggregate_of


def _join_leftovers(pattern: Pattern, seeded: IntArray) -> IntArray:
    """Every node that no seed took joins the aggregate that most of its neighbours are in."""
    joined = seeded.copy()
    count = int(seeded.max(initial=-1)) + 1
    for node in np.flatnonzero(seeded == -1):
        ring = pattern.column[pattern.row_start[node] : pattern.row_start[node + 1]]
        around = seeded[ring]
        around = around[around >= 0]
        if len(around):
            joined[node] = np.bincount(around).argmax()
        else:
            joined[node] = count
            count += 1
    return np.where(joined < 0, -1, joined).astype(np.int32)


def _coarse_pattern(pattern: Pattern, aggregate_of: IntArray, count: int) -> Pattern:
    """Aggregates are neighbours where nodes are; each stands for two coarse nodes."""
    rows, columns, _ = _links(pattern, aggregate_of)
    graph = sparse.coo_array((np.ones(len(rows)), (rows, columns)), shape=(count, count))
    blocks = sparse.kron(graph.tocsr(), np.ones((2, 2)), format="csr")
    blocks.sort_indices()
    row_start, column = blocks.indptr.astype(np.int32), blocks.indices.astype(np.int32)
    owner = np.repeat(np.arange(2 * count), np.diff(row_start))
    return Pattern(
        row_start=row_start,
        column=column,
        diagonal_slot=np.flatnonzero(owner == column).astype(np.int32),
    )


def _links(
    pattern: Pattern, aggregate_of: IntArray
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Aggregates of both ends of each block between free nodes, and the block's slot."""
    owner = np.repeat(np.arange(len(aggregate_of)), np.diff(pattern.row_start))
    rows, columns = aggregate_of[owner], aggregate_of[pattern.column]
    slots = np.flatnonzero((rows >= 0) & (columns >= 0))
    return rows[slots].astype(np.int64), columns[slots].astype(np.int64), slots


def coarse_matrix(aggregation: Aggregation, pattern: Pattern, values: FloatArray) -> FloatArray:
    """P^T A P for rigid motions P of the rest shape, (coarse blocks, 3, 3).

    ``values`` (blocks, 3, 3) are those of the rest shape's matrix A.
    """
    _, _, slots = _links(pattern, aggregation.aggregate_of)
    owner = np.repeat(np.arange(len(aggregation.aggregate_of)), np.diff(pattern.row_start))
    first, second = owner[slots], pattern.column[slots]
    block = values[slots]
    turned = block @ _turn_of(aggregation.offsets[second])
    back = _turn_of(aggregation.offsets[first]).transpose(0, 2, 1)
    parts = ((block, turned), (back @ block, back @ turned))
    coarse = aggregation.pattern
    width = len(coarse.diagonal_slot)
    keys = np.repeat(np.arange(width), np.diff(coarse.row_start)) * width + coarse.column
    sums = np.zeros((len(coarse.column), 9))
    for i, row in enumerate(parts):
        for j, part in enumerate(row):
            target = (2 * aggregation.aggregate_of[first].astype(np.int64) + i) * width
            target += 2 * aggregation.aggregate_of[second] + j
            slot = np.searchsorted(keys, target)
            for k in range(9):
                sums[:, k] += np.bincount(slot, part.reshape(-1, 9)[:, k], len(keys))
    result = sums.reshape(-1, 3, 3)
    diagonal = result[coarse.diagonal_slot]
    size = np.trace(diagonal, axis1=1, axis2=2) / 3.0
    size = np.maximum(size, 1e-3 * size.max(initial=0.0))
    result[coarse.diagonal_slot] += REGULARISATION * size[:, None, None] * np.eye(3)
    return result


def _turn_of(offsets: FloatArray) -> FloatArray:
    """Matrices (n, 3, 3) that take a turn w to the motion w x offset."""
    x, y, z = offsets.T
    zero = np.zeros_like(x)
    return np.stack([zero, z, -y, -z, zero, x, y, -x, zero], axis=1).reshape(-1, 3, 3)
