"""What the corners of a tet share."""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.precision import real


@cache
def make_corners(precision: str, subject: str) -> SimpleNamespace:
    """Function ``by_corner(slot, rows, out)`` for the kernels of a subject."""
    types = real(precision)
    vec3, mat33 = types.vec3, types.mat33
    func = types.func(subject)

    @func
    def by_corner(slot: int, rows: mat33, out: wp.array(dtype=vec3)):
        # the shape functions sum to one, so corner 0 is minus the other three
        first = vec3(rows[0, 0], rows[0, 1], rows[0, 2])
        second = vec3(rows[1, 0], rows[1, 1], rows[1, 2])
        third = vec3(rows[2, 0], rows[2, 1], rows[2, 2])
        out[slot] = -(first + second + third)
        out[slot + 1] = first
        out[slot + 2] = second
        out[slot + 3] = third

    return SimpleNamespace(by_corner=by_corner)
