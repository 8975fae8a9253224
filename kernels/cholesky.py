"""Sparse block factorisation L D L^T on a fixed pattern, and solves with 16 right-hand sides.

The factor is of some earlier step's matrix. Between steps the matrix changes almost only by the
rotations of the nodes, so the solve turns its right-hand side back by each node's rotation since
then, and its result forth: P = Q L^-T D^-1 L^-1 Q^T, symmetric and positive definite whatever
happened since (a warped preconditioner, after Courtecuisse et al. 2010). Rows are kept in
elimination order. One logical thread walks the elimination order of one block of right-hand sides;
``supernodes`` has the solve with a single one.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels import conjugate_gradients as cg
from warp_softbody.kernels.precision import real

SUBJECT = "cholesky"


@cache
def make_cholesky(precision: str) -> SimpleNamespace:
    """Kernels of the factorisation and of the solves, in the order of their launch."""
    types = real(precision)
    scalar, vec3, mat33, block = types.scalar, types.vec3, types.mat33, types.block
    kernel, func = types.kernel(SUBJECT), types.func(SUBJECT)
    free, slides = wp.constant(cg.FREE), wp.constant(cg.SLIDES)
    held, line = wp.constant(cg.HELD), wp.constant(cg.LINE)

    @func
    def project_rows(kind: int, axis: vec3, value: mat33):
        if kind == slides:
            return value - wp.outer(axis, wp.transpose(value) * axis)
        if kind == line:
            return wp.outer(axis, wp.transpose(value) * axis)
        if kind == held:
            return mat33()
        return value

    @kernel
    def gather_pivots(
        # model
        order: wp.array(dtype=int),
        diagonal_slot: wp.array(dtype=int),
        # in
        values: wp.array(dtype=mat33),
        kinds: wp.array(dtype=int),
        axes: wp.array(dtype=vec3),
        slip_stiffness: wp.array(dtype=mat33),
        # out
        pivots: wp.array(dtype=mat33),
    ):
        # diagonal blocks of A: the matrix with slip stiffness on the velocities that contact leaves
        # free, and a multiple of the identity on those it gives
        i = wp.tid()
        node = order[i]
        kind = kinds[node]
        axis = axes[node]
        pivot = wp.identity(n=3, dtype=scalar)
        if diagonal_slot[i] >= 0:
            pivot = values[diagonal_slot[i]] + slip_stiffness[node]
            given = scalar(0.3333333333333333) * wp.trace(pivot)
            if kind == slides:
                pivot = project_rows(kind, axis, pivot)
                pivot = project_rows(kind, axis, wp.transpose(pivot))
                pivot += given * wp.outer(axis, axis)
            if kind == line:
                size = wp.dot(axis, pivot * axis) - given
                pivot = size * wp.outer(axis, axis) + given * wp.identity(n=3, dtype=scalar)
            if kind == held:
                pivot = given * wp.identity(n=3, dtype=scalar)
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
        kinds: wp.array(dtype=int),
        axes: wp.array(dtype=vec3),
        # out
        upper: wp.array(dtype=mat33),
    ):
        # the other blocks of A, on the pattern of the factor
        s = wp.tid()
        entry = mat33()
        if matrix_slot[s] >= 0:
            node = order[row[s]]
            other = order[column[s]]
            entry = values[matrix_slot[s]]
            if kinds[node] != free:
                entry = project_rows(kinds[node], axes[node], entry)
            if kinds[other] != free:
                across = project_rows(kinds[other], axes[other], wp.transpose(entry))
                entry = wp.transpose(across)
        upper[s] = entry

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
        upper: wp.array(dtype=mat33),
        # out
        lower: wp.array(dtype=mat33),
        pivot_inverse: wp.array(dtype=mat33),
    ):
        # row by row: U_ij = A_ij - sum_k U_ik L_jk^T, L_ij = U_ij D_j^-1, D_i = A_ii - sum_j U_ij
        # L_ij^T
        for i in range(count):
            pivot = pivots[i]
            for s in range(row_start[i], row_start[i + 1]):
                known = mat33()
                for k in range(update_start[s], update_start[s + 1]):
                    pair = update_pairs[k]
                    known += upper[pair[0]] * wp.transpose(lower[pair[1]])
                entry = upper[s] - known
                upper[s] = entry
                below = entry * pivot_inverse[column[s]]
                lower[s] = below
                pivot -= entry * wp.transpose(below)
            inverse = wp.inverse(pivot)
            pivot_inverse[i] = scalar(0.5) * (inverse + wp.transpose(inverse))

    @kernel
    def keep_rotations(
        # in
        node_rotations: wp.array(dtype=mat33),
        # out
        factor_rotations: wp.array(dtype=mat33),
    ):
        i = wp.tid()
        factor_rotations[i] = node_rotations[i]

    @kernel
    def node_turns(
        # in
        node_rotations: wp.array(dtype=mat33),
        factor_rotations: wp.array(dtype=mat33),
        # out
        turns: wp.array(dtype=mat33),
    ):
        i = wp.tid()
        turns[i] = node_rotations[i] * wp.transpose(factor_rotations[i])

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
        b = wp.tid()
        for i in range(count):
            node = order[i]
            Q = turns[node]
            r0 = residual[b, 3 * node]
            r1 = residual[b, 3 * node + 1]
            r2 = residual[b, 3 * node + 2]
            y0 = block()
            y1 = block()
            y2 = block()
            for s in range(row_start[i], row_start[i + 1]):
                L = lower[s]
                j = 3 * column[s]
                w0 = work[b, j]
                w1 = work[b, j + 1]
                w2 = work[b, j + 2]
                y0 += L[0, 0] * w0 + L[0, 1] * w1 + L[0, 2] * w2
                y1 += L[1, 0] * w0 + L[1, 1] * w1 + L[1, 2] * w2
                y2 += L[2, 0] * w0 + L[2, 1] * w1 + L[2, 2] * w2
            work[b, 3 * i] = Q[0, 0] * r0 + Q[1, 0] * r1 + Q[2, 0] * r2 - y0
            work[b, 3 * i + 1] = Q[0, 1] * r0 + Q[1, 1] * r1 + Q[2, 1] * r2 - y1
            work[b, 3 * i + 2] = Q[0, 2] * r0 + Q[1, 2] * r1 + Q[2, 2] * r2 - y2
        for i in range(count):
            D = pivot_inverse[i]
            y0 = work[b, 3 * i]
            y1 = work[b, 3 * i + 1]
            y2 = work[b, 3 * i + 2]
            work[b, 3 * i] = D[0, 0] * y0 + D[0, 1] * y1 + D[0, 2] * y2
            work[b, 3 * i + 1] = D[1, 0] * y0 + D[1, 1] * y1 + D[1, 2] * y2
            work[b, 3 * i + 2] = D[2, 0] * y0 + D[2, 1] * y1 + D[2, 2] * y2
        for back in range(count):
            i = count - 1 - back
            z0 = work[b, 3 * i]
            z1 = work[b, 3 * i + 1]
            z2 = work[b, 3 * i + 2]
            for s in range(row_start[i], row_start[i + 1]):
                L = lower[s]
                j = 3 * column[s]
                work[b, j] = work[b, j] - (L[0, 0] * z0 + L[1, 0] * z1 + L[2, 0] * z2)
                work[b, j + 1] = work[b, j + 1] - (L[0, 1] * z0 + L[1, 1] * z1 + L[2, 1] * z2)
                work[b, j + 2] = work[b, j + 2] - (L[0, 2] * z0 + L[1, 2] * z1 + L[2, 2] * z2)
            node = order[i]
            Q = turns[node]
            result[b, 3 * node] = Q[0, 0] * z0 + Q[0, 1] * z1 + Q[0, 2] * z2
            result[b, 3 * node + 1] = Q[1, 0] * z0 + Q[1, 1] * z1 + Q[1, 2] * z2
            result[b, 3 * node + 2] = Q[2, 0] * z0 + Q[2, 1] * z1 + Q[2, 2] * z2

    return SimpleNamespace(
        gather_pivots=gather_pivots,
        gather_blocks=gather_blocks,
        factorise=factorise,
        keep_rotations=keep_rotations,
        node_turns=node_turns,
        precondition_block=precondition_block,
    )
