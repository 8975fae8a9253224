"""How a step ends whose pairs did not settle: safe, though not exact.

The impulses of the last pass are cut to what the laws allow, none that pulls and none outside its
cone, and act as given forces. Where they would add energy at the velocities that follow, beyond
what pushes sunken bodies apart, all of them are scaled down until they do not: with x0 the
velocities without them and x1 with them, the power is ``a (1 - a) f . C x0 + a^2 f . C x1`` for a
part a of them.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.pair_rows import SUBJECT, make_pair_rows
from warp_softbody.kernels.precision import real


@cache
def make_pair_ending(precision: str) -> SimpleNamespace:
    """Kernels ``clip``, ``add_impulses`` and ``end``, in this order, with a solve before ``end``."""
    types = real(precision)
    scalar, vec3 = types.scalar, types.vec3
    kernel, func = types.kernel(SUBJECT), types.func(SUBJECT)
    rows = make_pair_rows(precision)
    Pairs, relative, wide, narrow = rows.Pairs, rows.relative, rows.wide, rows.narrow
    zero, one = wp.constant(wp.float64(0.0)), wp.constant(wp.float64(1.0))

    @kernel
    def clip(
        # in
        pairs: Pairs,
        friction_coefficient: scalar,
        # in and out
        impulses: wp.array(dtype=vec3),
    ):
        # the modes chosen last are where the next step begins
        for number in range(pairs.found_count[0]):
            c = pairs.found[number]
            n = pairs.normals[c]
            normal = wp.max(wp.dot(n, impulses[c]), scalar(0.0))
            friction = impulses[c] - wp.dot(n, impulses[c]) * n
            bound = pairs.roughness[c] * friction_coefficient * normal
            size = wp.length(friction)
            if size > bound:
                friction = (bound / size) * friction
            impulses[c] = normal * n + friction

    @kernel
    def add_impulses(
        # in
        pairs: Pairs,
        part: scalar,
        impulses: wp.array(dtype=vec3),
        right: wp.array(dtype=vec3),
        ground_frictions: wp.array(dtype=vec3),
        # out
        right_with_slip: wp.array(dtype=vec3),
    ):
        for i in range(right.shape[0]):
            right_with_slip[i] = right[i] + ground_frictions[i]
        for number in range(pairs.found_count[0]):
            c = pairs.found[number]
            k, w = pairs.nodes[c], pairs.weights[c]
            for a in range(4):
                right_with_slip[k[a]] = right_with_slip[k[a]] + (part * w[a]) * impulses[c]

    @func
    def power(pairs: Pairs, impulses: wp.array(dtype=vec3), x: wp.array(dtype=vec3)):
        # of the impulses at given velocities, beyond what pushes sunken bodies apart
        total = wp.float64(0.0)
        for number in range(pairs.found_count[0]):
            c = pairs.found[number]
            impulse = wide(impulses[c])
            pushed = wp.float64(wp.max(pairs.least[c], scalar(0.0)))
            pushed *= wp.dot(wide(pairs.normals[c]), impulse)
            total += wp.dot(impulse, relative(pairs, c, x)) - pushed
        return total

    @kernel
    def end(
        # in
        pairs: Pairs,
        without: wp.array(dtype=vec3),
        # in and out
        impulses: wp.array(dtype=vec3),
        x: wp.array(dtype=vec3),
    ):
        first, last = power(pairs, impulses, without), power(pairs, impulses, x)
        part = one
        if last > zero:
            part = wp.clamp(-first / (last - first), zero, one)
        for number in range(pairs.found_count[0]):
            c = pairs.found[number]
            impulses[c] = narrow(part * wide(impulses[c]))
        for i in range(x.shape[0]):
            x[i] = narrow((one - part) * wide(without[i]) + part * wide(x[i]))

    return SimpleNamespace(clip=clip, add_impulses=add_impulses, end=end)
