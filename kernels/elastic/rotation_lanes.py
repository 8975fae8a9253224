"""Closest rotations of 16 matrices side by side in native code, for processors.

The closed form of ``rotation`` is a chain of operations that wait for each other; side by side they
fill vector registers, which takes a fifth of the time. Operations and their order are those of
``closest_rotation``, Warp's fused ones included, so that rotations are the same to the last bit.
Matrices whose rotation is hardly unique are left to it.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.elastic.polar_rotation import make_rotation
from warp_softbody.kernels.precision import BLOCK, real

SUBJECT = "rotation_lanes"

GROUP = BLOCK
"""Matrices side by side."""

# ``odd`` gets a bit for each lane whose matrix stays as it is.
ROTATE = """
#pragma clang fp contract(off)
    typedef SCALAR lanes __attribute__((vector_size(LANES * sizeof(SCALAR))));
    typedef decltype(lanes{} < lanes{}) choice;
    struct mat { lanes at[3][3]; };
    struct vec { lanes at[3]; };
    const lanes zero = {}, one = zero + (SCALAR)1.0;
    // products of matrices and of their entries are fused in Warp
    const auto fused = [&](lanes a0, lanes b0, lanes a1, lanes b1, lanes a2, lanes b2) {
        lanes sum = __builtin_elementwise_fma(a0, b0, zero);
        sum = __builtin_elementwise_fma(a1, b1, sum);
        return __builtin_elementwise_fma(a2, b2, sum);
    };
    const auto times = [&](const mat& a, const mat& b) {
        mat c;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                c.at[i][j] = fused(a.at[i][0], b.at[0][j], a.at[i][1], b.at[1][j],
                                   a.at[i][2], b.at[2][j]);
        return c;
    };
    const auto turned_times = [&](const mat& a, const mat& b) {
        mat c;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                c.at[i][j] = fused(a.at[0][i], b.at[0][j], a.at[1][i], b.at[1][j],
                                   a.at[2][i], b.at[2][j]);
        return c;
    };
    const auto square = [&](const mat& a) {
        lanes sum = zero;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                sum = __builtin_elementwise_fma(a.at[i][j], a.at[i][j], sum);
        return sum;
    };
    const auto cross = [](const vec& a, const vec& b) {
        return vec{a.at[1] * b.at[2] - a.at[2] * b.at[1], a.at[2] * b.at[0] - a.at[0] * b.at[2],
                   a.at[0] * b.at[1] - a.at[1] * b.at[0]};
    };
    const auto dot = [](const vec& a, const vec& b) {
        return a.at[0] * b.at[0] + a.at[1] * b.at[1] + a.at[2] * b.at[2];
    };

    SCALAR* matrix = (SCALAR*)matrices.data + 9 * LANES * group;
    const int count = matrices.shape[0] - LANES * group < LANES
        ? (int)matrices.shape[0] - LANES * group : LANES;
    mat F;
    for (int l = 0; l < LANES; ++l)
        for (int k = 0; k < 9; ++k) F.at[k / 3][k % 3][l] = matrix[9 * (l < count ? l : 0) + k];

    const lanes norm = __builtin_elementwise_sqrt(square(F));
    mat A;
    for (int k = 0; k < 9; ++k) A.at[k / 3][k % 3] = F.at[k / 3][k % 3] / norm;
    const vec a0 = {A.at[0][0], A.at[1][0], A.at[2][0]};
    const vec a1 = {A.at[0][1], A.at[1][1], A.at[2][1]};
    const vec a2 = {A.at[0][2], A.at[1][2], A.at[2][2]};
    const vec c0 = cross(a1, a2), c1 = cross(a2, a0), c2 = cross(a0, a1);
    mat cofactor;
    for (int i = 0; i < 3; ++i) {
        cofactor.at[i][0] = c0.at[i];
        cofactor.at[i][1] = c1.at[i];
        cofactor.at[i][2] = c2.at[i];
    }
    const vec row0 = {A.at[0][0], A.at[0][1], A.at[0][2]};
    const vec row1 = {A.at[1][0], A.at[1][1], A.at[1][2]};
    const vec row2 = {A.at[2][0], A.at[2][1], A.at[2][2]};
    const lanes d = dot(row0, cross(row1, row2));

    const SCALAR least = UNSAFE, four = 4.0, eight = 8.0;
    lanes root = zero + (SCALAR)1.7320508075688772;
    const lanes constant = one - four * square(cofactor);
    choice active = zero == zero;
    for (int iteration = 0; iteration < 16 && __builtin_reduce_or(active); ++iteration) {
        const lanes whole = root * root;
        const lanes value = (whole - (SCALAR)2.0) * whole - eight * d * root + constant;
        const lanes slope = four * root * (whole - (SCALAR)1.0) - eight * d;
        const lanes step = value / slope;
        active = active & ~(slope < four * least);
        root = active ? root - step : root;
        active = active & ~(__builtin_elementwise_abs(step) < (SCALAR)STOP);
    }
    const lanes gap = root * (root * root - (SCALAR)1.0) - (SCALAR)2.0 * d;
    const choice left = (gap < least) | (norm <= (SCALAR)TINY);

    mat R;
    const lanes share = root * root + (SCALAR)1.0, twice = (SCALAR)2.0 * root;
    const lanes part = (SCALAR)2.0 / gap;
    const mat cubed = times(A, turned_times(A, A));
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            R.at[i][j] = (share * A.at[i][j] + twice * cofactor.at[i][j]) / gap
                - part * cubed.at[i][j];
    mat half, rest = turned_times(R, R);
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            half.at[i][j] = (SCALAR)0.5 * R.at[i][j];
            rest.at[i][j] = (i == j ? (SCALAR)3.0 * one : zero) - rest.at[i][j];
        }
    R = times(half, rest);

    const mat S = turned_times(R, A);
    const vec axial = {S.at[2][1] - S.at[1][2], S.at[0][2] - S.at[2][0], S.at[1][0] - S.at[0][1]};
    const lanes h01 = (SCALAR)-0.5 * (S.at[0][1] + S.at[1][0]);
    const lanes h02 = (SCALAR)-0.5 * (S.at[0][2] + S.at[2][0]);
    const lanes h12 = (SCALAR)-0.5 * (S.at[1][2] + S.at[2][1]);
    const vec r0 = {S.at[1][1] + S.at[2][2], h01, h02};
    const vec r1 = {h01, S.at[0][0] + S.at[2][2], h12};
    const vec r2 = {h02, h12, S.at[0][0] + S.at[1][1]};
    const vec b0 = cross(r1, r2), b1 = cross(r2, r0), b2 = cross(r0, r1);
    const lanes volume = dot(r0, b0);
    vec w;
    for (int i = 0; i < 3; ++i)
        w.at[i] = (axial.at[0] * b0.at[i] + axial.at[1] * b1.at[i] + axial.at[2] * b2.at[i])
            / volume;
    const choice turns = (__builtin_elementwise_abs(volume) > (SCALAR)TINY)
        & (dot(w, w) < (SCALAR)0.01);
    vec k;
    for (int i = 0; i < 3; ++i) k.at[i] = (SCALAR)0.5 * (turns ? w.at[i] : zero);
    const lanes q = (SCALAR)1.0 / ((SCALAR)1.0 + dot(k, k));
    const mat K = {{{zero, -k.at[2], k.at[1]},
                    {k.at[2], zero, -k.at[0]},
                    {-k.at[1], k.at[0], zero}}};
    mat turn = times(K, K);
    for (int e = 0; e < 9; ++e) turn.at[e / 3][e % 3] = K.at[e / 3][e % 3] + turn.at[e / 3][e % 3];
    turn = times(R, turn);
    const lanes size = (SCALAR)2.0 * q;
    for (int e = 0; e < 9; ++e) R.at[e / 3][e % 3] += size * turn.at[e / 3][e % 3];
    int bits = 0;
    for (int l = 0; l < count; ++l) {
        if (left[l]) bits |= 1 << l;
        else
            for (int e = 0; e < 9; ++e) matrix[9 * l + e] = R.at[e / 3][e % 3][l];
    }
    odd.data[group] = bits;
