"""Where muscle segments lie in the mesh, and which tets feel them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.body.fiber_embedding import embed
from warp_softbody.body.muscles import MuscleGroup
from warp_softbody.errors import InputError
from warp_softbody.linear.block_sparsity import starts
from warp_softbody.world.joined_bodies import Part

IntArray = npt.NDArray[np.int32]

SMALLEST_WEIGHT = 1e-2
"""Weights below this share of a tet's whole are dropped, and the rest scaled up to sum to one
again."""


@dataclass(frozen=True, kw_only=True)
class MuscleLayout:
    """Muscles of a character: s segments, p fibre points, q pairs of a tet and a segment.

    Attributes:
        point_nodes, point_weights: (p, 4) nodes and barycentric weights of each fibre vertex.
        segment_points: (s, 2) its end points.
        directions: (s, 3) unit rest direction.
        rest_lengths: (s,) l_0, m.
        stiffness: (s,) S / l_0, Pa/m.
        pair_tet, pair_segment, pair_weight: (q,) sorted by tet, w of eq. (6)-(7).
    """

    point_nodes: IntArray
    point_weights: FloatArray
    segment_points: IntArray
    directions: FloatArray
    rest_lengths: FloatArray
    stiffness: FloatArray
    pair_tet: IntArray
    pair_segment: IntArray
    pair_weight: FloatArray

    def by_tet(self, tet_count: int) -> IntArray:
        """CSR offsets of the pairs by tet."""
        return starts(self.pair_tet, tet_count)


def segment_distance(points: FloatArray, start: FloatArray, end: FloatArray) -> FloatArray:
    """Shortest distances (points, segments) in m."""
    along = end - start
    offset = points[:, None, :] - start[None]
    t = np.einsum("psi,si->ps", offset, along) / np.einsum("si,si->s", along, along)
    nearest = np.clip(t, 0.0, 1.0)[..., None] * along[None]
    return np.asarray(np.linalg.norm(offset - nearest, axis=2))


def _group_pairs(
    group: MuscleGroup, centres: FloatArray, first_segment: int
) -> tuple[IntArray, IntArray, FloatArray]:
    start = np.concatenate([fiber.vertices[:-1] for fiber in group.fibers])
    end = np.concatenate([fiber.vertices[1:] for fiber in group.fibers])
    scaled = (segment_distance(centres, start, end) / group.kernel_width) ** 2
    # the nearest segment's exponent is taken out, so that tets far from every fibre keep their
    # weights
    kernel = np.exp(scaled.min(axis=1, keepdims=True) - scaled)
    weight = kernel / kernel.sum(axis=1, keepdims=True)
    weight[weight < SMALLEST_WEIGHT] = 0.0
    weight /= weight.sum(axis=1, keepdims=True)
    tet, segment = np.nonzero(weight)
    return tet.astype(np.int32), (segment + first_segment).astype(np.int32), weight[tet, segment]


def build_muscle_layout(character: Character) -> MuscleLayout:
    """Index arrays of all groups of a character; every array is empty when it has no muscles."""
    mesh = character.mesh
    fibers = character.fibers
    vertices = [fiber.vertices for fiber in fibers]
    points = np.concatenate(vertices) if vertices else np.zeros((0, 3))
    names = [fiber.name for fiber in fibers for _ in fiber.vertices]
    points, point_nodes, point_weights = embed(mesh, points, names)
    offsets = np.cumsum([0, *(len(v) for v in vertices)])
    runs = [np.arange(o, o + f.segment_count) for o, f in zip(offsets, fibers, strict=False)]
    first = np.concatenate([np.zeros(0), *runs]).astype(np.int32)
    segments = np.stack([first, first + 1], axis=1)
    span = points[segments[:, 1]] - points[segments[:, 0]]
    rest = np.linalg.norm(span, axis=1)
    if (rest <= 0.0).any():
        raise InputError(
            f"fibre {names[segments[np.argmin(rest), 0]]!r} has a segment outside the mesh whose "
            f"ends meet at one point of its surface"
        )

    centres = mesh.points[mesh.tets].mean(axis=1)
    pairs, strength, begun = [], [], 0
    for group in character.muscles:
        pairs.append(_group_pairs(group, centres, begun))
        strength.append(np.full(group.segment_count, group.strength))
        begun += group.segment_count
    tet = np.concatenate([p[0] for p in pairs] or [np.zeros(0, np.int32)])
    segment = np.concatenate([p[1] for p in pairs] or [np.zeros(0, np.int32)])
    weight = np.concatenate([p[2] for p in pairs] or [np.zeros(0)])
    by_tet = np.argsort(tet, kind="stable")
    return MuscleLayout(
        point_nodes=point_nodes,
        point_weights=point_weights,
        segment_points=segments,
        directions=_unit(span, rest),
        rest_lengths=rest,
        stiffness=(np.concatenate(strength) if strength else np.zeros(0)) / rest,
        pair_tet=tet[by_tet],
        pair_segment=segment[by_tet],
        pair_weight=weight[by_tet],
    )


def _unit(span: FloatArray, lengths: FloatArray) -> FloatArray:
    """Directions (s, 3), parts that are rounding alone made zero.

    Their squares would be denormal numbers in single precision, each a hundred times the work.
    """
    directions = span / lengths[:, None]
    return np.where(np.abs(directions) < 1e-12, 0.0, directions)


def join_layouts(layouts: Sequence[MuscleLayout], parts: Sequence[Part]) -> MuscleLayout:
    """The muscles of several bodies, in the joined numbers of nodes, tets and segments."""
    if len(layouts) == 1:
        return layouts[0]
    points = np.cumsum([0, *(len(layout.point_nodes) for layout in layouts)])
    numbered = list(zip(layouts, parts, points[:-1], strict=True))
    return MuscleLayout(
        point_nodes=_joined([a.point_nodes + p.nodes.start for a, p, _ in numbered]),
        point_weights=np.concatenate([a.point_weights for a in layouts]),
        segment_points=_joined([a.segment_points + first for a, _, first in numbered]),
        directions=np.concatenate([a.directions for a in layouts]),
        rest_lengths=np.concatenate([a.rest_lengths for a in layouts]),
        stiffness=np.concatenate([a.stiffness for a in layouts]),
        pair_tet=_joined([a.pair_tet + p.tets.start for a, p, _ in numbered]),
        pair_segment=_joined([a.pair_segment + p.segments.start for a, p, _ in numbered]),
        pair_weight=np.concatenate([a.pair_weight for a in layouts]),
    )


def _joined(arrays: Sequence[IntArray]) -> IntArray:
    return np.concatenate(arrays).astype(np.int32)
