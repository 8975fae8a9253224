"""The way to the coarse level and back in native code, for processors.

It does what ``restrict`` and ``prolong`` of ``two_level`` do, to rounding, between sweeps that keep
four numbers a node (``sweep_lanes``).
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.linear.codes import VelocityConstraint
from warp_softbody.kernels.precision import real

SUBJECT = "two_level_transfer"

COMMON = """
#pragma clang fp contract(fast)
    typedef SCALAR quad __attribute__((vector_size(4 * sizeof(SCALAR)), aligned(sizeof(SCALAR))));
    const auto node = [](const SCALAR* x, int i) {
        return quad{x[3 * i], x[3 * i + 1], x[3 * i + 2], 0};
    };
    const SCALAR *Q = (const SCALAR*)rotations.data, *d = (const SCALAR*)offsets.data;
    const auto rows_of = [&](int i, quad* rows) {
        const SCALAR* q = Q + 9 * (size_t)i;
        const quad tail = *(const quad*)(q + 5);
        rows[0] = *(const quad*)q;
        rows[1] = *(const quad*)(q + 3);
        rows[2] = __builtin_shufflevector(tail, tail, 1, 2, 3, 3);
    };
    const auto cross = [](quad a, quad b) {
        const quad turned = a * __builtin_shufflevector(b, b, 1, 2, 0, 3)
            - b * __builtin_shufflevector(a, a, 1, 2, 0, 3);
        return __builtin_shufflevector(turned, turned, 1, 2, 0, 3);
    };
    const auto project = [&](int i, quad v) {
        const int kind = constraint_kinds.data[i];
        if (kind == NONE) return v;
        if (kind == FIXED) return quad{};
        const quad axis = node((const SCALAR*)constraint_axes.data, i), product = axis * v;
        const quad along = axis * (product[0] + product[1] + product[2]);
        return kind == PLANE ? v - along : along;
    };
    const auto put = [](SCALAR* x, int i, quad v) {
        for (int a = 0; a < 3; ++a) x[3 * i + a] = v[a];
    };
"""

RESTRICT = """
    quad force = {}, moment = {};
    for (int k = aggregate_start.data[own]; k < aggregate_start.data[own + 1]; ++k) {
        const int i = aggregate_nodes.data[k];
        const quad free = project(i, ((const quad*)behind.data)[i]);
        quad rows[3];
        rows_of(i, rows);
        const quad turned = rows[0] * free[0] + rows[1] * free[1] + rows[2] * free[2];
        force -= turned;
        moment -= cross(node(d, i), turned);
    }
    put((SCALAR*)coarse.data, 2 * own, force);
    put((SCALAR*)coarse.data, 2 * own + 1, moment);
"""

PROLONG = """
    const SCALAR* u = (const SCALAR*)coarse.data;
    const int count = (int)aggregate_of.shape[0];
    for (int i = 0; i < count; ++i) {
        const int own = aggregate_of.data[i];
        if (own < 0) continue;
        const quad motion = node(u, 2 * own) + cross(node(u, 2 * own + 1), node(d, i));
        quad rows[3];
        rows_of(i, rows);
        for (int a = 0; a < 3; ++a) rows[a] *= motion;
        const quad first = __builtin_shufflevector(rows[0], rows[1], 0, 4, 1, 5);
        const quad last = __builtin_shufflevector(rows[0], rows[1], 2, 6, 3, 7);
        const quad turned = __builtin_shufflevector(first, rows[2], 0, 1, 4, 4)
            + __builtin_shufflevector(first, rows[2], 2, 3, 5, 5)
            + __builtin_shufflevector(last, rows[2], 0, 1, 6, 6);
        ((quad*)z.data)[i] += project(i, turned);
    }
"""


@cache
def make_transfer_lanes(precision: str) -> SimpleNamespace:
    """Kernels ``restrict_residual``, a thread an aggregate, and ``prolong``, one thread."""
    types = real(precision)
    vec3, vec4, mat33 = types.vec3, types.vec4, types.mat33
    kernel = types.kernel(SUBJECT)
    common = COMMON
    for kind in VelocityConstraint:
        common = common.replace(kind.name, str(int(kind)))

    @types.native(common + RESTRICT)
    def restrict_aggregate(
        own: int,
        aggregate_start: wp.array(dtype=int),
        aggregate_nodes: wp.array(dtype=int),
        offsets: wp.array(dtype=vec3),
        constraint_kinds: wp.array(dtype=int),
        constraint_axes: wp.array(dtype=vec3),
        rotations: wp.array(dtype=mat33),
        behind: wp.array(dtype=vec4),
        coarse: wp.array(dtype=vec3),
    ): ...

    @types.native(common + PROLONG)
    def prolong_to_nodes(
        aggregate_of: wp.array(dtype=int),
        offsets: wp.array(dtype=vec3),
        constraint_kinds: wp.array(dtype=int),
        constraint_axes: wp.array(dtype=vec3),
        rotations: wp.array(dtype=mat33),
        coarse: wp.array(dtype=vec3),
        z: wp.array(dtype=vec4),
    ): ...

    @kernel
    def restrict_residual(
        # model
        aggregate_start: wp.array(dtype=int),
        aggregate_nodes: wp.array(dtype=int),
        offsets: wp.array(dtype=vec3),
        # in
        constraint_kinds: wp.array(dtype=int),
        constraint_axes: wp.array(dtype=vec3),
        rotations: wp.array(dtype=mat33),
        behind: wp.array(dtype=vec4),
        # out
        coarse: wp.array(dtype=vec3),
    ):
        # fmt: off
        restrict_aggregate(
            wp.tid(), aggregate_start, aggregate_nodes, offsets, constraint_kinds, constraint_axes,
            rotations, behind, coarse,
        )
        # fmt: on

    @kernel
    def prolong(
        # model
        aggregate_of: wp.array(dtype=int),
        offsets: wp.array(dtype=vec3),
        # in
        constraint_kinds: wp.array(dtype=int),
        constraint_axes: wp.array(dtype=vec3),
        rotations: wp.array(dtype=mat33),
        coarse: wp.array(dtype=vec3),
        # out
        z: wp.array(dtype=vec4),
    ):
        # fmt: off
        prolong_to_nodes(
            aggregate_of, offsets, constraint_kinds, constraint_axes, rotations, coarse, z,
        )
        # fmt: on

    return SimpleNamespace(restrict_residual=restrict_residual, prolong=prolong)
