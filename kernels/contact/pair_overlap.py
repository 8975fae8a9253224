"""Bodies that are deep in each other: which way out, and the pairs that push them that way.

A node inside of a body that faces none of its near triangles is deep, and so is an edge that leads
through a body from outside to outside. Two bodies with such nodes and edges are pushed apart as
wholes, against the part of each surface that lies in the other: the way in which their common
volume shrinks fastest. Where that adds up to nothing, one body being all inside of the other, they
are pushed from middle to middle. A deep node is paired with the triangle where the way leads out,
an edge with the side of it that is nearest to that place; such pairs have no friction.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.contact.pair_edges import make_pair_edges
from warp_softbody.kernels.contact.pair_surfaces import SUBJECT, make_pair_surfaces
from warp_softbody.kernels.contact.structs import make_pair_structs
from warp_softbody.kernels.precision import real

BURIED = 0.05
"""Part of an edge's length, or of a thin body's thickness, that a point must be within the
box around a body."""

ONE_SIDED = 0.1
"""Part of the area inside that its vectors must add up to, to tell the way out."""


@cache
def make_pair_overlap(precision: str) -> SimpleNamespace:
    """Kernels ``sink_edges``, ``find_ways``, ``leave`` and ``draw_out``, after ``detect``."""
    types = real(precision)
    scalar, vec3, vec4 = types.scalar, types.vec3, types.vec4
    kernel, func = types.kernel(SUBJECT), types.func(SUBJECT)
    surfaces = make_pair_surfaces(precision)
    Surfaces, wide, met = surfaces.Surfaces, surfaces.wide, surfaces.met
    box_around, within, inside = surfaces.box_around, surfaces.within, surfaces.inside
    Edges = make_pair_edges(precision).Edges
    structs = make_pair_structs(precision)
    NodeCandidates, EdgeCandidates = structs.NodeCandidates, structs.EdgeCandidates
    buried = wp.constant(scalar(BURIED))
    tiny = wp.constant(scalar(types.tiny))
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

    @func
    def overlap(s: Surfaces, a: int, b: int, depth: scalar):
        # whether the boxes around two bodies are so deep in each other
        low, high = wp.max(s.low[a], s.low[b]), wp.min(s.high[a], s.high[b])
        return wp.min(high - low) > depth

    @func
    def part_within(s: Surfaces, body: int, p: vec3, q: vec3):
        # where a segment enters the box around a body and where it leaves it, as parts of it
        first, last = scalar(0.0), scalar(1.0)
        for a in range(3):
            d = q[a] - p[a]
            if wp.abs(d) > tiny:
                one = (s.low[body][a] - p[a]) / d
                two = (s.high[body][a] - p[a]) / d
                first = wp.max(first, wp.min(one, two))
                last = wp.min(last, wp.max(one, two))
        return first, wp.max(first, last)

    @kernel
    def sink_edges(
        # model
        s: Surfaces,
        edges: Edges,
        # in
        positions: wp.array(dtype=vec3),
        nodes: NodeCandidates,
        # out
        candidates: EdgeCandidates,
    ):
        # the body that an edge leads through, and a place along it that is inside
        e = wp.tid()
        candidates.deep[e] = -1
        k = edges.ends[e]
        i, j = s.slots[k[0]], s.slots[k[1]]
        if nodes.deep[i] >= 0 or nodes.deep[j] >= 0:
            return
        if nodes.corners[i][0] >= 0 or nodes.corners[j][0] >= 0:
            return
        p, q = positions[k[0]], positions[k[1]]
        own, size = s.node_body[k[0]], wp.min(s.sizes[i], s.sizes[j])
        for body in range(s.low.shape[0]):
            thin = wp.min(size, wp.min(s.high[body] - s.low[body]))
            if body != own and candidates.deep[e] < 0 and overlap(s, own, body, buried * thin):
                first, last = part_within(s, body, p, q)
                for part in range(3):
                    place = first + scalar(0.25) * scalar(part + 1) * (last - first)
                    middle = p + place * (q - p)
                    if within(s, body, middle, -buried * thin) and candidates.deep[e] < 0:
                        if inside(s, positions, middle, body):
                            candidates.deep[e] = body
                            candidates.inner[e] = place

    @func
    def note(
        s: Surfaces,
        a: int,
        b: int,
        area: vec3,
        ways: wp.array(dtype=vec3),
        total: wp.array(dtype=scalar),
    ):
        # a part of the surface of body a that lies in body b
        bodies = s.low.shape[0]
        ways[a * bodies + b] = ways[a * bodies + b] - area
        ways[b * bodies + a] = ways[b * bodies + a] + area
        total[a * bodies + b] = total[a * bodies + b] + wp.length(area)
        total[b * bodies + a] = total[b * bodies + a] + wp.length(area)

    @kernel
    def find_ways(
        # model
        s: Surfaces,
        edges: Edges,
        # in
        nodes: NodeCandidates,
        crossing: EdgeCandidates,
        # out
        ways: wp.array(dtype=vec3),
        total: wp.array(dtype=scalar),
        overlaps: wp.array(dtype=int),
    ):
        # way a * bodies + b: of body a out of body b, a unit vector
        bodies = s.low.shape[0]
        count = int(0)
        for c in range(nodes.deep.shape[0]):
            if nodes.deep[c] >= 0:
                count += 1
        for e in range(crossing.deep.shape[0]):
            if crossing.deep[e] >= 0:
                count += 1
        overlaps[0] = count
        if count > 0:
            for k in range(bodies * bodies):
                ways[k] = vec3()
                total[k] = scalar(0.0)
            for c in range(nodes.deep.shape[0]):
                a = s.node_body[s.nodes[c]]
                b = nodes.deep[c]
                if nodes.corners[c][0] >= 0 and nodes.gaps[c] < scalar(0.0):
                    b = s.node_body[nodes.corners[c][0]]
                if b >= 0 and b != a:
                    note(s, a, b, nodes.areas[c], ways, total)
            for e in range(crossing.deep.shape[0]):
                if crossing.deep[e] >= 0:
                    a = s.node_body[edges.ends[e][0]]
                    for side in range(2):
                        area = s.face_normals[edges.faces[e][side]]
                        note(s, a, crossing.deep[e], area, ways, total)
            for a in range(bodies):
                for b in range(bodies):
                    k = a * bodies + b
                    if total[k] > scalar(0.0):
                        if wp.length(ways[k]) > one_sided * total[k]:
                            ways[k] = wp.normalize(ways[k])
                        else:
                            ways[k] = from_middle(s, a, b)

    @func
    def way_out(s: Surfaces, positions: wp.array(dtype=vec3), p: vec3, body: int, way: vec3):
        # the face where a way from inside leads out of a body, the weights of its second and third
        # corner, and how far that is
        start, d = wide(p), wide(way)
        length = wp.float64(wp.length(s.high[body] - s.low[body]))
        first, last = box_around(start, start + length * d, wp.float64(1e-5) * length)
        query = wp.mesh_query_aabb(s.tree, first, last)
        face = int(0)
        found = int(-1)
        best = wp.vec3d(wp.float64(0.0), wp.float64(0.0), length)
        while wp.mesh_query_aabb_next(query, face):
            k = s.faces[face]
            if s.node_body[k[0]] == body and wp.dot(s.face_normals[face], way) > scalar(0.0):
                a, b, c = wide(positions[k[0]]), wide(positions[k[1]]), wide(positions[k[2]])
                hit = met(a, b, c, start, d)
                if hit[2] > wp.float64(0.0) and hit[2] < best[2]:
                    best = hit
                    found = face
        return found, vec3(scalar(best[0]), scalar(best[1]), scalar(best[2]))

    @kernel
    def leave(
        # model
        s: Surfaces,
        # in
        positions: wp.array(dtype=vec3),
        ways: wp.array(dtype=vec3),
        # in and out
        nodes: NodeCandidates,
        # out
        friction_factor: wp.array(dtype=scalar),
    ):
        c = wp.tid()
        i = s.nodes[c]
        body = nodes.deep[c]
        friction_factor[c] = scalar(1.0)
        if body >= 0:
            way = ways[s.node_body[i] * s.low.shape[0] + body]
            face, hit = way_out(s, positions, positions[i], body, way)
            if face >= 0:
                nodes.corners[c] = s.faces[face]
                nodes.weights[c] = vec3(scalar(1.0) - hit[0] - hit[1], hit[0], hit[1])
                nodes.normals[c] = way
                nodes.gaps[c] = -hit[2]
                friction_factor[c] = scalar(0.0)

    @func
    def split(a: scalar, b: scalar):
        return b / wp.max(a + b, tiny)

    @kernel
    def draw_out(
        # model
        s: Surfaces,
        edges: Edges,
        # in
        positions: wp.array(dtype=vec3),
        ways: wp.array(dtype=vec3),
        # in and out
        crossing: EdgeCandidates,
    ):
        e = wp.tid()
        body = crossing.deep[e]
        if body >= 0:
            k = edges.ends[e]
            way = ways[s.node_body[k[0]] * s.low.shape[0] + body]
            p = positions[k[0]] + crossing.inner[e] * (positions[k[1]] - positions[k[0]])
            face, hit = way_out(s, positions, p, body, way)
            if face >= 0:
                # the side across from the corner that is farthest
                w = vec3(scalar(1.0) - hit[0] - hit[1], hit[0], hit[1])
                side = int(0)
                if w[0] < w[1] and w[0] <= w[2]:
                    side = 1
                elif w[1] < w[2] and w[1] <= w[0]:
                    side = 2
                f = edges.of_face[face][side]
                corner = s.faces[face]
                t = split(w[side], w[(side + 1) % 3])
                if edges.ends[f][0] != corner[side]:
                    t = scalar(1.0) - t
                crossing.crossed[2 * e] = f
                crossing.crossed[2 * e + 1] = -1
                crossing.places[2 * e] = vec4(
                    scalar(1.0) - crossing.inner[e], crossing.inner[e], t - scalar(1.0), -t
                )
                crossing.normals[2 * e] = way
                crossing.gaps[2 * e] = -hit[2]

    return SimpleNamespace(
        sink_edges=sink_edges, find_ways=find_ways, leave=leave, draw_out=draw_out
    )
