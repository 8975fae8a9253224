"""Stretches and stiffness of implicit muscles in native code, for processors.

It does what ``stretch_fibers`` and ``stiffen_tets`` of ``implicit_muscles`` do, to rounding. Fibres
of a tet are stretched eight at a time; for the stiffness see `fiber_blocks`.
"""

from functools import cache
from types import SimpleNamespace
from typing import Any

import warp as wp

from warp_softbody.kernels.fiber_blocks import TURNING, make_fiber_blocks
from warp_softbody.kernels.implicit_muscles import SHORT, SUBJECT
from warp_softbody.kernels.precision import real

# A tet's last eight pairs may meet some of the eight before again, and find the same. Few pairs are
# found one by one.
STRETCH = """
#pragma clang fp contract(fast)
TURNING
    const SCALAR short_one = SHORT;
    const auto deformation = [&](const SCALAR* values, SCALAR* to) {
        const int* corner = (const int*)tets.data + 4 * t;
        const SCALAR* B = (const SCALAR*)rest_inverse.data + 9 * t;
        const SCALAR *first = values + 3 * corner[0], *a = values + 3 * corner[1];
        const SCALAR *b = values + 3 * corner[2], *c = values + 3 * corner[3];
        for (int i = 0; i < 3; ++i) {
            const SCALAR da = a[i] - first[i], db = b[i] - first[i], dc = c[i] - first[i];
            for (int j = 0; j < 3; ++j) to[3 * i + j] = da * B[j] + db * B[3 + j] + dc * B[6 + j];
        }
    };
    SCALAR F[9], G[9];
    deformation((const SCALAR*)positions.data, F);
    deformation((const SCALAR*)velocities.data, G);
    for (int i = 0; i < 9; ++i) ((SCALAR*)deformations.data)[9 * t + i] = F[i];
    if (again) {
        SCALAR own[9], moved[3] = {};
        turning(F, own);
        for (int k = 0; k < 3; ++k)
            for (int i = 0; i < 3; ++i) {
                const int j = (i + 1) % 3, l = (i + 2) % 3;
                moved[i] += F[3 * j + k] * G[3 * l + k] - F[3 * l + k] * G[3 * j + k];
            }
        for (int i = 0; i < 3; ++i)
            ((SCALAR*)turns.data)[3 * t + i] = own[3 * i] * moved[0] + own[3 * i + 1] * moved[1]
                + own[3 * i + 2] * moved[2];
    }
    const int begin = pair_start.data[t], end = pair_start.data[t + 1];
    const size_t count = ways.shape[1];
    SCALAR *n = (SCALAR*)directions.data, *rate = (SCALAR*)rates.data;
    typedef SCALAR eight __attribute__((vector_size(8 * sizeof(SCALAR)),
                                        aligned(sizeof(SCALAR))));
    for (int at = begin; at < end && end - begin >= 8; at += 8) {
        const int k = at + 8 <= end ? at : end - 8;
        eight d[3], along[3], ahead[3], square = {}, speed = {};
        for (int j = 0; j < 3; ++j) d[j] = *(const eight*)(ways.data + j * count + k);
        for (int i = 0; i < 3; ++i) {
            along[i] = F[3 * i] * d[0] + F[3 * i + 1] * d[1] + F[3 * i + 2] * d[2];
            ahead[i] = G[3 * i] * d[0] + G[3 * i + 1] * d[1] + G[3 * i + 2] * d[2];
            square += along[i] * along[i];
        }
        const eight length = __builtin_elementwise_sqrt(square), least = eight{} + short_one;
        const auto cut = length < least;
        const eight bound = cut ? least : length, reciprocal = (SCALAR)1.0 / bound;
        *(eight*)(stretches.data + k) = cut
            ? (SCALAR)0.5 * (square / short_one + short_one) : length;
        *(eight*)(reciprocals.data + k) = reciprocal;
        for (int i = 0; i < 3; ++i) {
            along[i] *= reciprocal;
            speed += along[i] * ahead[i];
            for (int l = 0; l < 8; ++l) n[3 * (k + l) + i] = along[i][l];
            if (again & 1)
                for (int l = 0; l < 8; ++l) rate[3 * (k + l) + i] = ahead[i][l];
        }
        *(eight*)(speeds.data + k) = speed;
    }
    for (int k = begin; k < end && end - begin < 8; ++k) {
        SCALAR along[3], ahead[3], square = 0.0, speed = 0.0;
        for (int i = 0; i < 3; ++i) {
            along[i] = ahead[i] = 0.0;
            for (int j = 0; j < 3; ++j) {
                along[i] += F[3 * i + j] * ways.data[j * count + k];
                ahead[i] += G[3 * i + j] * ways.data[j * count + k];
            }
            square += along[i] * along[i];
        }
        const SCALAR length = __builtin_elementwise_sqrt(square);
        const SCALAR bound = length < short_one ? short_one : length;
        stretches.data[k] = length < short_one
            ? (SCALAR)0.5 * (square / short_one + short_one) : length;
        reciprocals.data[k] = (SCALAR)1.0 / bound;
        for (int i = 0; i < 3; ++i) {
            n[3 * k + i] = along[i] / bound;
            rate[3 * k + i] = ahead[i];
            speed += along[i] / bound * ahead[i];
        }
        speeds.data[k] = speed;
    }
""".replace("SHORT", repr(SHORT)).replace("TURNING", TURNING)


