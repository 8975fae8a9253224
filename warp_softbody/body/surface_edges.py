"""The edges between two triangles of a surface are listed here."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

IntArray = npt.NDArray[np.int32]


@dataclass(frozen=True)
class SurfaceEdges:
    """The edges between two triangles of a surface.

    Attributes:
        ends: (e, 2) nodes.
        faces: (e, 2) triangles on both sides; where more than two meet, two of them.
        opposite: (e, 2) the third node of each.
        of_face: (f, 3) edges of each triangle.
    """

    ends: IntArray
    faces: IntArray
    opposite: IntArray
    of_face: IntArray

    @staticmethod
    def of(surface: npt.NDArray[np.integer]) -> SurfaceEdges:
        """The edges of closed surfaces, (f, 3) nodes of triangles."""
        ends = np.stack([surface, np.roll(surface, -1, axis=1)], axis=2).reshape(-1, 2)
        opposite = np.roll(surface, 1, axis=1).ravel()
        faces = np.repeat(np.arange(len(surface)), 3)
        unique, edge_of = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True)
        order = np.argsort(edge_of.ravel(), kind="stable")
        first = np.searchsorted(edge_of.ravel()[order], np.arange(len(unique)))
        last = np.append(first[1:], len(order)) - 1
        both = np.stack([order[first], order[last]], axis=1)
        return SurfaceEdges(
            unique.astype(np.int32),
            faces[both].astype(np.int32),
            opposite[both].astype(np.int32),
            edge_of.reshape(-1, 3).astype(np.int32),
        )

    @staticmethod
    def count(surface: npt.NDArray[np.integer]) -> int:
        """How many edges a surface has."""
        return len(SurfaceEdges.of(surface).ends)
