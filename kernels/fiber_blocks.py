"""Blocks of the stiffness of implicit muscles in native code, for processors.

It does what ``stiffen_tets`` of ``implicit_muscles`` does, to rounding. The six pairs of a tet's
corners lie side by side: what a fibre's direction gives to their blocks is the same but for a
factor that never changes, so that a pair of a tet and a segment costs six products of vectors. What
is done beside turns is done once for a tet.
"""

from functools import cache
from types import SimpleNamespace
from typing import Any

import warp as wp

from warp_softbody.kernels.implicit_muscles import SLOW, SUBJECT
from warp_softbody.kernels.precision import real

CORNER_PAIRS = 8
"""Numbers a pair has in ``shares``: six, and two that fill a register."""

# ``turning`` of ``implicit_muscles``: the inverse of a symmetric matrix by its cofactors.
TURNING = """
    const auto turning = [&](const SCALAR* of, SCALAR* to) {
        const SCALAR eps = 8 * (sizeof(SCALAR) == 4 ? 0x1p-23 : 0x1p-52);
        SCALAR C[9];
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                C[3 * i + j] = of[3 * i] * of[3 * j] + of[3 * i + 1] * of[3 * j + 1]
                    + of[3 * i + 2] * of[3 * j + 2];
        const SCALAR size = (C[0] + C[4] + C[8]) * ((SCALAR)1.0 + eps) + eps;
        const SCALAR a = size - C[0], b = size - C[4], c = size - C[8];
        const SCALAR d = -C[1], e = -C[2], f = -C[5];
        const SCALAR x = b * c - f * f, y = e * f - d * c, z = d * f - b * e;
        const SCALAR whole = (SCALAR)1.0 / (a * x + d * y + e * z);
        to[0] = x * whole;
        to[4] = (a * c - e * e) * whole;
        to[8] = (a * b - d * d) * whole;
        to[1] = to[3] = y * whole;
        to[2] = to[6] = z * whole;
        to[5] = to[7] = (d * e - a * f) * whole;
    };
"""

# Corners (0, 1), (0, 2), (0, 3), (1, 2), (1, 3) and (2, 3), as in ``stiffen_tets``. Matrices of the
# corners and of the turn are 3 x 3, by rows.
STIFFEN = (
    """
#pragma clang fp contract(fast)
TURNING
    typedef SCALAR pairs __attribute__((vector_size(8 * sizeof(SCALAR)),
                                        aligned(sizeof(SCALAR))));
    pairs xx = {}, yy = {}, zz = {}, xy = {}, xz = {}, yz = {};
    SCALAR spread[9] = {}, pulling = 0;
    const int last = pair_start.data[t + 1];
    for (int k = pair_start.data[t]; k < last; ++k) {
        const int j = pair_segment.data[k];
        const SCALAR modulus = moduli.data[j];
        if (!(modulus > (SCALAR)0.0)) continue;
        const SCALAR* n = (const SCALAR*)directions.data + 3 * k;
        const SCALAR across = tensions.data[j] * reciprocals.data[k], along = modulus - across;
        const pairs share = *(const pairs*)(shares.data + 8 * k);
        xx += share * (along * n[0] * n[0] + across);
        yy += share * (along * n[1] * n[1] + across);
        zz += share * (along * n[2] * n[2] + across);
        xy += share * (along * n[0] * n[1]);
        xz += share * (along * n[0] * n[2]);
        yz += share * (along * n[1] * n[2]);
        if (!(across > (SCALAR)0.0)) continue;
        const SCALAR size = dt * dt * volume.data[k] * across;
        const SCALAR* d = (const SCALAR*)rest_directions.data + 3 * j;
        pulling += size;
        for (int i = 0; i < 3; ++i)
            for (int l = 0; l < 3; ++l) spread[3 * i + l] += size * d[i] * d[l];
    }
    SCALAR* out = (SCALAR*)blocks.data + 54 * t;
    for (int e = 0; e < 6; ++e, out += 9) {
        out[0] = xx[e];
        out[4] = yy[e];
        out[8] = zz[e];
        out[1] = out[3] = xy[e];
        out[2] = out[6] = xz[e];
        out[5] = out[7] = yz[e];
    }
    if (!unturned || !(pulling > (SCALAR)0.0)) return;
    if (unturned == SLOW_ONES) {
        const SCALAR* turn = (const SCALAR*)turns.data + 3 * t;
        const SCALAR square = turn[0] * turn[0] + turn[1] * turn[1] + turn[2] * turn[2];
        const SCALAR left = (SCALAR)2.0 - dt * __builtin_elementwise_sqrt(square) / (SCALAR)SLOW;
        if (!(left > (SCALAR)0.0)) return;
        if (left < (SCALAR)1.0)
            for (int i = 0; i < 9; ++i) spread[i] *= left;
    }

    // corners side by side, and then their pairs
    typedef SCALAR corners __attribute__((vector_size(4 * sizeof(SCALAR))));
    const SCALAR* F = (const SCALAR*)deformations.data + 9 * t;
    const SCALAR* B = (const SCALAR*)rest_inverse.data + 9 * t;
    SCALAR own[9], S[9], M[9];
    turning(F, own);
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            S[3 * i + j] = F[3 * i] * spread[j] + F[3 * i + 1] * spread[3 + j]
                + F[3 * i + 2] * spread[6 + j];
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            M[3 * i + j] = -(S[3 * i] * F[3 * j] + S[3 * i + 1] * F[3 * j + 1]
                + S[3 * i + 2] * F[3 * j + 2]);
    const SCALAR trace = M[0] + M[4] + M[8];
    for (int i = 0; i < 3; ++i) M[4 * i] -= trace;
    corners g[3], f[3], s[3], w[9], x[9];
    for (int j = 0; j < 3; ++j) {
        const SCALAR p = B[j], q = B[3 + j], r = B[6 + j];
        g[j] = corners{-(p + q + r), p, q, r};
    }
    for (int i = 0; i < 3; ++i) {
        f[i] = F[3 * i] * g[0] + F[3 * i + 1] * g[1] + F[3 * i + 2] * g[2];
        s[i] = S[3 * i] * g[0] + S[3 * i + 1] * g[1] + S[3 * i + 2] * g[2];
    }
    for (int i = 0; i < 3; ++i) {
        w[3 * i] = own[3 * i + 1] * f[2] - own[3 * i + 2] * f[1];
        w[3 * i + 1] = own[3 * i + 2] * f[0] - own[3 * i] * f[2];
        w[3 * i + 2] = own[3 * i] * f[1] - own[3 * i + 1] * f[0];
    }
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            x[3 * i + j] = M[3 * i] * w[j] + M[3 * i + 1] * w[3 + j] + M[3 * i + 2] * w[6 + j];
    x[1] += s[2]; x[2] -= s[1]; x[3] -= s[2]; x[5] += s[0]; x[6] += s[1]; x[7] -= s[0];
    const auto first = [](corners v) -> pairs {
        return __builtin_shufflevector(v, v, 0, 0, 0, 1, 1, 2, 2, 2);
    };
    const auto second = [](corners v) -> pairs {
        return __builtin_shufflevector(v, v, 1, 2, 3, 2, 3, 3, 3, 3);
    };
    pairs wa[9], wb[9], xb[9], sa[3], sum[9];
    for (int i = 0; i < 9; ++i) {
        wa[i] = first(w[i]);
        wb[i] = second(w[i]);
        xb[i] = second(x[i]);
    }
    for (int i = 0; i < 3; ++i) sa[i] = first(s[i]);
    for (int j = 0; j < 3; ++j) {
        for (int i = 0; i < 3; ++i)
            sum[3 * i + j] = wa[i] * xb[j] + wa[3 + i] * xb[3 + j] + wa[6 + i] * xb[6 + j];
        sum[j] += sa[1] * wb[6 + j] - sa[2] * wb[3 + j];
        sum[3 + j] += sa[2] * wb[j] - sa[0] * wb[6 + j];
        sum[6 + j] += sa[0] * wb[3 + j] - sa[1] * wb[j];
    }
    out = (SCALAR*)blocks.data + 54 * t;
    for (int e = 0; e < 6; ++e, out += 9)
        for (int i = 0; i < 9; ++i) out[i] += sum[i][e];
""".replace("TURNING", TURNING)
    .replace("SLOW_ONES", "2")
    .replace("SLOW", repr(SLOW))
)


