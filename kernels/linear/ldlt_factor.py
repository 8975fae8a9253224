"""Sparse block factorisation L D L^T on a fixed pattern, on the velocities contact leaves free."""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.linear.codes import VelocityConstraint
from warp_softbody.kernels.linear.warped_ldlt import SUBJECT
from warp_softbody.kernels.precision import real

# Row by row: U_ij = A_ij - sum_k U_ik L_jk^T, L_ij = U_ij D_j^-1, D_i = A_ii - sum_j U_ij L_ij^T.
# A block of U that is finished is taken at once to the later blocks of its row, which wait in a row
# as long as the matrix: wherever L has (i, j) and (m, j), j < m < i, it has (i, m).
# L^T is kept by columns. Blocks of U and of L^T are three rows of four, a row to a register;
# unrolled loops would be taken apart into single numbers again.
FACTORISE = """
#pragma clang fp contract(fast)
    typedef SCALAR four __attribute__((vector_size(4 * sizeof(SCALAR)), aligned(sizeof(SCALAR))));
    SCALAR* U = (SCALAR*)upper.data;
    SCALAR* L = (SCALAR*)lower.data;
    SCALAR* T = (SCALAR*)turned.data;
    SCALAR* known = (SCALAR*)waiting.data;
    SCALAR* inverses = (SCALAR*)pivot_inverse.data;
    for (int i = 0; i < count; ++i) {
        SCALAR pivot[9];
        for (int k = 0; k < 9; ++k) pivot[k] = ((const SCALAR*)pivots.data)[9 * i + k];
        for (int s = row_start.data[i]; s < row_start.data[i + 1]; ++s) {
            SCALAR* empty = known + 12 * column.data[s];
            for (int l = 0; l < 12; ++l) empty[l] = 0;
        }
        for (int s = row_start.data[i]; s < row_start.data[i + 1]; ++s) {
            const int j = column.data[s], place = column_place.data[s];
            SCALAR* entry = U + 12 * s;
            #pragma clang loop unroll(disable) vectorize(enable) vectorize_width(4)
            for (int l = 0; l < 12; ++l) entry[l] -= known[12 * j + l];
            const SCALAR* inverse = inverses + 9 * j;
            SCALAR below[9];
            for (int a = 0; a < 3; ++a)
                for (int b = 0; b < 3; ++b)
                    below[3 * a + b] = entry[4 * a] * inverse[b]
                        + entry[4 * a + 1] * inverse[3 + b] + entry[4 * a + 2] * inverse[6 + b];
            for (int a = 0; a < 3; ++a)
                for (int b = 0; b < 3; ++b) {
                    L[9 * s + 3 * a + b] = below[3 * a + b];
                    T[12 * place + 4 * b + a] = below[3 * a + b];
                    pivot[3 * a + b] -= entry[4 * a] * below[3 * b]
                        + entry[4 * a + 1] * below[3 * b + 1]
                        + entry[4 * a + 2] * below[3 * b + 2];
                }
            const SCALAR u00 = entry[0], u01 = entry[1], u02 = entry[2];
            const SCALAR u10 = entry[4], u11 = entry[5], u12 = entry[6];
            const SCALAR u20 = entry[8], u21 = entry[9], u22 = entry[10];
            for (int k = column_start.data[j]; k < place; ++k) {
                four* sum = (four*)(known + 12 * column_row.data[k]);
                const four* t = (const four*)(T + 12 * k);
                const four t0 = t[0], t1 = t[1], t2 = t[2];
                sum[0] += u00 * t0 + u01 * t1 + u02 * t2;
                sum[1] += u10 * t0 + u11 * t1 + u12 * t2;
                sum[2] += u20 * t0 + u21 * t1 + u22 * t2;
            }
        }
        wp::mat_t<3, 3, SCALAR> whole;
        for (int k = 0; k < 9; ++k) whole.data[k / 3][k % 3] = pivot[k];
        const wp::mat_t<3, 3, SCALAR> inverse = wp::inverse(whole);
        for (int a = 0; a < 3; ++a)
            for (int b = 0; b < 3; ++b)
                inverses[9 * i + 3 * a + b]
                    = (SCALAR)0.5 * (inverse.data[a][b] + inverse.data[b][a]);
    }
"""


