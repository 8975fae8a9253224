"""Vector operations of conjugate gradients in native code, for processors.

They do what ``filtered_product``, ``direction`` and ``advance`` of ``pcg`` do, to rounding: what
knows no nodes goes over eight numbers at a time, and sums in double precision.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.linear.codes import Scalar, VelocityConstraint
from warp_softbody.kernels.linear.structs import make_linear_structs
from warp_softbody.kernels.precision import real

SUBJECT = "conjugate_gradients_vectors"

# ``span`` is the numbers of a chunk's nodes.
COMMON = """
#pragma clang fp contract(fast)
    typedef SCALAR eight __attribute__((vector_size(8 * sizeof(SCALAR)), aligned(sizeof(SCALAR))));
    typedef SCALAR quad __attribute__((vector_size(4 * sizeof(SCALAR)), aligned(sizeof(SCALAR))));
    typedef double wide __attribute__((vector_size(4 * sizeof(double))));
    const auto put = [](SCALAR* to) -> eight& { return *(eight*)to; };
    const auto at = [](const SCALAR* from) { return *(const eight*)from; };
    const int begin = 3 * first, span = 3 * (last - first);
    const auto dot = [&](const SCALAR* a, const SCALAR* b) {
        wide low = {}, high = {};
        int k = 0;
        for (; k + 8 <= span; k += 8) {
            const eight x = at(a + k), y = at(b + k);
            low += __builtin_convertvector(__builtin_shufflevector(x, x, 0, 1, 2, 3), wide)
                * __builtin_convertvector(__builtin_shufflevector(y, y, 0, 1, 2, 3), wide);
            high += __builtin_convertvector(__builtin_shufflevector(x, x, 4, 5, 6, 7), wide)
                * __builtin_convertvector(__builtin_shufflevector(y, y, 4, 5, 6, 7), wide);
        }
        low += high;
        double total = (low[0] + low[1]) + (low[2] + low[3]);
        for (; k < span; ++k) total += (double)a[k] * (double)b[k];
        return total;
    };
    const auto add = [&](SCALAR factor, const SCALAR* from, const SCALAR* to, SCALAR* out) {
        int k = 0;
        for (; k + 8 <= span; k += 8) put(out + k) = at(to + k) + factor * at(from + k);
        for (; k < span; ++k) out[k] = to[k] + factor * from[k];
    };
"""

FILTER = (
    COMMON
    + """
    const SCALAR *left = (const SCALAR*)r.data + begin, *axes = (const SCALAR*)constraint_axes.data;
    SCALAR* x = (SCALAR*)z.data;
    for (int i = first; i < last; ++i) {
        const int kind = constraint_kinds.data[i];
        if (kind == NONE) continue;
        const SCALAR *axis = axes + 3 * i, *v = x + 3 * i;
        const SCALAR along = axis[0] * v[0] + axis[1] * v[1] + axis[2] * v[2];
        for (int a = 0; a < 3; ++a) {
            const SCALAR part = along * axis[a];
            x[3 * i + a] = kind == PLANE ? x[3 * i + a] - part : kind == LINE ? part : 0;
        }
    }
    partial.data[chunk] = dot(left, x + begin);
"""
)

DIRECTION = (
    COMMON
    + """
    add(beta, (const SCALAR*)p.data + begin, (const SCALAR*)z.data + begin,
        (SCALAR*)p.data + begin);
"""
)

ADVANCE = (
    COMMON
    + """
    SCALAR *v = (SCALAR*)change.data + begin, *left = (SCALAR*)r.data + begin;
    add(alpha, (const SCALAR*)p.data + begin, v, v);
    add(-alpha, (const SCALAR*)q.data + begin, left, left);
    squares.data[chunk] = dot(left, left);
    double step = 0.0, whole[3] = {};
    for (int i = 0; i < last - first && follows; ++i) {
        const SCALAR* from = (const SCALAR*)start.data + begin;
        double square = 0.0;
        for (int a = 3 * i; a < 3 * i + 3; ++a) {
            const double moment = (double)(masses.data[first + i] * (v[a] - from[a]));
            square += moment * moment;
        }
        step += square;
        for (int a = 0; a < 3; ++a) whole[a] += (double)left[3 * i + a];
    }
    moved.data[chunk] = step;
    for (int a = 0; a < 3; ++a) ((double*)net.data)[3 * chunk + a] = whole[a];
