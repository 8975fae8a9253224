"""Stages and pictures take compacted skin and fibre segments from a character."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.sparse import csr_array

from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.stage_exports.conventions import IntArray
from warp_softbody.stage_exports.creases import cut_along_creases


@dataclass(frozen=True, kw_only=True)
class Layout:
    """Index sets that never change during a take.

    Attributes:
        skin_nodes: (k,) mesh node, or point of the character's own skin, behind each point of the
            skin, ascending; one on a sharp edge has a point on each side of it.
        carriers: (k, n) weights of the nodes that carry the points of an own skin; None where
            these are nodes.
        skin_faces: (f, 3) triangles over skin points, outward.
        segment_ends: (s, 2) rows of the character's fibre points that each muscle segment joins.
        fiber_vertices: (p, 3) m, vertices of all fibres at rest.
    """

    skin_nodes: IntArray
    carriers: csr_array[np.float64] | None
    skin_faces: IntArray
    segment_ends: IntArray
    fiber_vertices: FloatArray

    def skin_at(self, positions: FloatArray) -> FloatArray:
        """(k, 3) m, the skin's points where the nodes are at positions (n, 3) m."""
        if self.carriers is None:
            return np.asarray(positions[self.skin_nodes])
        return np.asarray(self.carriers @ positions)

    @classmethod
    def of(cls, character: Character) -> Layout:
        """Collect the index sets of a character."""
        mesh = character.mesh
        own, carriers = character.skin, None
        if own is None:
            skin = cut_along_creases(np.asarray(mesh.points), np.asarray(mesh.surface))
        else:
            skin = cut_along_creases(own.points, own.faces)
            carriers = csr_array(character.skin_weights[skin.nodes])
        fibers = [fiber.vertices for fiber in character.fibers]
        return cls(
            skin_nodes=skin.nodes,
            carriers=carriers,
            skin_faces=skin.faces,
            segment_ends=segment_ends([len(vertices) for vertices in fibers]),
            fiber_vertices=np.concatenate([*fibers, np.zeros((0, 3))]),
        )


def segment_ends(vertex_counts: list[int]) -> IntArray:
    """(s, 2) pairs of consecutive vertices of polylines stored one after the other."""
    starts = np.concatenate([[0], np.cumsum(vertex_counts, dtype=np.int64)])
    first = [np.arange(start, end - 1) for start, end in pairwise(starts.tolist())]
    heads = np.concatenate([*first, np.zeros(0, dtype=np.int64)])
    return np.stack([heads, heads + 1], axis=1).astype(np.int32)
