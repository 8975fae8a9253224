"""Surface nodes that face a triangle of another body, or of their own.

One plane a node: the closest triangle whose outside looks at the node's own. Edges against edges
are not looked for. Where the nodes of two flat surfaces meet the triangles of each other, half of
these pairs would repeat the other half, and hold together what may shear: a node gives way where
the corners of its triangle have partners as close.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.precision import real
from warp_softbody.kernels.triangles import make_triangles

SUBJECT = "pair_detection"

FACING = -0.2
"""Cosine between two outward normals above which their surfaces do not face each other."""

AS_CLOSE = 0.02
"""Part of an edge's length by which a node may be nearer than the corners that stand for it."""

ASIDE = 0.05
"""Part of an edge's length by which a node may stand beside a triangle and yet over it."""


THICKEST = 3.0
"""Thickness of a limb, in mean edges, up to which its sides are not taken for surfaces that met."""


@cache
def make_pair_detection(precision: str) -> SimpleNamespace:
    """Kernels ``follow``, ``find_normals``, ``detect`` and ``thin_out``, in this order."""
    types = real(precision)
    scalar, vec3 = types.scalar, types.vec3
    kernel, func = types.kernel(SUBJECT), types.func(SUBJECT)
    closest_weights = make_triangles(precision, SUBJECT).closest_weights
    facing, aside = wp.constant(scalar(FACING)), wp.constant(scalar(ASIDE))
    as_close, thickest = wp.constant(scalar(AS_CLOSE)), wp.constant(scalar(THICKEST))

    @kernel
    def follow(
        # in
        positions: wp.array(dtype=vec3),
        velocities: wp.array(dtype=vec3),
        # out
        tree_points: wp.array(dtype=wp.vec3f),
        fastest: wp.array(dtype=scalar),
    ):
        # the search tree works in single precision
        largest = scalar(0.0)
        for i in range(positions.shape[0]):
            p = positions[i]
            tree_points[i] = wp.vec3f(wp.float32(p[0]), wp.float32(p[1]), wp.float32(p[2]))
            largest = wp.max(largest, wp.length_sq(velocities[i]))
        fastest[0] = wp.sqrt(largest)

    @func
    def crossed(k: wp.vec3i, points: wp.array(dtype=vec3)):
        return wp.cross(points[k[1]] - points[k[0]], points[k[2]] - points[k[0]])

    @kernel
    def find_normals(
        # model
        faces: wp.array(dtype=wp.vec3i),
        # in
        positions: wp.array(dtype=vec3),
        # out
        face_normals: wp.array(dtype=vec3),
    ):
        # twice the area long
        face = wp.tid()
        face_normals[face] = crossed(faces[face], positions)

    @func
    def blend(k: wp.vec3i, weights: vec3, points: wp.array(dtype=vec3)):
        return weights[0] * points[k[0]] + weights[1] * points[k[1]] + weights[2] * points[k[2]]

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

    @kernel
    def detect(
        # model
        surface_nodes: wp.array(dtype=int),
        node_body: wp.array(dtype=int),
        tree: wp.uint64,
        faces: wp.array(dtype=wp.vec3i),
        fan_start: wp.array(dtype=int),
        fan_faces: wp.array(dtype=int),
        rest: wp.array(dtype=vec3),
        lengths: wp.array(dtype=scalar),
        self_contact: int,
        step_factors: wp.array(dtype=scalar),
        # in
        positions: wp.array(dtype=vec3),
        velocities: wp.array(dtype=vec3),
        fastest: wp.array(dtype=scalar),
        face_normals: wp.array(dtype=vec3),
        # out
        corners: wp.array(dtype=wp.vec3i),
        weights: wp.array(dtype=vec3),
        normals: wp.array(dtype=vec3),
        gaps: wp.array(dtype=scalar),
    ):
        # lengths: mean edge of the finest body, recovery speed, how deep a node may be. A node
        # without a partner gets no corners.
        c = wp.tid()
        i = surface_nodes[c]
        p = positions[i]
        edge = lengths[0]
        dt = step_factors[0]
        margin = dt * (fastest[0] + wp.length(velocities[i])) + aside * edge
        depth = lengths[2]
        own = vec3()
        for f in range(fan_start[c], fan_start[c + 1]):
            own += face_normals[fan_faces[f]]
        own = wp.normalize(own)
        reach = wp.float32(wp.max(margin, depth))
        middle = wp.vec3f(wp.float32(p[0]), wp.float32(p[1]), wp.float32(p[2]))
        extent = wp.vec3f(reach, reach, reach)
        query = wp.mesh_query_aabb(tree, middle - extent, middle + extent)
        face = int(0)
        best = scalar(1e30)
        found = wp.vec3i(-1, -1, -1)
        found_weights = vec3()
        found_normal = vec3()
        found_gap = scalar(0.0)
        while wp.mesh_query_aabb_next(query, face):
            # most faces around a node are its own body's and look the same way
            n = face_normals[face]
            usable = wp.dot(n, own) < facing * wp.length(n)
            k = faces[face]
            same = node_body[k[0]] == node_body[i]
            if same and (self_contact == 0 or k[0] == i or k[1] == i or k[2] == i):
                usable = False
            if usable:
                n = wp.normalize(n)
                w = closest_weights(positions[k[0]], positions[k[1]], positions[k[2]], p)
                away = p - blend(k, w, positions)
                gap = wp.dot(n, away)
                distance = wp.length(away)
                beside = wp.length(away - gap * n)
                if beside > aside * edge:
                    # an edge or a corner of the face is what is met
                    usable = gap >= scalar(0.0)
                    if usable:
                        n = away / distance
                        gap = distance
                usable = usable and wp.dot(n, own) < facing
                usable = usable and gap < margin and gap > -depth
                if usable and same:
                    usable = not joined(i, k, distance, edge, rest)
                if usable and distance < best:
                    best = distance
                    found = k
                    found_weights = w
                    found_normal = n
                    found_gap = gap
        corners[c] = found
        weights[c] = found_weights
        normals[c] = found_normal
        gaps[c] = found_gap

    @kernel
    def thin_out(
        # model
        surface_nodes: wp.array(dtype=int),
        slots: wp.array(dtype=int),
        node_body: wp.array(dtype=int),
        lengths: wp.array(dtype=scalar),
        step_factors: wp.array(dtype=scalar),
        # in
        found: wp.array(dtype=wp.vec3i),
        weights: wp.array(dtype=vec3),
        gaps: wp.array(dtype=scalar),
        # out
        corners: wp.array(dtype=wp.vec3i),
        least: wp.array(dtype=scalar),
        modes: wp.array(dtype=int),
    ):
        # of two bodies the one named first gives way; in one body the higher number
        c = wp.tid()
        i = surface_nodes[c]
        k = found[c]
        least[c] = wp.min(-gaps[c] / step_factors[0], lengths[1])
        if k[0] >= 0:
            body = node_body[i]
            covered = body < node_body[k[0]]
            if body == node_body[k[0]]:
                covered = i > k[0] and i > k[1] and i > k[2]
            gap = scalar(0.0)
            for a in range(3):
                slot = slots[k[a]]
                back = found[slot]
                if back[0] < 0:
                    covered = False
                elif node_body[back[0]] != body:
                    covered = False
                gap += weights[c][a] * gaps[slot]
            if covered and gap < gaps[c] + as_close * lengths[0]:
                k = wp.vec3i(-1, -1, -1)
        corners[c] = k
        if k[0] < 0:
            modes[c] = 0

    return SimpleNamespace(
        follow=follow, find_normals=find_normals, detect=detect, thin_out=thin_out
    )
