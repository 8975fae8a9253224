"""Device arrays of contact that live as long as a stepper: what is found, noted and worked in.

The kernels take them as structs of the same fields (``kernels/contact/structs.py``). The counts
are: n nodes, c contacts or pairs, s surface nodes, e edges of the surfaces.
"""

from __future__ import annotations

from dataclasses import dataclass

import warp as wp

from warp_softbody.device.allocator import Allocator, DeviceArray
from warp_softbody.kernels.contact.pair_factor import MOST_ROWS


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class PassRecord:
    """What a pass of the active set notes of each contact.

    Attributes:
        changed: (c,) int32, a `NodeChange`.
        violations: (c,) vec2, N s, by how much Signorini's and Coulomb's laws are missed.
    """

    changed: DeviceArray
    violations: DeviceArray

    @staticmethod
    def of(count: int, make: Allocator) -> PassRecord:
        """For a number of contacts."""
        pair = wp.types.vector(length=2, dtype=make.types.scalar)
        return PassRecord(changed=make.zeros(count, wp.int32), violations=make.zeros(count, pair))


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class PassSummary:
    """What the conclusion of a pass tells of all contacts of a kind.

    Attributes:
        worst: (1,) int32, the contact that misses its laws most; -1 for none.
        largest_violations: (1,) vec2, N s, the largest of both laws; of ground and pairs together.
    """

    worst: DeviceArray
    largest_violations: DeviceArray

    @staticmethod
    def of(make: Allocator) -> PassSummary:
        """Nothing has been concluded yet."""
        pair = wp.types.vector(length=2, dtype=make.types.scalar)
        return PassSummary(worst=make.zeros(1, wp.int32), largest_violations=make.zeros(1, pair))


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class FoundPairs:
    """The pairs of a step beside their states, and lists of them and of their nodes.

    Attributes:
        normals: (c,) vec3, unit, from the second side to the first.
        normal_velocity: (c,) scalar, m/s, least normal velocity of the first side relative to the
            second: -gap / dt, at most the recovery speed.
        friction_factor: (c,) scalar, factor on the coefficient of friction, 0 or 1.
        found: (c,) int32, the pairs that there are, the first ``found_count`` (1,) of them.
        active: (c,) int32, those of them that are pressed, the first ``active_count`` (1,).
        marks: (n,) int32, scratch, zero between launches.
        touched: (n,) int32, the nodes of active pairs.
        constrained: (n,) int32, those of them that the ground constrains.
        node_counts: (2,) int32, how many ``touched`` and ``constrained`` hold.
    """

    normals: DeviceArray
    normal_velocity: DeviceArray
    friction_factor: DeviceArray
    found: DeviceArray
    found_count: DeviceArray
    active: DeviceArray
    active_count: DeviceArray
    marks: DeviceArray
    touched: DeviceArray
    constrained: DeviceArray
    node_counts: DeviceArray

    @staticmethod
    def of(count: int, node_count: int, make: Allocator) -> FoundPairs:
        """For so many pairs at most; none are found yet."""
        types = make.types
        return FoundPairs(
            normals=make.zeros(count, types.vec3),
            normal_velocity=make.zeros(count, types.scalar),
            friction_factor=make.zeros(count, types.scalar),
            found=make.zeros(count, wp.int32),
            found_count=make.zeros(1, wp.int32),
            active=make.zeros(count, wp.int32),
            active_count=make.zeros(1, wp.int32),
            marks=make.zeros(node_count, wp.int32),
            touched=make.zeros(node_count, wp.int32),
            constrained=make.zeros(node_count, wp.int32),
            node_counts=make.zeros(2, wp.int32),
        )


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class DelassusWork:
    """Scratch of the solves with the pairs' Delassus matrix, and its factor.

    Attributes:
        nodal: (n,) vec3d, impulses of the pairs at the nodes.
        y: (c,) vec3d, multipliers; r, p, q: residual, direction and product of the iteration.
        rank: (1,) int32, independent rows of the factor; -1 where there is none.
        codes: (r,) int32, of each row three times the number of its pair, plus its axis.
        chosen: (r,) int32, the independent rows in the order of their pivots.
        pivots: (r,) float64, what is left of the diagonal; lower: (r r,) float64, the factor.
    """

    nodal: DeviceArray
    y: DeviceArray
    r: DeviceArray
    p: DeviceArray
    q: DeviceArray
    rank: DeviceArray
    codes: DeviceArray
    chosen: DeviceArray
    pivots: DeviceArray
    lower: DeviceArray

    @staticmethod
    def of(count: int, node_count: int, make: Allocator) -> DelassusWork:
        """For so many pairs at most."""
        rows = {name: make.zeros(count, wp.vec3d) for name in "yrpq"}
        return DelassusWork(
            nodal=make.zeros(node_count, wp.vec3d),
            rank=make.zeros(1, wp.int32),
            codes=make.zeros(MOST_ROWS, wp.int32),
            chosen=make.zeros(MOST_ROWS, wp.int32),
            pivots=make.zeros(MOST_ROWS, wp.float64),
            lower=make.zeros(MOST_ROWS * MOST_ROWS, wp.float64),
            **rows,
        )


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class NodeCandidates:
    """For each surface node the triangle that it may touch.

    Attributes:
        corners: (s,) vec3i, nodes of the triangle, -1 for none.
        weights: (s,) vec3, barycentric, of the point of it that is closest.
        normals: vec3, unit, outward; the first s of those of all pairs.
        gaps: (s,) scalar, m.
        deep: (s,) int32, the body that the node is deep inside of; -1 for none.
        areas: (s,) vec3, m^2, twice the areas of the triangles around the node, along its normal.
    """

    corners: DeviceArray
    weights: DeviceArray
    normals: DeviceArray
    gaps: DeviceArray
    deep: DeviceArray
    areas: DeviceArray

    @staticmethod
    def of(count: int, normals: DeviceArray, make: Allocator) -> NodeCandidates:
        """For so many surface nodes; ``normals`` are those of all pairs."""
        types = make.types
        return NodeCandidates(
            corners=make.zeros(count, wp.vec3i),
            weights=make.zeros(count, types.vec3),
            normals=normals,
            gaps=make.zeros(count, types.scalar),
            deep=make.zeros(count, wp.int32),
            areas=make.zeros(count, types.vec3),
        )


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class EdgeCandidates:
    """For each half of an edge the edge of another body that it may cross.

    Attributes:
        crossed: (2 e,) int32, the other edge, -1 for none.
        places: (2 e,) vec4, weights of the ends of both, those of the other negative.
        normals: (2 e,) vec3, unit, along the common normal.
        gaps: (2 e,) scalar, m.
        deep: (e,) int32, the body that the edge leads through; -1 for none.
        inner: (e,) scalar, a place along the edge, 0 to 1, that is inside of it.
    """

    crossed: DeviceArray
    places: DeviceArray
    normals: DeviceArray
    gaps: DeviceArray
    deep: DeviceArray
    inner: DeviceArray

    @staticmethod
    def of(count: int, make: Allocator) -> EdgeCandidates:
        """For so many edges."""
        types = make.types
        return EdgeCandidates(
            crossed=make.zeros(2 * count, wp.int32),
            places=make.zeros(2 * count, types.vec4),
            normals=make.zeros(2 * count, types.vec3),
            gaps=make.zeros(2 * count, types.scalar),
            deep=make.zeros(count, wp.int32),
            inner=make.zeros(count, types.scalar),
        )
