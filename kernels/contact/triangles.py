"""What kernels over triangles share."""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.precision import real


@cache
def make_triangles(precision: str, subject: str) -> SimpleNamespace:
    """Function ``closest_weights(a, b, c, p)`` for the kernels of a subject."""
    types = real(precision)
    scalar, vec3 = types.scalar, types.vec3
    func = types.func(subject)

    @func
    def closest_weights(a: vec3, b: vec3, c: vec3, p: vec3):
        # barycentric weights of the closest point, exact zeros off the face (Ericson 2005, 5.1.5)
        zero, one = scalar(0.0), scalar(1.0)
        ab, ac, ap = b - a, c - a, p - a
        d1, d2 = wp.dot(ab, ap), wp.dot(ac, ap)
        if d1 <= zero and d2 <= zero:
            return vec3(one, zero, zero)
        d3, d4 = wp.dot(ab, p - b), wp.dot(ac, p - b)
        if d3 >= zero and d4 <= d3:
            return vec3(zero, one, zero)
        d5, d6 = wp.dot(ab, p - c), wp.dot(ac, p - c)
        if d6 >= zero and d5 <= d6:
            return vec3(zero, zero, one)
        area_c = d1 * d4 - d3 * d2
        if area_c <= zero and d1 >= zero and d3 <= zero:
            t = d1 / (d1 - d3)
            return vec3(one - t, t, zero)
        area_b = d5 * d2 - d1 * d6
        if area_b <= zero and d2 >= zero and d6 <= zero:
            t = d2 / (d2 - d6)
            return vec3(one - t, zero, t)
        area_a = d3 * d6 - d5 * d4
        if area_a <= zero and d4 >= d3 and d5 >= d6:
            t = (d4 - d3) / ((d4 - d3) + (d5 - d6))
            return vec3(zero, one - t, t)
        total = area_a + area_b + area_c
        return vec3(area_a / total, area_b / total, area_c / total)

    return SimpleNamespace(closest_weights=closest_weights)