def fiber_lanes_on(device: str, precision: str, fibers: Any, state: Any) -> SimpleNamespace | None:
    """The kernels of this module where a device is a processor; None elsewhere."""
    return make_fiber_lanes(precision, fibers, state) if wp.get_device(device).is_cpu else None


@cache
def make_fiber_lanes(precision: str, Fibers: Any, FiberState: Any) -> SimpleNamespace:
    """Kernels ``share_corners``, once, ``stretch_fibers`` and ``stiffen_tets``.

    The structs are those of the plain kernels.
    """
    types = real(precision)
    scalar, vec3, mat33 = types.scalar, types.vec3, types.mat33
    kernel = types.kernel(SUBJECT)

    @types.native(STRETCH)
    def stretch_tet(
        t: int,
        again: int,
        tets: wp.array(dtype=wp.vec4i),
        rest_inverse: wp.array(dtype=mat33),
        pair_start: wp.array(dtype=int),
        ways: wp.array2d(dtype=scalar),
        positions: wp.array(dtype=vec3),
        velocities: wp.array(dtype=vec3),
        deformations: wp.array(dtype=mat33),
        turns: wp.array(dtype=vec3),
        directions: wp.array(dtype=vec3),
        stretches: wp.array(dtype=scalar),
        rates: wp.array(dtype=vec3),
        speeds: wp.array(dtype=scalar),
        reciprocals: wp.array(dtype=scalar),
    ): ...

    @kernel
    def stretch_fibers(
        # model
        first: int,
        again: int,
        fibers: Fibers,
        ways: wp.array2d(dtype=scalar),
        # in
        positions: wp.array(dtype=vec3),
        velocities: wp.array(dtype=vec3),
        # out
        state: FiberState,
    ):
        # ``again``: 1 where rates of F d are needed, by further Newton iterations; 2 turns alone
        # fmt: off
        stretch_tet(
            first + wp.tid(), again, fibers.tets, fibers.rest_inverse, fibers.pair_start, ways,
            positions, velocities, state.deformations, state.turns, state.directions,
            state.stretches, state.rates, state.speeds, state.reciprocals,
        )
        # fmt: on

    blocks = make_fiber_blocks(precision, Fibers, FiberState)
    return SimpleNamespace(
        share_corners=blocks.share_corners,
        stretch_fibers=stretch_fibers,
        stiffen_tets=blocks.stiffen_tets,
    )
