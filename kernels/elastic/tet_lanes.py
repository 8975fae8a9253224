"""Rotation, stress, forces and gradients of tets side by side in native code, for processors.

It does what ``deform_tets`` of ``corotated`` and of ``exact_volume`` do, to rounding, in one pass;
tets whose rotation is left to the closed form are done by these.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.elastic.corotated import make_elasticity
from warp_softbody.kernels.elastic.exact_volume import make_exact_volume
from warp_softbody.kernels.elastic.lanes import GROUP, prelude
from warp_softbody.kernels.precision import real

SUBJECT = "tet_lanes"

# ``by_corner`` writes V B M^T of rows by corner; corner 0 is minus the sum of the others.
COMMON = """
    const SCALAR *x = (const SCALAR*)positions.data, *rest = (const SCALAR*)rest_inverse.data;
    const int all = (int)tets.shape[0];
    int bits = 0;
    for (int begin = 0; begin < LANES; begin += WIDE) {
        const int first = LANES * group + begin;
        const int count = all - first < WIDE ? all - first : WIDE;
        if (count <= 0) break;
        const auto tet = [&](int l) { return first + (l < count ? l : count - 1); };
        lanes B[9], F[9], R[9], volume, at[4][4];
        load_matrices(rest, tet, B);
        for (int l = 0; l < WIDE; ++l) volume[l] = rest_volume.data[tet(l)];
        for (int corner = 0; corner < 4; ++corner)
            gathered([&](int l) {
                const SCALAR* p = x + 3 * (size_t)((const int*)tets.data)[4 * tet(l) + corner];
                return quad{p[0], p[1], p[2], 0};
            }, at[corner]);
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                F[3 * i + j] = (at[1][i] - at[0][i]) * B[j] + (at[2][i] - at[0][i]) * B[3 + j]
                    + (at[3][i] - at[0][i]) * B[6 + j];
        const choice odd = rotate(F, R);
        for (int l = 0; l < count; ++l) bits |= (odd[l] ? 1 : 0) << (begin + l);
        store_matrices((SCALAR*)rotations.data + 9 * (size_t)first, R, count);
        // M: the three rows that go with the corners 1 to 3, B times the transpose of a matrix
        const auto rows_of = [&](const lanes* a, lanes* M) {
            for (int i = 0; i < 3; ++i)
                for (int j = 0; j < 3; ++j)
                    M[3 * i + j] = B[3 * i] * a[3 * j] + B[3 * i + 1] * a[3 * j + 1]
                        + B[3 * i + 2] * a[3 * j + 2];
        };
        const auto by_corner = [&](SCALAR* out, lanes size, const lanes* M) {
            lanes v[12];
            for (int i = 0; i < 9; ++i) v[3 + i] = size * M[i];
            for (int j = 0; j < 3; ++j) v[j] = -(v[3 + j] + v[6 + j] + v[9 + j]);
            for (int k = 0; k < 12; k += 4)
                scattered(v[k], v[k + 1], v[k + 2], v[k + 3], count,
                          [&](int l, quad q) { *(quad*)(out + 12 * (size_t)(first + l) + k) = q; });
        };
        const lanes root = __builtin_elementwise_sqrt(volume);
        const SCALAR mu = lame.data[0], lambda = lame.data[1];
        lanes M[9], P[9];
        rows_of(R, M);
        by_corner((SCALAR*)gradients.data, root, M);
"""

AREAS = """
        lanes C[9], areas[9];
        cofactors(F, C);
        rows_of(C, areas);
        if (muscular) {
            lanes sized[9];
            for (int i = 0; i < 9; ++i) sized[i] = volume * areas[i];
            store_matrices((SCALAR*)area_rows.data + 9 * (size_t)first, sized, count);
        }
"""

LINEAR = """
        // P = R (2 mu eps + lambda tr(eps) I), eps the symmetric part of R^T F - I
        lanes S[9];
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                S[3 * i + j] = R[i] * F[j] + R[3 + i] * F[3 + j] + R[6 + i] * F[6 + j];
        const lanes trace = (S[0] - one) + (S[4] - one) + (S[8] - one);
        lanes stress[9];
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                stress[3 * i + j] = i == j
                    ? ((SCALAR)2.0 * mu) * (S[4 * i] - one) + lambda * trace
                    : mu * (S[3 * i + j] + S[3 * j + i]);
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                P[3 * i + j] = R[3 * i] * stress[j] + R[3 * i + 1] * stress[3 + j]
                    + R[3 * i + 2] * stress[6 + j];
        rows_of(P, M);
        by_corner((SCALAR*)forces.data, -volume, M);
"""

EXACT = """
        // P = 2 mu (F - R) + lambda (det F - 1) cof F
        by_corner((SCALAR*)volume_gradients.data, root, areas);
        const lanes determinant = F[0] * C[0] + F[1] * C[1] + F[2] * C[2];
        const lanes swelling = lambda * (determinant - one);
        for (int i = 0; i < 9; ++i)
            P[i] = ((SCALAR)2.0 * mu) * (F[i] - R[i]) + swelling * C[i];
        rows_of(P, M);
        by_corner((SCALAR*)forces.data, -volume, M);
"""

END = """
    }
    odd_tets.data[group] = bits;
