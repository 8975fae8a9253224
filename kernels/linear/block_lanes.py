"""The kernels of 16 right-hand sides side by side in native code, for processors.

They do what their namesakes in ``block_gradients``, ``cholesky`` and ``muscles`` do, in the same
order and without fused operations, so that results are the same to the last bit, and serve in
their place on processors: there Warp's vectors of 16 numbers go through memory between any two
operations, which takes two to eight times as long. The plain kernels are the reference, and run on
every other device.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.precision import real

SUBJECT = "block_lanes"

SHARES = 6
"""Numbers of a fibre direction's square d d^T: xx, yy, zz, xy, xz, yz."""

# Rows b of Warp's arrays of blocks; operations are not fused, since those of the plain kernels
# are not.
LANES = """
#pragma clang fp contract(off)
    typedef SCALAR lanes __attribute__((vector_size(LANES * sizeof(SCALAR)),
                                        aligned(sizeof(SCALAR))));
    #define ROW(array) ((lanes*)(array).data + (size_t)b * (array).shape[1])
"""

# y = row i of M~ X, the stiffness by differences across edges (``rows``).
ROW_PRODUCT = """
        const lanes own0 = X[3 * i], own1 = X[3 * i + 1], own2 = X[3 * i + 2];
        lanes y0 = {}, y1 = {}, y2 = {};
        const int last = row_start.data[i + 1];
        for (int k = row_start.data[i]; k < last; ++k) {
            const SCALAR* A = (const SCALAR*)values.data + 9 * k;
            const lanes* z = X + 3 * column.data[k];
            const lanes x0 = z[0] - own0, x1 = z[1] - own1, x2 = z[2] - own2;
            y0 += A[0] * x0 + A[1] * x1 + A[2] * x2;
            y1 += A[3] * x0 + A[4] * x1 + A[5] * x2;
            y2 += A[6] * x0 + A[7] * x1 + A[8] * x2;
        }
        const SCALAR mass = damped_masses.data[i];
        y0 = y0 + mass * own0;
        y1 = y1 + mass * own1;
        y2 = y2 + mass * own2;
        if (fixed.data[i]) y0 = y1 = y2 = lanes{};
"""

CURVATURE = f"""
    const lanes* X = ROW(p);
    lanes* Q = ROW(q);
    lanes total = {{}};
    for (int i = c * chunk; i < count && i < (c + 1) * chunk; ++i) {{
        {ROW_PRODUCT}
        Q[3 * i] = y0;
        Q[3 * i + 1] = y1;
        Q[3 * i + 2] = y2;
        total += y0 * own0;
        total += y1 * own1;
        total += y2 * own2;
    }}
    ROW(partial)[c] = total;
"""

RESIDUAL = f"""
    const lanes* X = ROW(x);
    const lanes* B = ROW(right);
    lanes* R = ROW(r);
    lanes total = {{}};
    for (int i = c * chunk; i < count && i < (c + 1) * chunk; ++i) {{
        {ROW_PRODUCT}
        lanes r0 = B[3 * i] - y0, r1 = B[3 * i + 1] - y1, r2 = B[3 * i + 2] - y2;
        if (fixed.data[i]) r0 = r1 = r2 = lanes{{}};
        R[3 * i] = r0;
        R[3 * i + 1] = r1;
        R[3 * i + 2] = r2;
        total += r0 * r0 + r1 * r1 + r2 * r2;
    }}
    ROW(partial)[c] = total;
"""

