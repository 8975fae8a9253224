"""Smoothed elements in native code, for processors: means over edges and nodes, and their tets.

They are ``mean_edges`` of ``smoothed``, ``press_nodes`` and ``smoothed_tets`` of
``smoothed_volume``, to the last bit, where rotations are made by ``rotation_lanes``: a matrix is a
vector of eight numbers and one more, which stay in registers.
"""

from functools import cache
from types import SimpleNamespace
from typing import Any

import warp as wp

from warp_softbody.kernels.precision import real

SUBJECT = "smoothed_lanes"

EIGHT = """
#pragma clang fp contract(off)
    typedef SCALAR eight __attribute__((vector_size(8 * sizeof(SCALAR)),
                                        aligned(sizeof(SCALAR))));
"""

MEAN_EDGE = """
    eight total = {};
    SCALAR end = 0, volume = 0;
    const int last = edge_start.data[edge + 1];
    for (int k = edge_start.data[edge]; k < last; ++k) {
        const int t = ((const int*)edge_corners.data)[2 * k] / 4;
        const SCALAR own = rest_volume.data[t], *F = (const SCALAR*)deformations.data + 9 * t;
        total += own * *(const eight*)F;
        end += own * F[8];
        volume += own;
    }
    SCALAR *mean = (SCALAR*)means.data + 9 * edge, *turn = (SCALAR*)rotations.data + 9 * edge;
    *(eight*)mean = *(eight*)turn = total / volume;
    mean[8] = turn[8] = end / volume;
"""

# det F - 1 is summed, so that at rest nothing is rounded.
PRESS_NODE = """
    eight total = {};
    SCALAR end = 0, volume = 0, swelling = 0;
    const int last = node_start.data[i + 1];
    for (int k = node_start.data[i]; k < last; ++k) {
        const int t = node_corners.data[k] / 4;
        const SCALAR own = rest_volume.data[t], *F = (const SCALAR*)deformations.data + 9 * t;
        total += own * *(const eight*)F;
        end += own * F[8];
        volume += own;
        const SCALAR determinant = F[0] * (F[4] * F[8] - F[5] * F[7])
            + F[1] * (F[5] * F[6] - F[3] * F[8]) + F[2] * (F[3] * F[7] - F[4] * F[6]);
        swelling += own * (determinant - (SCALAR)1.0);
    }
    SCALAR* mean = (SCALAR*)rotations.data + 9 * i;
    *(eight*)mean = total / volume;
    mean[8] = end / volume;
    pressures.data[i] = ((SCALAR)0.25 * lame.data[1]) * (swelling / volume);
"""

SMOOTHED_TET = """
    const int* corner = (const int*)tets.data + 4 * t;
    const int* edge = tet_edges.data + (size_t)t * tet_edges.shape[1];
    const SCALAR* F = (const SCALAR*)deformations.data + 9 * (size_t)(first + t);
    eight sum = {};
    SCALAR S[9], C[9], pressure = 0;
    S[8] = 0;
    for (int k = 0; k < 6; ++k) {
        const SCALAR* own = (const SCALAR*)stresses.data + 9 * (size_t)edge[k];
        sum += *(const eight*)own;
        S[8] += own[8];
    }
    for (int k = 0; k < 8; ++k) S[k] = sum[k];
    for (int k = 0; k < 4; ++k) pressure += pressures.data[corner[k]];
    C[0] = F[4] * F[8] - F[5] * F[7];
    C[1] = F[5] * F[6] - F[3] * F[8];
    C[2] = F[3] * F[7] - F[4] * F[6];
    C[3] = F[2] * F[7] - F[1] * F[8];
    C[4] = F[0] * F[8] - F[2] * F[6];
    C[5] = F[1] * F[6] - F[0] * F[7];
    C[6] = F[1] * F[5] - F[2] * F[4];
    C[7] = F[2] * F[3] - F[0] * F[5];
    C[8] = F[0] * F[4] - F[1] * F[3];
    const SCALAR* B = (const SCALAR*)rest_inverse.data + 9 * t;
    const SCALAR* R = (const SCALAR*)rotations.data + 9 * t;
    const SCALAR size = rest_volume.data[t], root = __builtin_elementwise_sqrt(size);
    // an entry of B X^T, fused as the product of matrices is
    const auto entry = [&](int c, int a, const SCALAR* X) {
        const SCALAR first = B[3 * c] * X[3 * a];
        return __builtin_elementwise_fma(B[3 * c + 2], X[3 * a + 2],
            __builtin_elementwise_fma(B[3 * c + 1], X[3 * a + 1], first));
    };
    SCALAR* out[3] = {(SCALAR*)gradients.data + 12 * (size_t)t,
                      (SCALAR*)volume_gradients.data + 12 * (size_t)t,
                      (SCALAR*)forces.data + 12 * (size_t)t};
    // by corner, of which the first is minus the others
    SCALAR whole[9] = {};
    for (int c = 0; c < 3; ++c)
        for (int a = 0; a < 3; ++a) {
            const SCALAR area = entry(c, a, C);
            const SCALAR own[3] = {root * entry(c, a, R), root * area,
                                   -size * (entry(c, a, S) + pressure * area)};
            for (int i = 0; i < 3; ++i) {
                out[i][3 * c + 3 + a] = own[i];
                whole[3 * i + a] = c == 0 ? own[i] : whole[3 * i + a] + own[i];
            }
        }
    for (int i = 0; i < 3; ++i)
        for (int a = 0; a < 3; ++a) out[i][a] = -whole[3 * i + a];
"""