@cache
def make_factorisation(precision: str) -> SimpleNamespace:
    """Kernels in the order of their launch, and ``mat34``, the type of padded blocks."""
    types = real(precision)
    scalar, vec3, mat33 = types.scalar, types.vec3, types.mat33
    mat34 = wp.types.matrix(shape=(3, 4), dtype=scalar)
    zero = wp.constant(scalar(0.0))
    kernel, func = types.kernel(SUBJECT), types.func(SUBJECT)

    @func
    def project_rows(kind: int, axis: vec3, value: mat33):
        if kind == VelocityConstraint.PLANE:
            return value - wp.outer(axis, wp.transpose(value) * axis)
        if kind == VelocityConstraint.LINE:
            return wp.outer(axis, wp.transpose(value) * axis)
        if kind == VelocityConstraint.FIXED:
            return mat33()
        return value

    @kernel
    def gather_pivots(
        # model
        order: wp.array(dtype=int),
        diagonal_slot: wp.array(dtype=int),
        margin: scalar,
        # in
        values: wp.array(dtype=mat33),
        constraints: wp.array(dtype=int),
        constraint_axes: wp.array(dtype=vec3),
        slip_stiffness: wp.array(dtype=mat33),
        # out
        pivots: wp.array(dtype=mat33),
    ):
        # diagonal blocks of A: the matrix with slip stiffness on the velocities that contact leaves
        # free, and a multiple of the identity on those it gives. ``margin``: part of itself added
        i = wp.tid()
        node = order[i]
        kind = constraints[node]
        axis = constraint_axes[node]
        pivot = wp.identity(n=3, dtype=scalar)
        if diagonal_slot[i] >= 0:
            pivot = values[diagonal_slot[i]] + slip_stiffness[node]
            given = scalar(0.3333333333333333) * wp.trace(pivot)
            if kind == VelocityConstraint.PLANE:
                pivot = project_rows(kind, axis, pivot)
                pivot = project_rows(kind, axis, wp.transpose(pivot))
                pivot += given * wp.outer(axis, axis)
            if kind == VelocityConstraint.LINE:
                size = wp.dot(axis, pivot * axis) - given
                pivot = size * wp.outer(axis, axis) + given * wp.identity(n=3, dtype=scalar)
            if kind == VelocityConstraint.FIXED:
                pivot = given * wp.identity(n=3, dtype=scalar)
            # what elimination subtracts may leave less of a stiff body's mass than rounding takes
            pivot += (margin * given) * wp.identity(n=3, dtype=scalar)
        pivots[i] = pivot

    @kernel
    def gather_blocks(
        # model
        row: wp.array(dtype=int),
        column: wp.array(dtype=int),
        matrix_slot: wp.array(dtype=int),
        order: wp.array(dtype=int),
        # in
        values: wp.array(dtype=mat33),
        constraints: wp.array(dtype=int),
        constraint_axes: wp.array(dtype=vec3),
        # out
        upper: wp.array(dtype=mat34),
    ):
        # the other blocks of A, on the pattern of the factor
        s = wp.tid()
        entry = mat33()
        if matrix_slot[s] >= 0:
            node = order[row[s]]
            other = order[column[s]]
            entry = values[matrix_slot[s]]
            if constraints[node] != VelocityConstraint.NONE:
                entry = project_rows(constraints[node], constraint_axes[node], entry)
            if constraints[other] != VelocityConstraint.NONE:
                across = project_rows(
                    constraints[other], constraint_axes[other], wp.transpose(entry)
                )
                entry = wp.transpose(across)
        # fmt: off
        upper[s] = mat34(
            entry[0, 0], entry[0, 1], entry[0, 2], zero,
            entry[1, 0], entry[1, 1], entry[1, 2], zero,
            entry[2, 0], entry[2, 1], entry[2, 2], zero,
        )
        # fmt: on

    @types.native(FACTORISE)
    def factorise_rows(
        count: int,
        row_start: wp.array(dtype=int),
        column: wp.array(dtype=int),
        column_start: wp.array(dtype=int),
        column_row: wp.array(dtype=int),
        column_place: wp.array(dtype=int),
        pivots: wp.array(dtype=mat33),
        upper: wp.array(dtype=mat34),
        waiting: wp.array(dtype=mat34),
        turned: wp.array(dtype=mat34),
        lower: wp.array(dtype=mat33),
        pivot_inverse: wp.array(dtype=mat33),
    ): ...

    @kernel
    def factorise(
        # model
        count: int,
        row_start: wp.array(dtype=int),
        column: wp.array(dtype=int),
        column_start: wp.array(dtype=int),
        column_row: wp.array(dtype=int),
        column_place: wp.array(dtype=int),
        # in
        pivots: wp.array(dtype=mat33),
        # in and out
        upper: wp.array(dtype=mat34),
        # out
        waiting: wp.array(dtype=mat34),
        turned: wp.array(dtype=mat34),
        lower: wp.array(dtype=mat33),
        pivot_inverse: wp.array(dtype=mat33),
    ):
        # fmt: off
        factorise_rows(
            count, row_start, column, column_start, column_row, column_place, pivots,
            upper, waiting, turned, lower, pivot_inverse,
        )
        # fmt: on

    return SimpleNamespace(
        mat34=mat34, gather_pivots=gather_pivots, gather_blocks=gather_blocks, factorise=factorise
    )
