"""Whether a pair with an edge of the ground is held by nodes that touch the ground already.

Such a row moves nodes that the ground's own velocity constraints hold in part. What these leave
free of it may be little: the rest of the velocity that it asks would have to come from there, many
times as fast. Such rows are left out; the nodes bear what they would.
"""

from functools import cache
from types import SimpleNamespace
from typing import Any

import warp as wp

from warp_softbody.kernels.contact.modes import Mode
from warp_softbody.kernels.contact.structs import make_pair_structs
from warp_softbody.kernels.linear.structs import make_linear_structs
from warp_softbody.kernels.precision import real
from warp_softbody.kernels.widening import make_widening

LEAST_LEFT = 0.25
"""Share that the ground leaves of a row, squared, below which it is left out: from there on nodes
would move more than twice as fast as it asks. With 0.03 feet that came down on a step were flung
away at 100 m/s, by two rows on one edge that its two nodes were left to answer."""

ALONG_X = 0.7
"""Component of a unit vector from which on it counts as being along x."""


@cache
def make_held_rows(precision: str, subject: str, left_free: Any) -> SimpleNamespace:
    """Function ``is_held``; ``left_free`` projects a velocity of a node onto what is free."""
    func = real(precision).func(subject)
    wide = make_widening(precision, subject).wide
    Pairs = make_pair_structs(precision).Pairs
    NodeConstraints = make_linear_structs(precision).NodeConstraints
    vec3d = wp.vec3d
    least_left = wp.constant(wp.float64(LEAST_LEFT))
    along_x = wp.constant(wp.float64(ALONG_X))
    zero, one = wp.constant(wp.float64(0.0)), wp.constant(wp.float64(1.0))

    @func
    def left_of(pairs: Pairs, c: int, constraints: NodeConstraints, way: vec3d):
        # the share of a row along a way that the ground's velocity constraints leave, squared
        k, w = pairs.nodes[c], pairs.weights[c]
        whole = wp.float64(0.0)
        left = wp.float64(0.0)
        for a in range(2):
            square = wp.float64(w[a]) * wp.float64(w[a])
            whole += square
            left += square * wp.length_sq(left_free(constraints, k[a], way))
        return left / whole

    @func
    def is_held(pairs: Pairs, c: int, mode: int, constraints: NodeConstraints):
        if pairs.nodes[c][0] != pairs.nodes[c][2]:
            # with another surface
            return False
        n = wp.normalize(wide(pairs.normals[c]))
        left = left_of(pairs, c, constraints, n)
        if mode == Mode.STICK:
            beside = vec3d(one, zero, zero)
            if wp.abs(n[0]) > along_x:
                beside = vec3d(zero, one, zero)
            side = wp.normalize(wp.cross(n, beside))
            left = wp.min(left, left_of(pairs, c, constraints, side))
            left = wp.min(left, left_of(pairs, c, constraints, wp.cross(n, side)))
        return left < least_left

    return SimpleNamespace(is_held=is_held)
