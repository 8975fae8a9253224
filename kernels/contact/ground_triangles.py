"""Where surface nodes stand to a static triangle mesh: the closest point of it, and which side.

Warp's search tree, in single precision, finds the closest triangle; the closest point on it is
computed in the precision asked for. The normal of the closest feature tells the side: that of the
face, the mean of two faces at an edge, the mean by angle at a vertex (Baerentzen & Aanaes 2005).
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.contact.triangles import make_triangles
from warp_softbody.kernels.precision import real

SUBJECT = "ground_triangles"


@cache
def make_ground_triangles(precision: str) -> SimpleNamespace:
    """Struct ``TriangleSurface``, kernels ``detect`` and ``measure``."""
    types = real(precision)
    scalar, vec3, vec4 = types.scalar, types.vec3, types.vec4
    kernel, func = types.kernel(SUBJECT), types.func(SUBJECT)

    closest_weights = make_triangles(precision, SUBJECT).closest_weights

    @wp.struct
    class TriangleSurface:
        tree: wp.uint64
        vertices: wp.array(dtype=vec3)
        faces: wp.array(dtype=wp.vec3i)
        face_normals: wp.array(dtype=vec3)
        edge_normals: wp.array2d(dtype=vec3)
        vertex_normals: wp.array(dtype=vec3)
        reach: scalar

    @func
    def feature_normal(surface: TriangleSurface, face: int, weights: vec3):
        zeros = int(0)
        empty = int(0)
        largest = int(0)
        for k in range(3):
            if weights[k] == scalar(0.0):
                zeros += 1
                empty = k
            else:
                largest = k
        if zeros == 0:
            return surface.face_normals[face]
        if zeros == 1:
            return surface.edge_normals[face, empty]
        return surface.vertex_normals[surface.faces[face][largest]]

    @func
    def side(surface: TriangleSurface, p: vec3):
        # outward normal and signed distance
        nearest = wp.vec3f(wp.float32(p[0]), wp.float32(p[1]), wp.float32(p[2]))
        reach = surface.reach
        query = wp.mesh_query_point_no_sign(surface.tree, nearest, wp.float32(reach))
        if not query.result:
            return vec4(scalar(0.0), scalar(0.0), scalar(1.0), reach)
        k = surface.faces[query.face]
        a, b, c = surface.vertices[k[0]], surface.vertices[k[1]], surface.vertices[k[2]]
        weights = closest_weights(a, b, c, p)
        q = weights[0] * a + weights[1] * b + weights[2] * c
        n = feature_normal(surface, query.face, weights)
        away = p - q
        gap = wp.dot(n, away)
        distance = wp.length(away)
        inside_face = weights[0] * weights[1] * weights[2] > scalar(0.0)
        if not inside_face and distance > scalar(1e-5) * reach:
            n = wp.sign(gap) * away / distance
            gap = wp.sign(gap) * distance
        return vec4(n[0], n[1], n[2], gap)

    @kernel
    def detect(
        # model
        surface_nodes: wp.array(dtype=int),
        surface: TriangleSurface,
        recovery_speed: scalar,
        step_factors: wp.array(dtype=scalar),
        # in
        positions: wp.array(dtype=vec3),
        # out
        normal_velocity: wp.array(dtype=scalar),
        normals: wp.array(dtype=vec3),
    ):
        c = wp.tid()
        i = surface_nodes[c]
        found = side(surface, positions[i])
        normals[i] = vec3(found[0], found[1], found[2])
        normal_velocity[c] = wp.min(-found[3] / step_factors[0], recovery_speed)

    @types.kernel(SUBJECT, "measure")
    def measure(
        # model
        surface: TriangleSurface,
        # in
        points: wp.array(dtype=vec3),
        # out
        found: wp.array(dtype=vec4),
    ):
        # outward normal and signed distance of any points
        k = wp.tid()
        found[k] = side(surface, points[k])

    return SimpleNamespace(TriangleSurface=TriangleSurface, detect=detect, measure=measure)
