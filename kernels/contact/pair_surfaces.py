"""The surfaces of all bodies as the kernels that look for pairs see them."""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.precision import real
from warp_softbody.kernels.widening import make_widening

SUBJECT = "pair_detection"

TILT = (0.0137, 0.0091)
"""Slope of the rays that tell inside from outside against the axes, so that none runs along a
face or through an edge of a body that stands in line with them."""


@cache
def make_pair_surfaces(precision: str) -> SimpleNamespace:
    """Struct ``Surfaces``, kernels ``expect``, ``follow``, ``find_normals``, ``find_bounds``.

    And functions, among them ``inside(s, positions, p, body)`` and ``met(a, b, c, p, d)``.
    """
    types = real(precision)
    scalar, vec3 = types.scalar, types.vec3
    kernel, func = types.kernel(SUBJECT), types.func(SUBJECT)
    wide = make_widening(precision, SUBJECT).wide
    vec3d = wp.vec3d
    tilt_a, tilt_b = wp.constant(wp.float64(TILT[0])), wp.constant(wp.float64(TILT[1]))

    @wp.struct
    class Surfaces:
        """The surfaces of all bodies, of s nodes and f triangles.

        ``tree`` is the search tree over the triangles ``faces`` (f,), whose ``face_normals`` (f,)
        m^2 are twice their area long. ``nodes`` (s,) are the surface nodes and ``slots`` (n,) their
        places in it; ``sizes`` (s,) m the mean lengths of the edges around them. ``node_body`` (n,)
        and ``fixed`` (n,) are of all nodes, ``rest`` (n,) m their places at rest.

        ``rank`` (bodies,) orders bodies from the finest to the coarsest, ``low`` and ``high``
        (bodies,) m are the corners of the boxes around them. ``drift`` (1,) m/s is the mean
        velocity, ``fastest`` (1,) m/s the largest speed relative to it.
        """

        tree: wp.uint64
        nodes: wp.array(dtype=int)
        slots: wp.array(dtype=int)
        sizes: wp.array(dtype=scalar)
        node_body: wp.array(dtype=int)
        fixed: wp.array(dtype=int)
        rank: wp.array(dtype=int)
        faces: wp.array(dtype=wp.vec3i)
        face_normals: wp.array(dtype=vec3)
        rest: wp.array(dtype=vec3)
        low: wp.array(dtype=vec3)
        high: wp.array(dtype=vec3)
        drift: wp.array(dtype=vec3)
        fastest: wp.array(dtype=scalar)
        step_factors: wp.array(dtype=scalar)

    @kernel
    def expect(
        # model
        fixed: wp.array(dtype=int),
        # in
        handled: wp.array(dtype=vec3),
        velocities: wp.array(dtype=vec3),
        # out
        expected: wp.array(dtype=vec3),
    ):
        # velocities of the step to come, as far as they are known
        i = wp.tid()
        expected[i] = wp.where(fixed[i] != 0, handled[i], velocities[i])

    @kernel
    def follow(
        # in
        positions: wp.array(dtype=vec3),
        velocities: wp.array(dtype=vec3),
        # out
        tree_points: wp.array(dtype=wp.vec3f),
        drift: wp.array(dtype=vec3),
        fastest: wp.array(dtype=scalar),
    ):
        # the search tree works in single precision; the largest speed relative to the mean
        count = positions.shape[0]
        total = vec3d()
        for i in range(count):
            p, v = positions[i], velocities[i]
            tree_points[i] = wp.vec3f(wp.float32(p[0]), wp.float32(p[1]), wp.float32(p[2]))
            total += vec3d(wp.float64(v[0]), wp.float64(v[1]), wp.float64(v[2]))
        total /= wp.float64(count)
        mean = vec3(scalar(total[0]), scalar(total[1]), scalar(total[2]))
        largest = scalar(0.0)
        for i in range(count):
            largest = wp.max(largest, wp.length_sq(velocities[i] - mean))
        drift[0] = mean
        fastest[0] = wp.sqrt(largest)

    @func
    def crossed(k: wp.vec3i, points: wp.array(dtype=vec3)):
        return wp.cross(points[k[1]] - points[k[0]], points[k[2]] - points[k[0]])

    @func
    def blend(k: wp.vec3i, weights: vec3, points: wp.array(dtype=vec3)):
        return weights[0] * points[k[0]] + weights[1] * points[k[1]] + weights[2] * points[k[2]]

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

    @kernel
    def find_bounds(
        # model
        body_start: wp.array(dtype=int),
        # in
        positions: wp.array(dtype=vec3),
        # out
        low: wp.array(dtype=vec3),
        high: wp.array(dtype=vec3),
    ):
        b = wp.tid()
        least = positions[body_start[b]]
        most = least
        for i in range(body_start[b], body_start[b + 1]):
            least = wp.min(least, positions[i])
            most = wp.max(most, positions[i])
        low[b] = least
        high[b] = most

    @func
    def within(s: Surfaces, body: int, p: vec3, reach: scalar):
        # whether a point is in the box around a body, made larger by reach
        low, high = s.low[body], s.high[body]
        found = True
        for a in range(3):
            if p[a] < low[a] - reach or p[a] > high[a] + reach:
                found = False
        return found

    @func
    def sunk(s: Surfaces, body: int, low: vec3, high: vec3):
        # how deep a box is in that around a body; less than zero: how far apart they are
        return wp.min(wp.min(s.high[body] - low, high - s.low[body]))

    @func
    def met(a: vec3d, b: vec3d, c: vec3d, p: vec3d, d: vec3d):
        # where a ray meets a triangle: the weights of b and c, and how far along d; -1 where not
        e, f = b - a, c - a
        h = wp.cross(d, f)
        det = wp.dot(e, h)
        if det == wp.float64(0.0):
            return vec3d(wp.float64(0.0), wp.float64(0.0), wp.float64(-1.0))
        s = p - a
        u = wp.dot(s, h) / det
        q = wp.cross(s, e)
        v = wp.dot(d, q) / det
        if u < wp.float64(0.0) or v < wp.float64(0.0) or u + v > wp.float64(1.0):
            return vec3d(wp.float64(0.0), wp.float64(0.0), wp.float64(-1.0))
        return vec3d(u, v, wp.dot(f, q) / det)

    @func
    def box_around(p: vec3d, q: vec3d, reach: wp.float64):
        # lower and upper corner of a box around a segment
        low = wp.min(p, q) - vec3d(reach, reach, reach)
        high = wp.max(p, q) + vec3d(reach, reach, reach)
        return (
            wp.vec3f(wp.float32(low[0]), wp.float32(low[1]), wp.float32(low[2])),
            wp.vec3f(wp.float32(high[0]), wp.float32(high[1]), wp.float32(high[2])),
        )

    @func
    def inside(s: Surfaces, positions: wp.array(dtype=vec3), point: vec3, body: int):
        # a ray out of the body the shortest way, along an axis but for a tilt, meets its surface
        # an odd number of times
        if not within(s, body, point, scalar(0.0)):
            return False
        p = wide(point)
        low, high = wide(s.low[body]), wide(s.high[body])
        axis = int(0)
        way = wp.float64(1.0)
        length = high[0] - p[0]
        for a in range(3):
            if high[a] - p[a] < length:
                axis = a
                way = wp.float64(1.0)
                length = high[a] - p[a]
            if p[a] - low[a] < length:
                axis = a
                way = wp.float64(-1.0)
                length = p[a] - low[a]
        d = vec3d(tilt_a, tilt_b, tilt_a)
        d[axis] = way
        size = wp.length(high - low)
        length += wp.float64(1e-3) * size
        first, last = box_around(p, p + length * d, wp.float64(1e-5) * size)
        query = wp.mesh_query_aabb(s.tree, first, last)
        face = int(0)
        count = int(0)
        while wp.mesh_query_aabb_next(query, face):
            k = s.faces[face]
            if s.node_body[k[0]] == body:
                first_corner, second_corner = wide(positions[k[0]]), wide(positions[k[1]])
                third_corner = wide(positions[k[2]])
                if met(first_corner, second_corner, third_corner, p, d)[2] > wp.float64(0.0):
                    count += 1
        return count % 2 == 1

    functions = {
        "crossed": crossed,
        "blend": blend,
        "within": within,
        "sunk": sunk,
        "wide": wide,
        "met": met,
        "box_around": box_around,
        "inside": inside,
    }
    kernels = {
        "expect": expect,
        "follow": follow,
        "find_normals": find_normals,
        "find_bounds": find_bounds,
    }
    return SimpleNamespace(Surfaces=Surfaces, **functions, **kernels)
