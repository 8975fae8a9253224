"""Surface nodes that face a triangle of another body, or of their own.

One plane a node: the closest triangle whose outside looks at the node's own. A node behind a
triangle of another body must be inside of that body, so that nothing is met through a thin one. A
node inside that faces nothing near is left to ``pair_overlap``.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.contact.pair_surfaces import SUBJECT, make_pair_surfaces
from warp_softbody.kernels.contact.structs import make_pair_structs
from warp_softbody.kernels.contact.triangles import make_triangles
from warp_softbody.kernels.precision import real

FACING = -0.2
"""Cosine between two outward normals above which their surfaces do not face each other."""

ASIDE = 0.05
"""Part of an edge's length by which a node may stand beside a triangle and yet over it."""

CLOSE = 1e-3
"""Part of an edge's length below which it does not matter on which side of a surface a node is."""

DEEPEST = 1.0
"""Part of an edge's length up to which the closest face is the way out of another body."""

LEEWAY = 4.0
"""How much farther than the nearest side of the box around a body its facing face is looked for."""

DEEPEST_OF_ITSELF = 0.3
"""The same for a body's own faces, where inside and outside do not tell."""

THICKEST = 3.0
"""Thickness of a limb, in edges, up to which its sides are not taken for surfaces that met."""


@cache
def make_pair_detection(precision: str) -> SimpleNamespace:
    """Kernel ``detect``."""
    types = real(precision)
    scalar, vec3 = types.scalar, types.vec3
    kernel, func = types.kernel(SUBJECT), types.func(SUBJECT)
    closest_weights = make_triangles(precision, SUBJECT).closest_weights
    surfaces = make_pair_surfaces(precision)
    NodeCandidates = make_pair_structs(precision).NodeCandidates
    Surfaces, blend, crossed = surfaces.Surfaces, surfaces.blend, surfaces.crossed
    sunk, inside, wide = surfaces.sunk, surfaces.inside, surfaces.wide
    leeway = wp.constant(scalar(LEEWAY))
    box_around = surfaces.box_around
    facing, aside = wp.constant(scalar(FACING)), wp.constant(scalar(ASIDE))
    close, deepest = wp.constant(scalar(CLOSE)), wp.constant(scalar(DEEPEST))
    own_deepest = wp.constant(scalar(DEEPEST_OF_ITSELF))
    thickest = wp.constant(scalar(THICKEST))
    farthest = wp.constant(scalar(1e30))

    @func
    def joined(i: int, k: wp.vec3i, distance: scalar, edge: scalar, rest: wp.array(dtype=vec3)):
        # what has always been about as near is a notch; what has always been a little behind the
        # face is the other side of a limb
        p = rest[i]
        weights = closest_weights(rest[k[0]], rest[k[1]], rest[k[2]], p)
        away = p - blend(k, weights, rest)
        behind = wp.dot(crossed(k, rest), away) <= scalar(0.0)
        far = wp.length(away)
        return far < scalar(2.0) * distance or (behind and far < thickest * edge)

    @func
    def sunken(
        s: Surfaces,
        positions: wp.array(dtype=vec3),
        p: vec3,
        k: wp.vec3i,
        w: vec3,
        n: vec3,
        gap: scalar,
        edge: scalar,
    ):
        # whether a node behind a face is inside of its body; one that stands a little beside the
        # face is where the point below the face is
        body = s.node_body[k[0]]
        if inside(s, positions, p, body):
            return True
        if gap < -aside * edge:
            return False
        third = scalar(0.02) / scalar(3.0)
        inner = scalar(0.98) * w + vec3(third, third, third)
        return inside(s, positions, blend(k, inner, positions) + gap * n, body)

    @func
    def near_surface(
        s: Surfaces, positions: wp.array(dtype=vec3), p: vec3, body: int, reach: scalar
    ):
        # whether a body's surface is within reach
        first, last = box_around(wide(p), wide(p), wp.float64(reach))
        query = wp.mesh_query_aabb(s.tree, first, last)
        face = int(0)
        found = int(0)
        while wp.mesh_query_aabb_next(query, face):
            k = s.faces[face]
            if s.node_body[k[0]] == body:
                w = closest_weights(positions[k[0]], positions[k[1]], positions[k[2]], p)
                if wp.length(p - blend(k, w, positions)) < reach:
                    found = 1
        return found != 0

    @kernel
    def detect(
        # model
        s: Surfaces,
        fan_start: wp.array(dtype=int),
        fan_faces: wp.array(dtype=int),
        self_contact: int,
        # in
        positions: wp.array(dtype=vec3),
        velocities: wp.array(dtype=vec3),
        # out
        candidates: NodeCandidates,
    ):
        # a node without a partner gets no corners; deep: the body that a node is inside of
        c = wp.tid()
        i = s.nodes[c]
        p = positions[i]
        size = s.sizes[c]
        own_body = s.node_body[i]
        speed = s.fastest[0] + wp.length(velocities[i] - s.drift[0])
        margin = s.step_factors[0] * speed + aside * size
        # no deeper in a body than in the box around it
        box = scalar(-farthest)
        for body in range(s.low.shape[0]):
            if body != own_body:
                box = wp.max(box, sunk(s, body, p, p))
        reach = wp.min(deepest * size, leeway * box + aside * size)
        if self_contact != 0:
            reach = wp.max(reach, own_deepest * size)
        reach = wp.max(margin, reach)
        found = wp.vec3i(-1, -1, -1)
        found_weights = vec3()
        found_normal = vec3()
        found_gap = scalar(0.0)
        candidates.deep[c] = -1
        own = vec3()
        if self_contact != 0 or box > -margin:
            for f in range(fan_start[c], fan_start[c + 1]):
                own += s.face_normals[fan_faces[f]]
            candidates.areas[c] = own
            own = wp.normalize(own)
            first, last = box_around(wide(p), wide(p), wp.float64(reach))
            query = wp.mesh_query_aabb(s.tree, first, last)
            face = int(0)
            best = scalar(farthest)
            while wp.mesh_query_aabb_next(query, face):
                # most faces around a node are its own body's and look the same way
                n = s.face_normals[face]
                usable = wp.dot(n, own) < facing * wp.length(n)
                k = s.faces[face]
                same = s.node_body[k[0]] == own_body
                if same and (self_contact == 0 or k[0] == i or k[1] == i or k[2] == i):
                    usable = False
                if usable:
                    n = wp.normalize(n)
                    edge = wp.min(size, s.sizes[s.slots[k[0]]])
                    w = closest_weights(positions[k[0]], positions[k[1]], positions[k[2]], p)
                    away = p - blend(k, w, positions)
                    gap = wp.dot(n, away)
                    distance = wp.length(away)
                    if wp.length(away - gap * n) > aside * edge:
                        # an edge or a corner of the face is what is met
                        usable = gap >= scalar(0.0)
                        if usable:
                            n = away / distance
                            gap = distance
                    usable = usable and wp.dot(n, own) < facing and gap < margin
                    usable = usable and distance < best
                    if same:
                        usable = usable and gap > -own_deepest * edge
                        usable = usable and not joined(i, k, distance, edge, s.rest)
                    else:
                        usable = usable and gap > -deepest * edge
                        if usable and gap < -close * edge:
                            usable = sunken(s, positions, p, k, w, n, gap, edge)
                    if usable:
                        best = distance
                        found = k
                        found_weights = w
                        found_normal = n
                        found_gap = gap
            if found[0] < 0:
                for body in range(s.low.shape[0]):
                    other = body != own_body and candidates.deep[c] < 0
                    if other and inside(s, positions, p, body):
                        if not near_surface(s, positions, p, body, aside * size):
                            candidates.deep[c] = body
        candidates.corners[c] = found
        candidates.weights[c] = found_weights
        candidates.normals[c] = found_normal
        candidates.gaps[c] = found_gap

    return SimpleNamespace(detect=detect)
