"""Bodies as a whole: which nodes are whose, their inertia, and groups of them."""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.precision import real


@cache
def make_rigid_bodies(precision: str, subject: str) -> SimpleNamespace:
    """Functions ``body_of``, ``inertia_of`` and ``merge_groups`` for the kernels of a subject."""
    func = real(precision).func(subject)
    vec3d = wp.vec3d

    @func
    def body_of(node: int, node_start: wp.array(dtype=int)):
        body = int(0)
        while node_start[body + 1] <= node:
            body += 1
        return body

    @func
    def inertia_of(arm: vec3d, mass: wp.float64):
        # of a point mass
        identity = wp.identity(n=3, dtype=wp.float64)
        return mass * (wp.length_sq(arm) * identity - wp.outer(arm, arm))

    @func
    def merge_groups(one: int, other: int, groups: wp.array(dtype=int)):
        # the number of a group is that of its first body
        if one != other:
            for body in range(groups.shape[0]):
                if groups[body] == wp.max(one, other):
                    groups[body] = wp.min(one, other)

    return SimpleNamespace(body_of=body_of, inertia_of=inertia_of, merge_groups=merge_groups)