@cache
def make_smoothed_lanes(precision: str, SmoothedState: Any) -> SimpleNamespace:
    """The kernels; ``smoothed_tets`` takes rotations of the tets' own F, already made.

    The struct is that of the plain kernels.
    """
    types = real(precision)
    scalar, vec3, mat33 = types.scalar, types.vec3, types.mat33
    kernel = types.kernel(SUBJECT)

    @types.native(EIGHT + MEAN_EDGE)
    def mean_edge(
        edge: int,
        edge_start: wp.array(dtype=int),
        edge_corners: wp.array(dtype=wp.vec2i),
        rest_volume: wp.array(dtype=scalar),
        deformations: wp.array(dtype=mat33),
        means: wp.array(dtype=mat33),
        rotations: wp.array(dtype=mat33),
    ): ...

    @kernel
    def mean_edges(
        # model
        edge_start: wp.array(dtype=int),
        edge_corners: wp.array(dtype=wp.vec2i),
        rest_volume: wp.array(dtype=scalar),
        # in
        deformations: wp.array(dtype=mat33),
        # out
        means: wp.array(dtype=mat33),
        rotations: wp.array(dtype=mat33),
    ):
        # fmt: off
        mean_edge(
            wp.tid(), edge_start, edge_corners, rest_volume, deformations, means, rotations
        )
        # fmt: on

    @types.native(EIGHT + PRESS_NODE)
    def press_node(
        i: int,
        node_start: wp.array(dtype=int),
        node_corners: wp.array(dtype=int),
        rest_volume: wp.array(dtype=scalar),
        lame: wp.array(dtype=scalar),
        deformations: wp.array(dtype=mat33),
        pressures: wp.array(dtype=scalar),
        rotations: wp.array(dtype=mat33),
    ): ...

    @kernel
    def press_nodes(
        # model
        node_start: wp.array(dtype=int),
        node_corners: wp.array(dtype=int),
        rest_volume: wp.array(dtype=scalar),
        lame: wp.array(dtype=scalar),
        # in
        deformations: wp.array(dtype=mat33),
        # out
        pressures: wp.array(dtype=scalar),
        rotations: wp.array(dtype=mat33),
    ):
        # fmt: off
        press_node(
            wp.tid(), node_start, node_corners, rest_volume, lame, deformations, pressures,
            rotations,
        )
        # fmt: on

    @types.native(EIGHT + SMOOTHED_TET)
    def smoothed_tet(
        t: int,
        first: int,
        tets: wp.array(dtype=wp.vec4i),
        tet_edges: wp.array2d(dtype=int),
        rest_inverse: wp.array(dtype=mat33),
        rest_volume: wp.array(dtype=scalar),
        deformations: wp.array(dtype=mat33),
        stresses: wp.array(dtype=mat33),
        pressures: wp.array(dtype=scalar),
        rotations: wp.array(dtype=mat33),
        gradients: wp.array(dtype=vec3),
        volume_gradients: wp.array(dtype=vec3),
        forces: wp.array(dtype=vec3),
    ): ...

    @kernel
    def smoothed_tets(
        # model
        tets: wp.array(dtype=wp.vec4i),
        tet_edges: wp.array2d(dtype=int),
        rest_inverse: wp.array(dtype=mat33),
        rest_volume: wp.array(dtype=scalar),
        first: int,
        # in
        now: SmoothedState,
        rotations: wp.array(dtype=mat33),
        # out
        gradients: wp.array(dtype=vec3),
        volume_gradients: wp.array(dtype=vec3),
        forces: wp.array(dtype=vec3),
    ):
        # fmt: off
        smoothed_tet(
            wp.tid(), first, tets, tet_edges, rest_inverse, rest_volume, now.deformations,
            now.stresses, now.pressures, rotations, gradients, volume_gradients, forces,
        )
        # fmt: on

    return SimpleNamespace(
        mean_edges=mean_edges, press_nodes=press_nodes, smoothed_tets=smoothed_tets
    )
