"""Who touches whom: the fixed index arrays that assembly and solves run over."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

IntArray = npt.NDArray[np.int32]


@dataclass(frozen=True, kw_only=True)
class Pattern:
    """Sparsity of a symmetric matrix of 3 x 3 blocks.

    Attributes:
        row_start, column: CSR of the full pattern, diagonal included, columns in rising order.
        diagonal_slot: (n,) position of each row's diagonal block.
    """

    row_start: IntArray
    column: IntArray
    diagonal_slot: IntArray


@dataclass(frozen=True, kw_only=True)
class Topology(Pattern):
    """The pattern of a mesh's matrix, and gather lists for its assembly.

    Attributes:
        edge_start: (e + 1,) into the lists of tets around each edge.
        edge_corners: (.., 2) slots 4 tet + corner at the edge's lower and higher node.
        tet_edges: (m, 6) edges of each tet.
        edge_slots: (e, 2) matrix slots of the block and of its transpose.
        node_start: (n + 1,) into the lists of tets around each node.
        node_corners: slot 4 tet + corner of each entry.
    """

    edge_start: IntArray
    edge_corners: IntArray
    edge_slots: IntArray
    tet_edges: IntArray
    node_start: IntArray
    node_corners: IntArray


CORNER_PAIRS = np.array([(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)])


def starts(sorted_owners: npt.NDArray[np.integer], count: int) -> IntArray:
    """CSR offsets of entries sorted by owner."""
    return np.searchsorted(sorted_owners, np.arange(count + 1)).astype(np.int32)


def build_topology(tets: npt.NDArray[np.integer], node_count: int) -> Topology:
    """Index arrays for tets (m, 4) over ``node_count`` nodes."""
    tets = np.asarray(tets, dtype=np.int64)
    ends = tets[:, CORNER_PAIRS].reshape(-1, 2)
    corners = (4 * np.arange(len(tets))[:, None, None] + CORNER_PAIRS).reshape(-1, 2)
    flipped = ends[:, 0] > ends[:, 1]
    ends[flipped] = ends[flipped][:, ::-1]
    corners[flipped] = corners[flipped][:, ::-1]
    keys, edge_of = np.unique(ends[:, 0] * node_count + ends[:, 1], return_inverse=True)
    by_edge = np.argsort(edge_of, kind="stable")
    low, high = keys // node_count, keys % node_count

    rows = np.concatenate([low, high, np.arange(node_count)])
    columns = np.concatenate([high, low, np.arange(node_count)])
    order = np.argsort(rows * node_count + columns, kind="stable")
    slot = np.empty(len(order), dtype=np.int32)
    slot[order] = np.arange(len(order))
    edges = len(keys)

    nodes = tets.ravel()
    by_node = np.argsort(nodes, kind="stable")
    return Topology(
        row_start=starts(rows[order], node_count),
        column=columns[order].astype(np.int32),
        diagonal_slot=slot[2 * edges :],
        edge_start=starts(edge_of[by_edge], edges),
        edge_corners=corners[by_edge].astype(np.int32),
        tet_edges=edge_of.reshape(-1, 6).astype(np.int32),
        edge_slots=np.stack([slot[:edges], slot[edges : 2 * edges]], axis=1),
        node_start=starts(nodes[by_node], node_count),
        node_corners=by_node.astype(np.int32),
    )
