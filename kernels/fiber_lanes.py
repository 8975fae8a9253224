"""The stiffness of implicit muscles in native code, for processors.

It does what ``stiffen_tets`` of ``implicit_muscles`` does, to rounding. The six pairs of a tet's
corners lie side by side: what a fibre's direction gives to their blocks is the same but for a
factor that never changes, so that a pair of a tet and a segment costs six products of vectors.
"""

from functools import cache
from types import SimpleNamespace
from typing import Any

import warp as wp

from warp_softbody.kernels.precision import real

SUBJECT = "fiber_lanes"

CORNER_PAIRS = 8
"""Numbers a pair has in ``shares``: six, and two that fill a register."""

# Corners (0, 1), (0, 2), (0, 3), (1, 2), (1, 3) and (2, 3), as in ``stiffen_tets``.
STIFFEN = """
#pragma clang fp contract(fast)
    typedef SCALAR pairs __attribute__((vector_size(8 * sizeof(SCALAR)),
                                        aligned(sizeof(SCALAR))));
    pairs xx = {}, yy = {}, zz = {}, xy = {}, xz = {}, yz = {};
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
"""


def fiber_lanes_on(device: str, precision: str, fibers: Any, state: Any) -> SimpleNamespace | None:
    """The kernels of this module where a device is a processor; None elsewhere."""
    return make_fiber_lanes(precision, fibers, state) if wp.get_device(device).is_cpu else None


@cache
def make_fiber_lanes(precision: str, Fibers: Any, FiberState: Any) -> SimpleNamespace:
    """Kernels ``share_corners``, once, and ``stiffen_tets``, with the structs of the plain ones."""
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
    ):
        # dt^2 w V0 (d . g_a) (d . g_b) of the six pairs of corners
        t = wp.tid()
        dt = step_factors[0]
        for k in range(fibers.pair_start[t], fibers.pair_start[t + 1]):
            p = fibers.rest_inverse[t] * fibers.directions[fibers.pair_segment[k]]
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
        pair_start: wp.array(dtype=int),
        pair_segment: wp.array(dtype=int),
        shares: wp.array(dtype=scalar),
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
        fibers: Fibers,
        shares: wp.array(dtype=scalar),
        # in
        state: FiberState,
        # out
        blocks: wp.array(dtype=mat33),
    ):
        # fmt: off
        stiffen_tet(
            first + wp.tid(), fibers.pair_start, fibers.pair_segment, shares, state.directions,
            state.reciprocals, state.moduli, state.tensions, blocks,
        )
        # fmt: on

    return SimpleNamespace(share_corners=share_corners, stiffen_tets=stiffen_tets)