PRECONDITION = """
    const lanes* residuals = ROW(residual);
    lanes* results = ROW(result);
    lanes* y = ROW(work);
    for (int i = 0; i < count; ++i) {
        lanes y0 = {}, y1 = {}, y2 = {};
        const int last = row_start.data[i + 1];
        for (int s = row_start.data[i]; s < last; ++s) {
            const SCALAR* L = (const SCALAR*)lower.data + 9 * s;
            const lanes* w = y + 3 * column.data[s];
            const lanes w0 = w[0], w1 = w[1], w2 = w[2];
            y0 += L[0] * w0 + L[1] * w1 + L[2] * w2;
            y1 += L[3] * w0 + L[4] * w1 + L[5] * w2;
            y2 += L[6] * w0 + L[7] * w1 + L[8] * w2;
        }
        const SCALAR* Q = (const SCALAR*)turns.data + 9 * order.data[i];
        const lanes* r = residuals + 3 * order.data[i];
        const lanes r0 = r[0], r1 = r[1], r2 = r[2];
        y[3 * i] = Q[0] * r0 + Q[3] * r1 + Q[6] * r2 - y0;
        y[3 * i + 1] = Q[1] * r0 + Q[4] * r1 + Q[7] * r2 - y1;
        y[3 * i + 2] = Q[2] * r0 + Q[5] * r1 + Q[8] * r2 - y2;
    }
    for (int i = 0; i < count; ++i) {
        const SCALAR* D = (const SCALAR*)pivot_inverse.data + 9 * i;
        const lanes y0 = y[3 * i], y1 = y[3 * i + 1], y2 = y[3 * i + 2];
        y[3 * i] = D[0] * y0 + D[1] * y1 + D[2] * y2;
        y[3 * i + 1] = D[3] * y0 + D[4] * y1 + D[5] * y2;
        y[3 * i + 2] = D[6] * y0 + D[7] * y1 + D[8] * y2;
    }
    for (int i = count - 1; i >= 0; --i) {
        const lanes z0 = y[3 * i], z1 = y[3 * i + 1], z2 = y[3 * i + 2];
        const int last = row_start.data[i + 1];
        for (int s = row_start.data[i]; s < last; ++s) {
            const SCALAR* L = (const SCALAR*)lower.data + 9 * s;
            lanes* w = y + 3 * column.data[s];
            w[0] -= L[0] * z0 + L[3] * z1 + L[6] * z2;
            w[1] -= L[1] * z0 + L[4] * z1 + L[7] * z2;
            w[2] -= L[2] * z0 + L[5] * z1 + L[8] * z2;
        }
        const SCALAR* Q = (const SCALAR*)turns.data + 9 * order.data[i];
        lanes* z = results + 3 * order.data[i];
        z[0] = Q[0] * z0 + Q[1] * z1 + Q[2] * z2;
        z[1] = Q[3] * z0 + Q[4] * z1 + Q[5] * z2;
        z[2] = Q[6] * z0 + Q[7] * z1 + Q[8] * z2;
    }
"""

STRETCH = """
    const int* corner = (const int*)tets.data + 4 * t;
    const SCALAR* R = (const SCALAR*)rotations.data + 9 * t;
    const lanes* W = ROW(responses);
    const lanes* first = W + 3 * corner[0];
    const lanes w0 = first[0], w1 = first[1], w2 = first[2];
    lanes xx = {}, yy = {}, zz = {}, xy = {}, xz = {}, yz = {};
    for (int a = 0; a < 3; ++a) {
        const SCALAR* H = areas.data[a];
        const lanes* w = W + 3 * corner[a + 1];
        const lanes d0 = w[0] - w0, d1 = w[1] - w1, d2 = w[2] - w2;
        const lanes u0 = R[0] * d0 + R[3] * d1 + R[6] * d2;
        const lanes u1 = R[1] * d0 + R[4] * d1 + R[7] * d2;
        const lanes u2 = R[2] * d0 + R[5] * d1 + R[8] * d2;
        xx += H[0] * u0;
        yy += H[1] * u1;
        zz += H[2] * u2;
        xy += H[0] * u1 + H[1] * u0;
        xz += H[0] * u2 + H[2] * u0;
        yz += H[1] * u2 + H[2] * u1;
    }
    lanes* S = ROW(stretch) + 6 * t;
    S[0] = xx;
    S[1] = yy;
    S[2] = zz;
    S[3] = xy;
    S[4] = xz;
    S[5] = yz;
"""