"""


def tet_lanes_on(device: str, precision: str) -> SimpleNamespace | None:
    """The kernels of this module where a device is a processor; None elsewhere."""
    return make_tet_lanes(precision) if wp.get_device(device).is_cpu else None


@cache
def make_tet_lanes(precision: str) -> SimpleNamespace:
    """Kernels ``deform_linear`` and ``deform_exact``; a thread takes ``GROUP`` tets."""
    types = real(precision)
    scalar, vec3, mat33 = types.scalar, types.vec3, types.mat33
    kernel = types.kernel(SUBJECT)
    group_size = wp.constant(GROUP)
    linear_tet = make_elasticity(precision).deform_tet
    exact_tet = make_exact_volume(precision).deform_tet
    before = prelude(precision) + COMMON
    linear = before + "        if (muscular) {\n" + AREAS + "        }\n" + LINEAR + END

    @types.native(linear)
    def linear_group(
        group: int,
        tets: wp.array(dtype=wp.vec4i),
        rest_inverse: wp.array(dtype=mat33),
        rest_volume: wp.array(dtype=scalar),
        lame: wp.array(dtype=scalar),
        muscular: int,
        positions: wp.array(dtype=vec3),
        rotations: wp.array(dtype=mat33),
        gradients: wp.array(dtype=vec3),
        area_rows: wp.array(dtype=mat33),
        forces: wp.array(dtype=vec3),
        odd_tets: wp.array(dtype=int),
    ): ...

    @types.native(before + AREAS + EXACT + END)
    def exact_group(
        group: int,
        tets: wp.array(dtype=wp.vec4i),
        rest_inverse: wp.array(dtype=mat33),
        rest_volume: wp.array(dtype=scalar),
        lame: wp.array(dtype=scalar),
        muscular: int,
        positions: wp.array(dtype=vec3),
        rotations: wp.array(dtype=mat33),
        gradients: wp.array(dtype=vec3),
        area_rows: wp.array(dtype=mat33),
        forces: wp.array(dtype=vec3),
        volume_gradients: wp.array(dtype=vec3),
        odd_tets: wp.array(dtype=int),
    ): ...

    @kernel
    def deform_linear(
        # model
        tets: wp.array(dtype=wp.vec4i),
        rest_inverse: wp.array(dtype=mat33),
        rest_volume: wp.array(dtype=scalar),
        lame: wp.array(dtype=scalar),
        muscular: int,
        # in
        positions: wp.array(dtype=vec3),
        # out
        rotations: wp.array(dtype=mat33),
        gradients: wp.array(dtype=vec3),
        area_rows: wp.array(dtype=mat33),
        forces: wp.array(dtype=vec3),
        odd_tets: wp.array(dtype=int),
    ):
        g = wp.tid()
        # fmt: off
        linear_group(
            g, tets, rest_inverse, rest_volume, lame, muscular, positions, rotations, gradients,
            area_rows, forces, odd_tets,
        )
        left = odd_tets[g]
        t = group_size * g
        while left != 0:
            if (left & 1) != 0:
                linear_tet(
                    t, tets, rest_inverse, rest_volume, lame, muscular, positions, rotations,
                    gradients, area_rows, forces,
                )
            left = left >> 1
            t += 1
        # fmt: on

    @types.kernel(SUBJECT, "exact")
    def deform_exact(
        # model
        tets: wp.array(dtype=wp.vec4i),
        rest_inverse: wp.array(dtype=mat33),
        rest_volume: wp.array(dtype=scalar),
        lame: wp.array(dtype=scalar),
        muscular: int,
        # in
        positions: wp.array(dtype=vec3),
        # out
        rotations: wp.array(dtype=mat33),
        gradients: wp.array(dtype=vec3),
        area_rows: wp.array(dtype=mat33),
        forces: wp.array(dtype=vec3),
        volume_gradients: wp.array(dtype=vec3),
        odd_tets: wp.array(dtype=int),
    ):
        g = wp.tid()
        # fmt: off
        exact_group(
            g, tets, rest_inverse, rest_volume, lame, muscular, positions, rotations, gradients,
            area_rows, forces, volume_gradients, odd_tets,
        )
        left = odd_tets[g]
        t = group_size * g
        while left != 0:
            if (left & 1) != 0:
                exact_tet(
                    t, tets, rest_inverse, rest_volume, lame, muscular, positions, rotations,
                    gradients, area_rows, forces, volume_gradients,
                )
            left = left >> 1
            t += 1
        # fmt: on

    return SimpleNamespace(deform_linear=deform_linear, deform_exact=deform_exact)