"""


def rotation_lanes_on(device: str, precision: str) -> SimpleNamespace | None:
    """The kernel of this module where a device is a processor; None elsewhere."""
    return make_rotation_lanes(precision) if wp.get_device(device).is_cpu else None


@cache
def make_rotation_lanes(precision: str) -> SimpleNamespace:
    """Kernel ``rotate``: in place, every matrix becomes the rotation closest to it.

    A thread turns a group of ``GROUP`` matrices.
    """
    types = real(precision)
    mat33, kernel = types.mat33, types.kernel(SUBJECT)
    rotation = make_rotation(precision, SUBJECT)
    closest_rotation = rotation.closest_rotation
    group_size = wp.constant(GROUP)
    numbers = {"UNSAFE": rotation.unsafe, "STOP": rotation.stop, "TINY": types.tiny}
    snippet = ROTATE
    for name, number in numbers.items():
        snippet = snippet.replace(name, repr(number))

    @types.native(snippet)
    def rotate_group(group: int, matrices: wp.array(dtype=mat33), odd: wp.array(dtype=int)): ...

    @kernel
    def rotate(
        # in and out
        matrices: wp.array(dtype=mat33),
        # out
        odd: wp.array(dtype=int),
    ):
        g = wp.tid()
        rotate_group(g, matrices, odd)
        left = odd[g]
        t = group_size * g
        while left != 0:
            if (left & 1) != 0:
                matrices[t] = closest_rotation(matrices[t])
            left = left >> 1
            t += 1

    return SimpleNamespace(rotate=rotate)