# Tet by tet, so that a tet's stretch is read once and the sums of all segments stay in the
# first-level cache. Segments meet their tets in ascending order, as in the plain kernel. A pair's
# scale, where there are some, is 1 / |F d|.
SEGMENTS = """
    const lanes* S = ROW(stretch);
    lanes* totals = ROW(maps);
    for (int j = 0; j < segments; ++j) totals[j] = lanes{};
    for (int t = 0; t < count; ++t, S += 6) {
        const lanes xx = S[0], yy = S[1], zz = S[2], xy = S[3], xz = S[4], yz = S[5];
        const int last = pair_start.data[t + 1];
        for (int k = pair_start.data[t]; k < last; ++k) {
            const SCALAR* d = shares.data + SHARES * k;
            lanes diagonal = d[0] * xx + d[1] * yy;
            diagonal += d[2] * zz;
            lanes mixed = d[3] * xy + d[4] * xz;
            mixed += d[5] * yz;
            const SCALAR scale = scales.shape[0] ? scales.data[k] : (SCALAR)1.0;
            totals[pair_segment.data[k]] += scale * (diagonal + mixed);
        }
    }
    for (int j = 0; j < segments; ++j)
        totals[j] = (step_factors.data[0] * stiffness.data[j]) * totals[j];
""".replace("SHARES", str(SHARES))


def lanes_on(device: str, precision: str) -> SimpleNamespace | None:
    """The kernels of this module where a device is a processor; None elsewhere."""
    return make_block_lanes(precision) if wp.get_device(device).is_cpu else None


