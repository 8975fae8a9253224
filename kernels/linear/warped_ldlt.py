"""The factor as a preconditioner, turned with the nodes, and solves with 16 right-hand sides.

The factor L D L^T (``factorisation``) is of some earlier step's matrix. Between steps the matrix
changes almost only by the rotations of the nodes, so the solve turns its right-hand side back by
each node's rotation since then, and its result forth: P = Q L^-T D^-1 L^-1 Q^T, symmetric and
positive definite whatever happened since (a warped preconditioner, after Courtecuisse et al. 2010).
Rows are kept in elimination order. One logical thread walks it, for one right-hand side or a block
of them. ``supernodes`` and ``block_lanes`` have the same in native code.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.precision import real

SUBJECT = "cholesky"


@cache
def make_cholesky(precision: str) -> SimpleNamespace:
    """Kernels of the turns and of the solve, in the order of their launch."""
    types = real(precision)
    vec3, mat33, block = types.vec3, types.mat33, types.block
    kernel, plain = types.kernel(SUBJECT), types.kernel(SUBJECT, "plain")

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

    @plain
    def precondition(
        # model
        count: int,
        order: wp.array(dtype=int),
        row_start: wp.array(dtype=int),
        column: wp.array(dtype=int),
        # in
        lower: wp.array(dtype=mat33),
        pivot_inverse: wp.array(dtype=mat33),
        turns: wp.array(dtype=mat33),
        residual: wp.array(dtype=vec3),
        # out
        work: wp.array(dtype=vec3),
        result: wp.array(dtype=vec3),
    ):
        for i in range(count):
            y = wp.transpose(turns[order[i]]) * residual[order[i]]
            for s in range(row_start[i], row_start[i + 1]):
                y -= lower[s] * work[column[s]]
            work[i] = y
        for i in range(count):
            work[i] = pivot_inverse[i] * work[i]
        for back in range(count):
            i = count - 1 - back
            z = work[i]
            for s in range(row_start[i], row_start[i + 1]):
                work[column[s]] = work[column[s]] - wp.transpose(lower[s]) * z
            result[order[i]] = turns[order[i]] * z

    @plain
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
        keep_rotations=keep_rotations,
        node_turns=node_turns,
        precondition=precondition,
        precondition_block=precondition_block,
    )
