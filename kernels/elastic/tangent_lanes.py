"""The conserving tangent's part of 16 tets side by side in native code, for processors.

It does what ``couple_tets`` of ``tangent`` does for that tangent, to rounding.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.precision import BLOCK, real

SUBJECT = "tangent_lanes"

GROUP = BLOCK
"""Tets side by side."""

# Symmetric matrices have the entries xx, xy, xz, yy, yz, zz.
COUPLE = """
#pragma clang fp contract(fast)
    typedef SCALAR lanes __attribute__((vector_size(LANES * sizeof(SCALAR))));
    const int first = group * LANES, all = (int)tets.shape[0];
    lanes E[9], B[9], R[9], g[9];
    for (int l = 0; l < LANES; ++l) {
        const int t = first + l < all ? first + l : all - 1;
        const int* corner = (const int*)tets.data + 4 * t;
        const SCALAR* x = (const SCALAR*)positions.data;
        for (int i = 0; i < 9; ++i) {
            E[i][l] = x[3 * corner[1 + i / 3] + i % 3] - x[3 * corner[0] + i % 3];
            B[i][l] = ((const SCALAR*)rest_inverse.data)[9 * t + i];
            R[i][l] = ((const SCALAR*)rotations.data)[9 * t + i];
            g[i][l] = ((const SCALAR*)gradients.data)[12 * t + 3 + i];
        }
    }
    const int place[9] = {0, 1, 2, 1, 3, 4, 2, 4, 5};
    const auto cofactor = [](const lanes* S, lanes* to) {
        to[0] = S[3] * S[5] - S[4] * S[4];
        to[1] = S[2] * S[4] - S[1] * S[5];
        to[2] = S[1] * S[4] - S[2] * S[3];
        to[3] = S[0] * S[5] - S[2] * S[2];
        to[4] = S[1] * S[2] - S[0] * S[4];
        to[5] = S[0] * S[3] - S[1] * S[1];
    };
    // products of functions of one symmetric matrix, which are symmetric
    const auto times = [&](const lanes* S, const lanes* T, lanes* to) {
        for (int i = 0; i < 3; ++i)
            for (int j = i; j < 3; ++j)
                to[place[3 * i + j]] = S[place[3 * i]] * T[place[j]]
                    + S[place[3 * i + 1]] * T[place[3 + j]] + S[place[3 * i + 2]] * T[place[6 + j]];
    };
    lanes F[9], M[9], V[6], A[6], cof[6], N[6], VN[6], half[6], twist[6], P[6], Q[6];
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            F[3 * i + j] = E[i] * B[j] + E[3 + i] * B[3 + j] + E[6 + i] * B[6 + j];
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            M[3 * i + j] = F[3 * i] * R[3 * j] + F[3 * i + 1] * R[3 * j + 1]
                + F[3 * i + 2] * R[3 * j + 2];
    for (int i = 0; i < 3; ++i)
        for (int j = i; j < 3; ++j)
            V[place[3 * i + j]] = (SCALAR)0.5 * (M[3 * i + j] + M[3 * j + i]);
    const lanes size = V[0] + V[3] + V[5], zero = {}, one = zero + (SCALAR)1.0;
    for (int i = 0; i < 6; ++i) A[i] = -V[i];
    A[0] += size;
    A[3] += size;
    A[5] += size;
    cofactor(A, cof);
    const lanes determinant = A[0] * cof[0] + A[1] * cof[1] + A[2] * cof[2];
    const lanes cube = size * size * size, tiny = zero + (SCALAR)TINY;
    const lanes share = (SCALAR)3.375 * determinant / (cube > tiny ? cube : tiny);
    const auto whole = share > (SCALAR)1e-3;
    const lanes square = (SCALAR)16.0 * share * share;
    const lanes fade = whole ? (square < one ? square : one) * lame.data[0] : zero;
    for (int i = 0; i < 6; ++i) N[i] = whole ? cof[i] / determinant : zero;
    times(V, N, VN);
    cofactor(V, cof);
    times(N, cof, half);
    times(half, N, twist);
    for (int i = 0; i < 6; ++i) {
        P[i] = fade * N[i];
        Q[i] = fade * ((i == 0 || i == 3 || i == 5 ? (SCALAR)0.5 : (SCALAR)0.0) - VN[i]
            - (SCALAR)2.0 * twist[i]);
    }
    const int count = all - first < LANES ? all - first : LANES;
    SCALAR* out = (SCALAR*)couplings.data + 36 * (size_t)first;
    lanes total[9] = {};
    for (int corner = 0; corner < 4; ++corner) {
        lanes Y[9];
        for (int i = 0; i < 9 && corner == 3; ++i) Y[i] = -total[i];
        if (corner < 3) {
            const lanes* own = g + 3 * corner;
            lanes h[3];
            for (int i = 0; i < 3; ++i) {
                h[i] = zero;
                for (int j = 0; j < 3; ++j)
                    h[i] += (A[place[3 * i + j]] - V[place[3 * i + j]]) * own[j];
            }
            for (int j = 0; j < 3; ++j)
                for (int i = 0; i < 3; ++i) {
                    const int a = (i + 1) % 3, b = (i + 2) % 3;
                    Y[3 * i + j] = h[a] * P[place[3 * j + b]] - h[b] * P[place[3 * j + a]]
                        + own[a] * Q[place[3 * j + b]] - own[b] * Q[place[3 * j + a]];
                    total[3 * i + j] += Y[3 * i + j];
                }
        }
        SCALAR* to = out + 9 * ((corner + 1) % 4);
        for (int l = 0; l < count; ++l)
            for (int i = 0; i < 9; ++i) to[36 * l + i] = Y[i][l];
    }
"""


@cache
def make_tangent_lanes(precision: str) -> SimpleNamespace:
    """Kernel ``couple_tets`` of the conserving tangent; a thread takes ``GROUP`` tets."""
    types = real(precision)
    scalar, vec3, mat33 = types.scalar, types.vec3, types.mat33
    kernel = types.kernel(SUBJECT)

    @types.native(COUPLE.replace("TINY", repr(types.tiny)))
    def couple_group(
        group: int,
        tets: wp.array(dtype=wp.vec4i),
        rest_inverse: wp.array(dtype=mat33),
        lame: wp.array(dtype=scalar),
        positions: wp.array(dtype=vec3),
        rotations: wp.array(dtype=mat33),
        gradients: wp.array(dtype=vec3),
        couplings: wp.array(dtype=mat33),
    ): ...

    @kernel
    def couple_tets(
        # model
        tets: wp.array(dtype=wp.vec4i),
        rest_inverse: wp.array(dtype=mat33),
        lame: wp.array(dtype=scalar),
        # in
        positions: wp.array(dtype=vec3),
        rotations: wp.array(dtype=mat33),
        gradients: wp.array(dtype=vec3),
        # out
        couplings: wp.array(dtype=mat33),
    ):
        # fmt: off
        couple_group(
            wp.tid(), tets, rest_inverse, lame, positions, rotations, gradients, couplings
        )
        # fmt: on

    return SimpleNamespace(couple_tets=couple_tets)
