"""Symbolic factorisation: elimination order and fill of the block Cholesky factor."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import sparse
from scipy.sparse.linalg import splu

from warp_softbody.linear.block_sparsity import Pattern, starts

IntArray = npt.NDArray[np.int32]


@dataclass(frozen=True, kw_only=True, eq=False)
class Elimination:
    """Pattern of the unit block-lower factor L, rows in elimination order; told apart by identity.

    Attributes:
        order: (n,) node eliminated at each position.
        row_start, column: CSR of the strictly lower blocks, columns are positions.
        matrix_slot: per block, its slot in the matrix, or -1 for fill.
        diagonal_slot: (n,) slot of the diagonal block, -1 for a fixed node.
        column_start, column_row: the same blocks by column: CSC, rows rising.
        column_place: per block, its place in that order.
    """

    order: IntArray
    row_start: IntArray
    column: IntArray
    matrix_slot: IntArray
    diagonal_slot: IntArray
    column_start: IntArray
    column_row: IntArray
    column_place: IntArray

    @property
    def update_count(self) -> int:
        """Products of two blocks that a factorisation takes, beside those for the pivots."""
        below = np.diff(self.column_start).astype(np.int64)
        return int((below * (below - 1) // 2).sum())

    @property
    def refresh_cost(self) -> float:
        """Operations of a numeric factorisation over those of one solve with the factor."""
        solve = 2.0 * len(self.column) + 2.0 * len(self.order)
        return (self.update_count + 2.0 * len(self.column)) / solve


def _fill_pattern(
    pattern: Pattern, free: npt.NDArray[np.bool_]
) -> tuple[IntArray, npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Minimum-degree order of the node graph; rows and columns of its factor, below."""
    count = len(free)
    data = np.full(len(pattern.column), -1.0)
    rows = np.repeat(np.arange(count), np.diff(pattern.row_start))
    data[~(free[rows] & free[pattern.column])] = 0.0
    entries = (data, pattern.column, pattern.row_start)
    graph = sparse.csc_matrix(entries, shape=(count, count), copy=True)
    graph.setdiag(np.diff(pattern.row_start).astype(np.float64) + 1.0)
    graph.eliminate_zeros()
    factor = splu(
        graph,
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
    order = np.argsort(factor.perm_c).astype(np.int32)
    filled = sparse.csc_matrix(factor.L)
    rows = filled.indices.astype(np.int64)
    columns = np.repeat(np.arange(count), np.diff(filled.indptr))
    rows, columns = rows[rows > columns], columns[rows > columns]
    turn = _postorder(rows, columns, count)
    place = np.argsort(turn)
    return order[turn], place[rows], place[columns]


def _postorder(
    rows: npt.NDArray[np.int64], columns: npt.NDArray[np.int64], count: int
) -> npt.NDArray[np.int64]:
    """The columns of a factor in an equivalent order: parents soon after their children.

    The parent of a column is its first row. The fill stays, and columns of nearly the same rows
    come to stand side by side; the child with the largest family last.
    """
    parent = np.full(count, count)
    np.minimum.at(parent, columns, rows)
    family = np.ones(count + 1, dtype=np.int64)
    children: list[list[int]] = [[] for _ in range(count + 1)]
    for k in range(count):
        family[parent[k]] += family[k]
        children[parent[k]].append(k)
    # visited from the root on, largest families first, and read backwards
    visited, stack = [], [count]
    while stack:
        node = stack.pop()
        visited.append(node)
        stack += sorted(children[node], key=lambda child: (family[child], child))
    return np.array(visited[:0:-1], dtype=np.int64)


def build_elimination(pattern: Pattern, fixed: npt.NDArray[np.bool_]) -> Elimination:
    """Order and fill for a pattern."""
    count = len(fixed)
    order, rows, columns = _fill_pattern(pattern, ~fixed)
    by_row = np.lexsort((columns, rows))
    rows, columns = rows[by_row], columns[by_row]
    by_column = np.lexsort((rows, columns))
    diagonal = pattern.diagonal_slot[order].copy()
    diagonal[fixed[order]] = -1
    return Elimination(
        order=order,
        row_start=starts(rows, count),
        column=columns.astype(np.int32),
        matrix_slot=_matrix_slots(pattern, order[rows], order[columns], fixed),
        diagonal_slot=diagonal,
        column_start=starts(columns[by_column], count),
        column_row=rows[by_column].astype(np.int32),
        column_place=np.argsort(by_column).astype(np.int32),
    )


def _matrix_slots(
    pattern: Pattern, rows: IntArray, columns: IntArray, fixed: npt.NDArray[np.bool_]
) -> IntArray:
    """Slot of block (row, column) in the matrix; -1 where it has none or a node is fixed."""
    count = len(fixed)
    owner = np.repeat(np.arange(count), np.diff(pattern.row_start)).astype(np.int64)
    keys = owner * count + pattern.column
    wanted = rows.astype(np.int64) * count + columns
    slots = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
    found = (keys[slots] == wanted) & ~fixed[rows] & ~fixed[columns]
    return np.where(found, slots, -1).astype(np.int32)