"""
)


def vector_lanes_on(device: str, precision: str) -> SimpleNamespace | None:
    """The kernels of this module where a device is a processor; None elsewhere."""
    return make_vector_lanes(precision) if wp.get_device(device).is_cpu else None


@cache
def make_vector_lanes(precision: str) -> SimpleNamespace:
    """Kernels ``filtered_product``, ``direction`` and ``advance``, as the plain ones."""
    types = real(precision)
    scalar, vec3 = types.scalar, types.vec3
    kernel = types.kernel(SUBJECT)
    structs = make_linear_structs(precision)
    NodeConstraints, ResidualSums = structs.NodeConstraints, structs.ResidualSums
    filtered = FILTER
    for kind in VelocityConstraint:
        filtered = filtered.replace(kind.name, str(int(kind)))

    @types.native(filtered)
    def filter_chunk(
        chunk: int,
        first: int,
        last: int,
        constraint_kinds: wp.array(dtype=int),
        constraint_axes: wp.array(dtype=vec3),
        r: wp.array(dtype=vec3),
        z: wp.array(dtype=vec3),
        partial: wp.array(dtype=wp.float64),
    ): ...

    @types.native(DIRECTION)
    def add_to_direction(
        first: int, last: int, beta: scalar, z: wp.array(dtype=vec3), p: wp.array(dtype=vec3)
    ): ...

    @types.native(ADVANCE)
    def advance_chunk(
        chunk: int,
        first: int,
        last: int,
        follows: int,
        alpha: scalar,
        masses: wp.array(dtype=scalar),
        p: wp.array(dtype=vec3),
        q: wp.array(dtype=vec3),
        start: wp.array(dtype=vec3),
        change: wp.array(dtype=vec3),
        r: wp.array(dtype=vec3),
        squares: wp.array(dtype=wp.float64),
        moved: wp.array(dtype=wp.float64),
        net: wp.array(dtype=wp.vec3d),
    ): ...

    @kernel
    def filtered_product(
        # model
        chunk: int,
        # in
        constraints: NodeConstraints,
        r: wp.array(dtype=vec3),
        # out
        z: wp.array(dtype=vec3),
        partial: wp.array(dtype=wp.float64),
    ):
        c = wp.tid()
        # fmt: off
        filter_chunk(
            c, c * chunk, wp.min((c + 1) * chunk, r.shape[0]), constraints.kinds, constraints.axes,
            r, z, partial,
        )
        # fmt: on

    @kernel
    def direction(
        # model
        chunk: int,
        # in
        scalars: wp.array(dtype=wp.float64),
        z: wp.array(dtype=vec3),
        # out
        p: wp.array(dtype=vec3),
    ):
        c = wp.tid()
        old = scalars[Scalar.RESIDUAL_PRODUCT]
        beta = scalar(0.0)
        if old > wp.float64(0.0):
            beta = scalar(scalars[Scalar.NEW_PRODUCT] / old)
        add_to_direction(c * chunk, wp.min((c + 1) * chunk, z.shape[0]), beta, z, p)

    @kernel
    def advance(
        # model
        chunk: int,
        follows: int,
        masses: wp.array(dtype=scalar),
        # in
        scalars: wp.array(dtype=wp.float64),
        p: wp.array(dtype=vec3),
        q: wp.array(dtype=vec3),
        start: wp.array(dtype=vec3),
        # out
        change: wp.array(dtype=vec3),
        r: wp.array(dtype=vec3),
        sums: ResidualSums,
    ):
        c = wp.tid()
        curvature = scalars[Scalar.CURVATURE]
        alpha = scalar(0.0)
        if curvature > wp.float64(0.0):
            alpha = scalar(scalars[Scalar.NEW_PRODUCT] / curvature)
        # fmt: off
        advance_chunk(
            c, c * chunk, wp.min((c + 1) * chunk, change.shape[0]), follows, alpha, masses, p, q,
            start, change, r, sums.squares, sums.moved, sums.net,
        )
        # fmt: on

    return SimpleNamespace(filtered_product=filtered_product, direction=direction, advance=advance)