@cache
def make_fiber_blocks(precision: str, Fibers: Any, FiberState: Any) -> SimpleNamespace:
    """Kernels ``share_corners``, once, and ``stiffen_tets``, of the plain kernels' structs."""
    types = real(precision)
    scalar, vec3, mat33 = types.scalar, types.vec3, types.mat33
    kernel = types.kernel(SUBJECT)

    @kernel
    def share_corners(
        # model
        fibers: Fibers,
        step_factors: wp.array(dtype=scalar),
        # out
        shares: wp.array(dtype=scalar),
        ways: wp.array2d(dtype=scalar),
    ):
        # dt^2 w V0 (d . g_a) (d . g_b) of the six pairs of corners; ways: d
        t = wp.tid()
        dt = step_factors[0]
        for k in range(fibers.pair_start[t], fibers.pair_start[t + 1]):
            d = fibers.directions[fibers.pair_segment[k]]
            for axis in range(3):
                ways[axis, k] = d[axis]
            p = fibers.rest_inverse[t] * d
            p0 = -(p[0] + p[1] + p[2])
            size = dt * dt * fibers.volume[k]
            shares[8 * k] = size * (p0 * p[0])
            shares[8 * k + 1] = size * (p0 * p[1])
            shares[8 * k + 2] = size * (p0 * p[2])
            shares[8 * k + 3] = size * (p[0] * p[1])
            shares[8 * k + 4] = size * (p[0] * p[2])
            shares[8 * k + 5] = size * (p[1] * p[2])

    @types.native(STIFFEN)
    def stiffen_tet(
        t: int,
        unturned: int,
        dt: scalar,
        rest_inverse: wp.array(dtype=mat33),
        pair_start: wp.array(dtype=int),
        pair_segment: wp.array(dtype=int),
        volume: wp.array(dtype=scalar),
        rest_directions: wp.array(dtype=vec3),
        shares: wp.array(dtype=scalar),
        deformations: wp.array(dtype=mat33),
        turns: wp.array(dtype=vec3),
        directions: wp.array(dtype=vec3),
        reciprocals: wp.array(dtype=scalar),
        moduli: wp.array(dtype=scalar),
        tensions: wp.array(dtype=scalar),
        blocks: wp.array(dtype=mat33),
    ): ...

    @kernel
    def stiffen_tets(
        # model
        first: int,
        unturned: int,
        fibers: Fibers,
        step_factors: wp.array(dtype=scalar),
        shares: wp.array(dtype=scalar),
        # in
        state: FiberState,
        # out
        blocks: wp.array(dtype=mat33),
    ):
        # fmt: off
        stiffen_tet(
            first + wp.tid(), unturned, step_factors[0], fibers.rest_inverse, fibers.pair_start,
            fibers.pair_segment, fibers.volume, fibers.directions, shares, state.deformations,
            state.turns, state.directions, state.reciprocals, state.moduli, state.tensions, blocks,
        )
        # fmt: on

    return SimpleNamespace(share_corners=share_corners, stiffen_tets=stiffen_tets)
