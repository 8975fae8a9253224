"""Sparse factors of matrices of 3 x 3 blocks, whole and incomplete, and what they cost."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from benchmarks.preconditioners.system import Apply, blocks_of
from warp_softbody.arrays import FloatArray

BLOCK_PRODUCT = 3.0
"""Multiplications in a product of two 3 x 3 blocks over those in one of a block and a vector."""

NATURAL: dict[str, Any] = {
    "permc_spec": "NATURAL",
    "diag_pivot_thresh": 0.0,
    "options": {"SymmetricMode": True},
}


@dataclass(frozen=True)
class Factor:
    """A factor L D L^T, nodes in minimum-degree order.

    Attributes:
        solve: right-hand side to solution.
        below: blocks of L under its diagonal.
        nodes: blocks of D.
        updates: products of two blocks that computing it takes.
    """

    solve: Apply
    below: int
    nodes: int
    updates: int

    @property
    def touched(self) -> float:
        """Blocks multiplied by a vector in one solve: those of L twice, those of D once."""
        return 2.0 * self.below + self.nodes

    @property
    def stored(self) -> float:
        """Blocks of L and D."""
        return float(self.below + self.nodes)

    @property
    def price(self) -> float:
        """Work of computing it, in blocks multiplied by a vector."""
        return BLOCK_PRODUCT * (self.updates + self.below + self.nodes)


def factorise(matrix: Any) -> Factor:
    """Order the nodes by their graph, then factorise."""
    blocks = blocks_of(matrix)
    count = len(blocks.indptr) - 1
    # diagonally dominant, so that nothing cancels and all of the fill is seen
    entries = (np.full(len(blocks.indices), -1.0), blocks.indices, blocks.indptr)
    graph = sp.csc_matrix(entries, shape=(count, count))
    graph.setdiag(np.diff(blocks.indptr) + 1.0)
    fill = splu(graph, **{**NATURAL, "permc_spec": "MMD_AT_PLUS_A"})
    below = np.diff(fill.L.indptr).astype(np.int64) - 1
    order = (3 * np.argsort(fill.perm_c)[:, None] + np.arange(3)).ravel()
    factor = splu(matrix.tocsr()[order][:, order].tocsc(), **NATURAL)

    def solve(right: FloatArray) -> FloatArray:
        solution = np.empty_like(right)
        solution[order] = factor.solve(right[order])
        return solution

    updates = int((below * (below + 1) // 2).sum())
    return Factor(solve, int(below.sum()), count, updates)


def sweeps(matrix: Any) -> tuple[Apply, Apply]:
    """Solves with the block-lower and the block-upper triangle, diagonal blocks included."""
    entries = matrix.tocoo()
    kept = entries.row // 3 >= entries.col // 3
    places = (entries.row[kept], entries.col[kept])
    lower = sp.csc_matrix((entries.data[kept], places), shape=matrix.shape)
    return triangular_solver(lower), triangular_solver(lower.T)


def triangular_solver(triangle: Any) -> Apply:
    """Solve with a block triangle; in this order its factor has no fill."""
    solve: Apply = splu(triangle.tocsc(), **NATURAL).solve
    return solve


def incomplete_ldl(matrix: Any) -> tuple[Any, FloatArray, int]:
    """L (unit diagonal, CSR), D (n, 3, 3) and the updates done, nodes in the matrix's order.

    Updates of blocks that the matrix does not have are dropped.

    Raises:
        ArithmeticError: a block of D is not positive definite.
    """
    blocks = blocks_of(matrix)
    count, updates = len(blocks.indptr) - 1, 0
    pivots, inverses = np.empty((count, 3, 3)), np.empty((count, 3, 3))
    lower: list[dict[int, FloatArray]] = []
    for i in range(count):
        span = slice(blocks.indptr[i], blocks.indptr[i + 1])
        row: dict[int, FloatArray] = {}
        upper: dict[int, FloatArray] = {}
        for j, entry in zip(blocks.indices[span].tolist(), blocks.data[span], strict=True):
            earlier = lower[j] if j < i else row
            shared = [k for k in upper if k in earlier]
            updates += len(shared)
            for k in shared:
                entry = entry - upper[k] @ earlier[k].T
            if j == i:
                pivots[i] = entry
                break
            upper[j], row[j] = entry, entry @ inverses[j]
        if np.linalg.eigvalsh(pivots[i])[0] <= 0.0:
            raise ArithmeticError(f"the pivot of node {i} is not positive definite")
        inverses[i] = np.linalg.inv(pivots[i])
        row[i] = np.eye(3)
        lower.append(row)
    columns = np.concatenate([list(row) for row in lower])
    row_starts = np.cumsum([0, *map(len, lower)])
    data = np.concatenate([list(row.values()) for row in lower])
    factor = sp.bsr_matrix((data, columns, row_starts), shape=matrix.shape)
    return factor.tocsr(), pivots, updates
