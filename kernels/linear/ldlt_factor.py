"""Sparse block factorisation L D L^T on a fixed pattern, on the velocities contact leaves free."""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.linear.codes import VelocityConstraint
from warp_softbody.kernels.linear.warped_ldlt import SUBJECT
from warp_softbody.kernels.precision import real

# Row by row: U_ij = A_ij - sum_k U_ik L_jk^T, L_ij = U_ij D_j^-1, D_i = A_ii - sum_j U_ij L_ij^T.
# Blocks of U and of L^T are three rows of four, a row to a register; unrolled loops would be taken
# apart into single numbers again.
FACTORISE = """
#pragma clang fp contract(fast)
    SCALAR* U = (SCALAR*)upper.data;
    SCALAR* L = (SCALAR*)lower.data;
    SCALAR* T = (SCALAR*)turned.data;
    SCALAR* inverses = (SCALAR*)pivot_inverse.data;
    for (int i = 0; i < count; ++i) {
        SCALAR pivot[9];
        for (int k = 0; k < 9; ++k) pivot[k] = ((const SCALAR*)pivots.data)[9 * i + k];
        for (int s = row_start.data[i]; s < row_start.data[i + 1]; ++s) {
            SCALAR known[12] = {};
            for (int k = update_start.data[s]; k < update_start.data[s + 1]; ++k) {
                const int* pair = (const int*)update_pairs.data + 2 * k;
                const SCALAR* u = U + 12 * pair[0];
                const SCALAR* t = T + 12 * pair[1];
                const SCALAR u00 = u[0], u01 = u[1], u02 = u[2];
                const SCALAR u10 = u[4], u11 = u[5], u12 = u[6];
                const SCALAR u20 = u[8], u21 = u[9], u22 = u[10];
                #pragma clang loop unroll(disable) vectorize(enable) vectorize_width(4)
                for (int b = 0; b < 4; ++b) {
                    const SCALAR t0 = t[b], t1 = t[4 + b], t2 = t[8 + b];
                    known[b] += u00 * t0 + u01 * t1 + u02 * t2;
                    known[4 + b] += u10 * t0 + u11 * t1 + u12 * t2;
                    known[8 + b] += u20 * t0 + u21 * t1 + u22 * t2;
                }
            }
            SCALAR* entry = U + 12 * s;
            #pragma clang loop unroll(disable) vectorize(enable) vectorize_width(4)
            for (int l = 0; l < 12; ++l) entry[l] -= known[l];
            const SCALAR* inverse = inverses + 9 * column.data[s];
            SCALAR below[9];
            for (int a = 0; a < 3; ++a)
                for (int b = 0; b < 3; ++b)
                    below[3 * a + b] = entry[4 * a] * inverse[b]
                        + entry[4 * a + 1] * inverse[3 + b] + entry[4 * a + 2] * inverse[6 + b];
            for (int a = 0; a < 3; ++a)
                for (int b = 0; b < 3; ++b) {
                    L[9 * s + 3 * a + b] = below[3 * a + b];
                    T[12 * s + 4 * b + a] = below[3 * a + b];
                    pivot[3 * a + b] -= entry[4 * a] * below[3 * b]
                        + entry[4 * a + 1] * below[3 * b + 1]
                        + entry[4 * a + 2] * below[3 * b + 2];
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
        update_start: wp.array(dtype=int),
        update_pairs: wp.array(dtype=wp.vec2i),
        pivots: wp.array(dtype=mat33),
        upper: wp.array(dtype=mat34),
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
        update_start: wp.array(dtype=int),
        update_pairs: wp.array(dtype=wp.vec2i),
        # in
        pivots: wp.array(dtype=mat33),
        # in and out
        upper: wp.array(dtype=mat34),
        # out
        turned: wp.array(dtype=mat34),
        lower: wp.array(dtype=mat33),
        pivot_inverse: wp.array(dtype=mat33),
    ):
        # fmt: off
        factorise_rows(
            count, row_start, column, update_start, update_pairs, pivots,
            upper, turned, lower, pivot_inverse,
        )
        # fmt: on

    return SimpleNamespace(
        mat34=mat34, gather_pivots=gather_pivots, gather_blocks=gather_blocks, factorise=factorise
    )
