"""Edges of one body across edges of another, where both are sharp and no node is met.

Of two bodies the finer one's edges look for the other's. Each half of an edge takes the closest
edge that crosses it: two segments at their nearest points, one on each side along their common
normal, and that normal within the outer side of both edges. So what meets is an edge on an edge,
and no face. Parallel edges meet by their nodes. Edges of one body do not meet each other.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.contact.pair_surfaces import SUBJECT, make_pair_surfaces
from warp_softbody.kernels.contact.structs import make_pair_structs
from warp_softbody.kernels.precision import real

SHARP = 0.95
"""Cosine between the normals of two faces below which the edge between them is sharp."""

PARALLEL = 0.1
"""Sine of the angle between two edges below which they do not cross."""

OUTER = 0.1
"""Sine of the angle by which a normal may leave the outer side of an edge."""

DEEPEST = 0.5
"""Part of an edge's length up to which crossing edges push each other back."""

END = 0.01
"""Part of an edge at either end that belongs to the node."""

CLOSE = 1e-3
"""Part of an edge's length below which it does not matter on which side of a surface an edge is."""


@cache
def make_pair_edges(precision: str) -> SimpleNamespace:
    """Kernel ``cross_edges``."""
    types = real(precision)
    scalar, vec3, vec4 = types.scalar, types.vec3, types.vec4
    kernel, func = types.kernel(SUBJECT), types.func(SUBJECT)
    surfaces = make_pair_surfaces(precision)
    EdgeCandidates = make_pair_structs(precision).EdgeCandidates
    Surfaces, sunk, inside = surfaces.Surfaces, surfaces.sunk, surfaces.inside
    wide, box_around = surfaces.wide, surfaces.box_around
    sharp, parallel = wp.constant(scalar(SHARP)), wp.constant(scalar(PARALLEL))
    outer, deepest = wp.constant(scalar(OUTER)), wp.constant(scalar(DEEPEST))
    end, close = wp.constant(scalar(END)), wp.constant(scalar(CLOSE))
    farthest = wp.constant(scalar(1e30))

    @wp.struct
    class Edges:
        """The edges of the surfaces.

        ``ends`` are their two nodes, ``faces`` the triangles at both sides, ``opposite`` the third
        nodes of those, and ``of_face`` the three edges of each triangle.
        """

        ends: wp.array(dtype=wp.vec2i)
        faces: wp.array(dtype=wp.vec2i)
        opposite: wp.array(dtype=wp.vec2i)
        of_face: wp.array(dtype=wp.vec3i)

    @func
    def is_sharp(s: Surfaces, faces: wp.vec2i):
        m, n = s.face_normals[faces[0]], s.face_normals[faces[1]]
        return wp.dot(m, n) < sharp * wp.length(m) * wp.length(n)

    @func
    def looks_out(edges: Edges, e: int, positions: wp.array(dtype=vec3), way: vec3):
        # whether a normal to an edge leads away from both of its faces
        k = edges.ends[e]
        p = positions[k[0]]
        along = wp.normalize(positions[k[1]] - p)
        out = True
        for side in range(2):
            into = positions[edges.opposite[e][side]] - p
            into -= wp.dot(into, along) * along
            if wp.dot(into, way) > outer * wp.length(into):
                out = False
        return out

    @kernel
    def cross_edges(
        # model
        s: Surfaces,
        edges: Edges,
        # in
        positions: wp.array(dtype=vec3),
        velocities: wp.array(dtype=vec3),
        # out
        candidates: EdgeCandidates,
    ):
        # slot 2 e + half: the other edge, or -1; the places of the points on both: 1 - s, s and
        # t - 1, -t
        e = wp.tid()
        candidates.crossed[2 * e] = -1
        candidates.crossed[2 * e + 1] = -1
        k = edges.ends[e]
        p, q = positions[k[0]], positions[k[1]]
        own_body = s.node_body[k[0]]
        size = wp.min(s.sizes[s.slots[k[0]]], s.sizes[s.slots[k[1]]])
        speed = s.fastest[0]
        speed += wp.max(
            wp.length(velocities[k[0]] - s.drift[0]), wp.length(velocities[k[1]] - s.drift[0])
        )
        margin = s.step_factors[0] * speed + close * size
        box = scalar(-farthest)
        for body in range(s.low.shape[0]):
            if s.rank[body] > s.rank[own_body]:
                box = wp.max(box, sunk(s, body, wp.min(p, q), wp.max(p, q)))
        if box < -margin:
            return
        reach = wp.max(margin, wp.min(deepest * size, box))
        if not is_sharp(s, edges.faces[e]):
            return
        best_first = scalar(farthest)
        best_second = scalar(farthest)
        first, last = box_around(wide(p), wide(q), wp.float64(reach))
        query = wp.mesh_query_aabb(s.tree, first, last)
        face = int(0)
        while wp.mesh_query_aabb_next(query, face):
            body = s.node_body[s.faces[face][0]]
            if s.rank[body] > s.rank[own_body]:
                for side in range(3):
                    f = edges.of_face[face][side]
                    # each edge once
                    if edges.faces[f][0] == face and is_sharp(s, edges.faces[f]):
                        j = edges.ends[f]
                        a, b, r = q - p, positions[j[1]] - positions[j[0]], p - positions[j[0]]
                        n = wp.cross(a, b)
                        square = wp.length_sq(n)
                        aa, bb, ab = wp.length_sq(a), wp.length_sq(b), wp.dot(a, b)
                        if square > parallel * parallel * aa * bb:
                            n = n / wp.sqrt(square)
                            ra, rb = wp.dot(r, a), wp.dot(r, b)
                            u = (ab * rb - bb * ra) / square
                            v = (aa * rb - ab * ra) / square
                            m = s.face_normals[edges.faces[f][0]]
                            m += s.face_normals[edges.faces[f][1]]
                            if wp.dot(n, m) < scalar(0.0):
                                n = -n
                            gap = wp.dot(n, r)
                            usable = u > end and u < scalar(1.0) - end
                            usable = usable and v > end and v < scalar(1.0) - end
                            usable = usable and gap < margin and gap > -deepest * size
                            usable = usable and looks_out(edges, f, positions, n)
                            usable = usable and looks_out(edges, e, positions, -n)
                            best = best_first
                            slot = 2 * e
                            if u > scalar(0.5):
                                best = best_second
                                slot = 2 * e + 1
                            usable = usable and wp.abs(gap) < best
                            if usable and gap < -close * size:
                                usable = inside(s, positions, p + u * a, body)
                            if usable:
                                if u > scalar(0.5):
                                    best_second = wp.abs(gap)
                                else:
                                    best_first = wp.abs(gap)
                                candidates.crossed[slot] = f
                                candidates.places[slot] = vec4(
                                    scalar(1.0) - u, u, v - scalar(1.0), -v
                                )
                                candidates.normals[slot] = n
                                candidates.gaps[slot] = gap

    return SimpleNamespace(Edges=Edges, cross_edges=cross_edges)
