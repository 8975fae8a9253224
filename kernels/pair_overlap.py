"""Bodies that are deep in each other: which way out, and the pairs that push them that way.

A node inside of a body that faces none of its near triangles is deep. Two bodies with such nodes
are pushed apart as wholes, against the part of each surface that lies in the other: the way in
which their common volume shrinks fastest. Where that adds up to nothing, one body being all inside
of the other, they are pushed from middle to middle. A deep node is paired with the triangle where
the way leads out; such pairs have no friction.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.pair_surfaces import SUBJECT, make_pair_surfaces
from warp_softbody.kernels.precision import real

ONE_SIDED = 0.1
"""Part of the area inside that its vectors must add up to, to tell the way out."""


@cache
def make_pair_overlap(precision: str) -> SimpleNamespace:
    """Kernels ``find_ways`` and ``leave``, in this order after ``detect``."""
    types = real(precision)
    scalar, vec3 = types.scalar, types.vec3
    kernel, func = types.kernel(SUBJECT), types.func(SUBJECT)
    surfaces = make_pair_surfaces(precision)
    Surfaces, wide, met = surfaces.Surfaces, surfaces.wide, surfaces.met
    box_around = surfaces.box_around
    one_sided = wp.constant(scalar(ONE_SIDED))

    @func
    def from_middle(s: Surfaces, a: int, b: int):
        # the way from the middle of body b to that of a; up where they are the same
        size = wp.length(s.high[a] - s.low[a]) + wp.length(s.high[b] - s.low[b])
        away = s.low[a] + s.high[a] - s.low[b] - s.high[b]
        if wp.length(away) < scalar(1e-6) * size:
            up = wp.where(s.rank[a] < s.rank[b], scalar(1.0), scalar(-1.0))
            return vec3(scalar(0.0), scalar(0.0), up)
        return wp.normalize(away)

    @kernel
    def find_ways(
        # in
        s: Surfaces,
        areas: wp.array(dtype=vec3),
        corners: wp.array(dtype=wp.vec3i),
        gaps: wp.array(dtype=scalar),
        deep: wp.array(dtype=int),
        # out
        ways: wp.array(dtype=vec3),
        total: wp.array(dtype=scalar),
        overlaps: wp.array(dtype=int),
    ):
        # way a * bodies + b: of body a out of body b, a unit vector
        bodies = s.low.shape[0]
        count = int(0)
        for c in range(deep.shape[0]):
            if deep[c] >= 0:
                count += 1
        overlaps[0] = count
        if count > 0:
            for k in range(bodies * bodies):
                ways[k] = vec3()
                total[k] = scalar(0.0)
            for c in range(deep.shape[0]):
                a = s.node_body[s.nodes[c]]
                b = deep[c]
                if corners[c][0] >= 0 and gaps[c] < scalar(0.0):
                    b = s.node_body[corners[c][0]]
                if b >= 0 and b != a:
                    ways[a * bodies + b] = ways[a * bodies + b] - areas[c]
                    ways[b * bodies + a] = ways[b * bodies + a] + areas[c]
                    size = wp.length(areas[c])
                    total[a * bodies + b] = total[a * bodies + b] + size
                    total[b * bodies + a] = total[b * bodies + a] + size
            for a in range(bodies):
                for b in range(bodies):
                    k = a * bodies + b
                    if total[k] > scalar(0.0):
                        if wp.length(ways[k]) > one_sided * total[k]:
                            ways[k] = wp.normalize(ways[k])
                        else:
                            ways[k] = from_middle(s, a, b)

    @kernel
    def leave(
        # in
        s: Surfaces,
        positions: wp.array(dtype=vec3),
        deep: wp.array(dtype=int),
        ways: wp.array(dtype=vec3),
        # out
        corners: wp.array(dtype=wp.vec3i),
        weights: wp.array(dtype=vec3),
        normals: wp.array(dtype=vec3),
        gaps: wp.array(dtype=scalar),
        roughness: wp.array(dtype=scalar),
    ):
        c = wp.tid()
        i = s.nodes[c]
        body = deep[c]
        roughness[c] = scalar(1.0)
        if body >= 0:
            way = ways[s.node_body[i] * s.low.shape[0] + body]
            p, d = wide(positions[i]), wide(way)
            length = wp.float64(wp.length(s.high[body] - s.low[body]))
            first, last = box_around(p, p + length * d, wp.float64(1e-5) * length)
            query = wp.mesh_query_aabb(s.tree, first, last)
            face = int(0)
            while wp.mesh_query_aabb_next(query, face):
                k = s.faces[face]
                if s.node_body[k[0]] == body and wp.dot(s.face_normals[face], way) > scalar(0.0):
                    a, b, e = wide(positions[k[0]]), wide(positions[k[1]]), wide(positions[k[2]])
                    hit = met(a, b, e, p, d)
                    if hit[2] > wp.float64(0.0) and hit[2] < length:
                        length = hit[2]
                        u, v = scalar(hit[0]), scalar(hit[1])
                        corners[c] = k
                        weights[c] = vec3(scalar(1.0) - u - v, u, v)
                        normals[c] = way
                        gaps[c] = -scalar(length)
                        roughness[c] = scalar(0.0)

    return SimpleNamespace(find_ways=find_ways, leave=leave)
