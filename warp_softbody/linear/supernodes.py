"""Columns of a factor grouped to dense panels, as vector registers want them."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from warp_softbody.kernels.precision import BLOCK
from warp_softbody.linear.symbolic_ldlt import Elimination

IntArray = npt.NDArray[np.int32]

WIDEST = BLOCK // 3
"""Nodes of a supernode: their 3 x 3 blocks side by side fill a register."""

JOIN_COST = 20.0
"""Of one more supernode, in register operations."""


@dataclass(frozen=True, kw_only=True)
class Supernodes:
    """Runs of neighbouring columns of L whose blocks below lie in the rows of the last one.

    The blocks below a run are a panel, padded with zeros: a register holds 16 rows of one column.

    Attributes:
        first: (s + 1,) first column of each run, and the end.
        inner_start: (n,) where the blocks within the run begin in each row of the factor.
        below_start, below: CSR of the rows below each run.
        below_slot: (len(below), WIDEST) slots of the blocks in these rows, -1 for zeros.
        owner: (len(below),) run of each row below.
        panel_start: (s + 1,) first register; a run has 3 width of them per 16 rows.
    """

    first: IntArray
    inner_start: IntArray
    below_start: IntArray
    below: IntArray
    below_slot: IntArray
    owner: IntArray
    panel_start: IntArray


def _cost(width: int, below: int) -> float:
    """Register operations of both solves with a run."""
    groups = -(-3 * below // BLOCK)
    return JOIN_COST + 9.0 * width * (width - 1) + groups * (3 * width + 2 * BLOCK) + 3.0 * below


def _runs(parent: IntArray, below: IntArray) -> IntArray:
    """Cheapest division of the columns: a run goes on while the next column is the parent."""
    count = len(parent)
    best = np.zeros(count + 1)
    start = np.zeros(count + 1, dtype=np.int32)
    for end in range(1, count + 1):
        best[end] = np.inf
        for width in range(1, min(WIDEST, end) + 1):
            k = end - width
            if width > 1 and parent[k] != k + 1:
                break
            cost = best[k] + _cost(width, below[end - 1])
            if cost < best[end]:
                best[end], start[end] = cost, k
    ends = [count]
    while ends[-1] > 0:
        ends.append(start[ends[-1]])
    return np.array(ends[::-1], dtype=np.int32)


def build_supernodes(elimination: Elimination) -> Supernodes:
    """Runs of the columns of a factor and the places of its blocks in their panels."""
    count = len(elimination.order)
    rows = np.repeat(np.arange(count), np.diff(elimination.row_start))
    columns = elimination.column
    by_column = np.lexsort((rows, columns))
    column_start = np.searchsorted(columns[by_column], np.arange(count + 1))
    slots = [by_column[a:b] for a, b in pairwise(column_start)]
    struct = [rows[part] for part in slots]
    parent = np.array([part[0] if len(part) else -1 for part in struct], dtype=np.int32)
    first = _runs(parent, np.array([len(part) for part in struct], dtype=np.int32))
    run_of = np.repeat(np.arange(len(first) - 1), np.diff(first))

    below = [struct[end - 1] for end in first[1:]]
    below_start = np.concatenate([[0], np.cumsum([len(part) for part in below])])
    below_slot = np.full((below_start[-1], WIDEST), -1, dtype=np.int32)
    for column in range(count):
        run = run_of[column]
        outside = struct[column] >= first[run + 1]
        where = below_start[run] + np.searchsorted(below[run], struct[column][outside])
        below_slot[where, column - first[run]] = slots[column][outside]
    within = run_of[rows] == run_of[columns]
    inner = np.bincount(rows[within], minlength=count)

    groups = -(-3 * np.diff(below_start) // BLOCK)
    return Supernodes(
        first=first,
        inner_start=(elimination.row_start[1:] - inner).astype(np.int32),
        below_start=below_start.astype(np.int32),
        below=np.concatenate(below).astype(np.int32),
        below_slot=below_slot,
        owner=np.repeat(np.arange(len(below)), np.diff(below_start)).astype(np.int32),
        panel_start=np.concatenate([[0], np.cumsum(groups * 3 * np.diff(first))]).astype(np.int32),
    )