@cache
def make_block_lanes(precision: str) -> SimpleNamespace:
    """Kernels that take the arguments of their plain namesakes, and those of the muscle map.

    ``share_directions`` prepares what ``muscle_response_by_tets`` needs, which does the work of
    ``muscle_response`` in one thread for each block of right-hand sides.
    """
    types = real(precision)
    scalar, vec3, mat33, block = types.scalar, types.vec3, types.mat33, types.block
    kernel = types.kernel(SUBJECT)

    @types.native(LANES + RESIDUAL)
    def residual_of(
        b: int,
        c: int,
        chunk: int,
        count: int,
        fixed: wp.array(dtype=int),
        row_start: wp.array(dtype=int),
        column: wp.array(dtype=int),
        damped_masses: wp.array(dtype=scalar),
        values: wp.array(dtype=mat33),
        right: wp.array2d(dtype=block),
        x: wp.array2d(dtype=block),
        r: wp.array2d(dtype=block),
        partial: wp.array2d(dtype=block),
    ): ...

    @kernel
    def residual(
        # model
        chunk: int,
        count: int,
        fixed: wp.array(dtype=int),
        row_start: wp.array(dtype=int),
        column: wp.array(dtype=int),
        damped_masses: wp.array(dtype=scalar),
        # in
        values: wp.array(dtype=mat33),
        right: wp.array2d(dtype=block),
        x: wp.array2d(dtype=block),
        # out
        r: wp.array2d(dtype=block),
        partial: wp.array2d(dtype=block),
    ):
        b, c = wp.tid()
        # fmt: off
        residual_of(
            b, c, chunk, count, fixed, row_start, column, damped_masses, values, right, x,
            r, partial,
        )
        # fmt: on

    @types.native(LANES + CURVATURE)
    def curvature_of(
        b: int,
        c: int,
        chunk: int,
        count: int,
        fixed: wp.array(dtype=int),
        row_start: wp.array(dtype=int),
        column: wp.array(dtype=int),
        damped_masses: wp.array(dtype=scalar),
        values: wp.array(dtype=mat33),
        p: wp.array2d(dtype=block),
        q: wp.array2d(dtype=block),
        partial: wp.array2d(dtype=block),
    ): ...

    @kernel
    def curvature(
        # model
        chunk: int,
        count: int,
        fixed: wp.array(dtype=int),
        row_start: wp.array(dtype=int),
        column: wp.array(dtype=int),
        damped_masses: wp.array(dtype=scalar),
        # in
        values: wp.array(dtype=mat33),
        p: wp.array2d(dtype=block),
        # out
        q: wp.array2d(dtype=block),
        partial: wp.array2d(dtype=block),
    ):
        b, c = wp.tid()
        # fmt: off
        curvature_of(
            b, c, chunk, count, fixed, row_start, column, damped_masses, values, p, q, partial
        )
        # fmt: on

    @types.native(LANES + PRECONDITION)
    def precondition_row(
        b: int,
        count: int,
        order: wp.array(dtype=int),
        row_start: wp.array(dtype=int),
        column: wp.array(dtype=int),
        lower: wp.array(dtype=mat33),
        pivot_inverse: wp.array(dtype=mat33),
        turns: wp.array(dtype=mat33),
        residual: wp.array2d(dtype=block),
        work: wp.array2d(dtype=block),
        result: wp.array2d(dtype=block),
    ): ...

    @kernel
    def precondition_block(
        # model
        count: int,
        order: wp.array(dtype=int),
        row_start: wp.array(dtype=int),
        column: wp.array(dtype=int),
        # in
        lower: wp.array(dtype=mat33),
        pivot_inverse: wp.array(dtype=mat33),
        turns: wp.array(dtype=mat33),
        residual: wp.array2d(dtype=block),
        # out
        work: wp.array2d(dtype=block),
        result: wp.array2d(dtype=block),
    ):
        # fmt: off
        precondition_row(
            wp.tid(), count, order, row_start, column, lower, pivot_inverse, turns, residual,
            work, result,
        )
        # fmt: on

    @types.native(LANES + STRETCH)
    def stretch_of(
        b: int,
        t: int,
        areas: mat33,
        tets: wp.array(dtype=wp.vec4i),
        rotations: wp.array(dtype=mat33),
        responses: wp.array2d(dtype=block),
        stretch: wp.array2d(dtype=block),
    ): ...

    @kernel
    def tet_response(
        # model
        tets: wp.array(dtype=wp.vec4i),
        turned: int,
        # in
        rotations: wp.array(dtype=mat33),
        area_rows: wp.array(dtype=mat33),
        responses: wp.array2d(dtype=block),
        # out
        stretch: wp.array2d(dtype=block),
    ):
        b, t = wp.tid()
        areas = area_rows[t]
        if turned == 0:
            areas = area_rows[t] * rotations[t]
        stretch_of(b, t, areas, tets, rotations, responses, stretch)

    @kernel
    def share_directions(
        # model
        pair_segment: wp.array(dtype=int),
        pair_weight: wp.array(dtype=scalar),
        directions: wp.array(dtype=vec3),
        # out
        shares: wp.array2d(dtype=scalar),
    ):
        # what each number of a tet's stretch adds to a segment, rounded as in ``muscle_response``
        k = wp.tid()
        w = pair_weight[k]
        d = directions[pair_segment[k]]
        shares[k, 0] = w * d[0] * d[0]
        shares[k, 1] = w * d[1] * d[1]
        shares[k, 2] = w * d[2] * d[2]
        shares[k, 3] = w * d[0] * d[1]
        shares[k, 4] = w * d[0] * d[2]
        shares[k, 5] = w * d[1] * d[2]

    @types.native(LANES + SEGMENTS)
    def add_to_segments(
        b: int,
        count: int,
        segments: int,
        pair_start: wp.array(dtype=int),
        pair_segment: wp.array(dtype=int),
        shares: wp.array2d(dtype=scalar),
        stiffness: wp.array(dtype=scalar),
        step_factors: wp.array(dtype=scalar),
        scales: wp.array(dtype=scalar),
        stretch: wp.array2d(dtype=block),
        maps: wp.array2d(dtype=block),
    ): ...

    @kernel
    def muscle_response_by_tets(
        # model
        pair_start: wp.array(dtype=int),
        pair_segment: wp.array(dtype=int),
        shares: wp.array2d(dtype=scalar),
        stiffness: wp.array(dtype=scalar),
        step_factors: wp.array(dtype=scalar),
        # in
        scales: wp.array(dtype=scalar),
        stretch: wp.array2d(dtype=block),
        # out
        maps: wp.array2d(dtype=block),
    ):
        # fmt: off
        add_to_segments(
            wp.tid(), pair_start.shape[0] - 1, stiffness.shape[0], pair_start, pair_segment,
            shares, stiffness, step_factors, scales, stretch, maps,
        )
        # fmt: on

    return SimpleNamespace(
        residual=residual,
        curvature=curvature,
        precondition_block=precondition_block,
        tet_response=tet_response,
        share_directions=share_directions,
        muscle_response_by_tets=muscle_response_by_tets,
    )
