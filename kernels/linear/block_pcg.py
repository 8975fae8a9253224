"""Conjugate gradients for blocks of 16 right-hand sides side by side: the controller's M~ W = J^T.

Every right-hand side runs its own iteration with its own step lengths; they share the sweeps over
the matrix and over the preconditioner, which is where the time goes, and each block fills one
vector register. On processors ``block_lanes`` stands in for the products with the matrix.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.linear.codes import BlockCounter
from warp_softbody.kernels.precision import BLOCK, real

SUBJECT = "block_gradients"


@cache
def make_block_gradients(precision: str) -> SimpleNamespace:
    """Kernels of the block iteration, put in order by the reduced dynamics of the engine."""
    types = real(precision)
    scalar, vec3, mat33, block = types.scalar, types.vec3, types.mat33, types.block
    kernel, func = types.kernel(SUBJECT), types.func(SUBJECT)
    plain = types.kernel(SUBJECT, "plain")
    width = wp.constant(BLOCK)

    @func
    def total_of(partial: wp.array2d(dtype=block), b: int):
        total = block()
        for k in range(partial.shape[1]):
            total += partial[b, k]
        return total

    @func
    def ratio(numerator: block, denominator: block):
        result = block()
        for k in range(width):
            if denominator[k] > scalar(0.0):
                result[k] = numerator[k] / denominator[k]
        return result

    @func
    def product(
        b: int,
        i: int,
        row_start: wp.array(dtype=int),
        column: wp.array(dtype=int),
        damped_masses: wp.array(dtype=scalar),
        values: wp.array(dtype=mat33),
        x: wp.array2d(dtype=block),
    ):
        # rows of M~ x, the stiffness by differences across edges (``bsr_product.py``)
        own0 = x[b, 3 * i]
        own1 = x[b, 3 * i + 1]
        own2 = x[b, 3 * i + 2]
        y0 = block()
        y1 = block()
        y2 = block()
        for k in range(row_start[i], row_start[i + 1]):
            A = values[k]
            j = 3 * column[k]
            x0 = x[b, j] - own0
            x1 = x[b, j + 1] - own1
            x2 = x[b, j + 2] - own2
            y0 += A[0, 0] * x0 + A[0, 1] * x1 + A[0, 2] * x2
            y1 += A[1, 0] * x0 + A[1, 1] * x1 + A[1, 2] * x2
            y2 += A[2, 0] * x0 + A[2, 1] * x1 + A[2, 2] * x2
        mass = damped_masses[i]
        return y0 + mass * own0, y1 + mass * own1, y2 + mass * own2

    @plain
    def residual(
        # model
        chunk: int,
        count: int,
        fixed: wp.array(dtype=int),
        row_start: wp.array(dtype=int),
        column: wp.array(dtype=int),
        damped_masses: wp.array(dtype=scalar),
        # in
        values: wp.array(dtype=mat33),
        right: wp.array2d(dtype=block),
        x: wp.array2d(dtype=block),
        # out
        r: wp.array2d(dtype=block),
        partial: wp.array2d(dtype=block),
    ):
        # r = right - A x and its squares
        b, c = wp.tid()
        total = block()
        for i in range(c * chunk, wp.min((c + 1) * chunk, count)):
            r0, r1, r2 = product(b, i, row_start, column, damped_masses, values, x)
            r0 = right[b, 3 * i] - r0
            r1 = right[b, 3 * i + 1] - r1
            r2 = right[b, 3 * i + 2] - r2
            if fixed[i] != 0:
                r0 = block()
                r1 = block()
                r2 = block()
            r[b, 3 * i] = r0
            r[b, 3 * i + 1] = r1
            r[b, 3 * i + 2] = r2
            total += wp.cw_mul(r0, r0) + wp.cw_mul(r1, r1) + wp.cw_mul(r2, r2)
        partial[b, c] = total

    @kernel
    def squares(
        # model
        chunk: int,
        count: int,
        # in
        right: wp.array2d(dtype=block),
        # out
        partial: wp.array2d(dtype=block),
    ):
        b, c = wp.tid()
        total = block()
        for i in range(c * chunk, wp.min((c + 1) * chunk, count)):
            r0 = right[b, 3 * i]
            r1 = right[b, 3 * i + 1]
            r2 = right[b, 3 * i + 2]
            total += wp.cw_mul(r0, r0) + wp.cw_mul(r1, r1) + wp.cw_mul(r2, r2)
        partial[b, c] = total

    @kernel
    def set_targets(
        # model
        tolerance: wp.array(dtype=scalar),
        # in
        partial: wp.array2d(dtype=block),
        # out
        targets: wp.array(dtype=block),
    ):
        b = wp.tid()
        targets[b] = (tolerance[0] * tolerance[0]) * total_of(partial, b)

    @kernel
    def begin(
        # in
        partial: wp.array2d(dtype=block),
        targets: wp.array(dtype=block),
        # out
        old_product: wp.array(dtype=block),
        counters: wp.array(dtype=int),
    ):
        go_on = int(0)
        for b in range(targets.shape[0]):
            square = total_of(partial, b)
            target = targets[b]
            old_product[b] = block()
            for k in range(width):
                if square[k] > target[k]:
                    go_on = 1
        counters[BlockCounter.ITERATIONS] = 0
        counters[BlockCounter.CONDITION] = go_on

    @kernel
    def add_up(
        # in
        partial: wp.array2d(dtype=block),
        # out
        total: wp.array(dtype=block),
    ):
        # once, for every chunk that needs the sum
        b = wp.tid()
        total[b] = total_of(partial, b)

    @kernel
    def products(
        # model
        chunk: int,
        count: int,
        fixed: wp.array(dtype=int),
        # in
        r: wp.array2d(dtype=block),
        # out
        z: wp.array2d(dtype=block),
        partial: wp.array2d(dtype=block),
    ):
        b, c = wp.tid()
        total = block()
        for i in range(c * chunk, wp.min((c + 1) * chunk, count)):
            if fixed[i] != 0:
                z[b, 3 * i] = block()
                z[b, 3 * i + 1] = block()
                z[b, 3 * i + 2] = block()
            total += wp.cw_mul(r[b, 3 * i], z[b, 3 * i])
            total += wp.cw_mul(r[b, 3 * i + 1], z[b, 3 * i + 1])
            total += wp.cw_mul(r[b, 3 * i + 2], z[b, 3 * i + 2])
        partial[b, c] = total

    @kernel
    def direction(
        # model
        chunk: int,
        count: int,
        # in
        product: wp.array(dtype=block),
        old_product: wp.array(dtype=block),
        z: wp.array2d(dtype=block),
        # out
        p: wp.array2d(dtype=block),
    ):
        b, c = wp.tid()
        beta = ratio(product[b], old_product[b])
        for i in range(3 * c * chunk, 3 * wp.min((c + 1) * chunk, count)):
            p[b, i] = z[b, i] + wp.cw_mul(beta, p[b, i])

    @plain
    def curvature(
        # model
        chunk: int,
        count: int,
        fixed: wp.array(dtype=int),
        row_start: wp.array(dtype=int),
        column: wp.array(dtype=int),
        damped_masses: wp.array(dtype=scalar),
        # in
        values: wp.array(dtype=mat33),
        p: wp.array2d(dtype=block),
        # out
        q: wp.array2d(dtype=block),
        partial: wp.array2d(dtype=block),
    ):
        b, c = wp.tid()
        total = block()
        for i in range(c * chunk, wp.min((c + 1) * chunk, count)):
            q0 = block()
            q1 = block()
            q2 = block()
            if fixed[i] == 0:
                q0, q1, q2 = product(b, i, row_start, column, damped_masses, values, p)
            q[b, 3 * i] = q0
            q[b, 3 * i + 1] = q1
            q[b, 3 * i + 2] = q2
            total += wp.cw_mul(q0, p[b, 3 * i])
            total += wp.cw_mul(q1, p[b, 3 * i + 1])
            total += wp.cw_mul(q2, p[b, 3 * i + 2])
        partial[b, c] = total

    @kernel
    def advance(
        # model
        chunk: int,
        count: int,
        # in
        product: wp.array(dtype=block),
        curvature: wp.array(dtype=block),
        p: wp.array2d(dtype=block),
        q: wp.array2d(dtype=block),
        # out
        x: wp.array2d(dtype=block),
        r: wp.array2d(dtype=block),
        partial: wp.array2d(dtype=block),
    ):
        b, c = wp.tid()
        alpha = ratio(product[b], curvature[b])
        total = block()
        for i in range(3 * c * chunk, 3 * wp.min((c + 1) * chunk, count)):
            x[b, i] = x[b, i] + wp.cw_mul(alpha, p[b, i])
            value = r[b, i] - wp.cw_mul(alpha, q[b, i])
            r[b, i] = value
            total += wp.cw_mul(value, value)
        partial[b, c] = total

    @kernel
    def conclude(
        # model
        max_iterations: int,
        # in
        product: wp.array(dtype=block),
        partial: wp.array2d(dtype=block),
        targets: wp.array(dtype=block),
        # out
        old_product: wp.array(dtype=block),
        counters: wp.array(dtype=int),
    ):
        go_on = int(0)
        for b in range(targets.shape[0]):
            old_product[b] = product[b]
            square = total_of(partial, b)
            target = targets[b]
            for k in range(width):
                if square[k] > target[k]:
                    go_on = 1
        counters[BlockCounter.ITERATIONS] = counters[BlockCounter.ITERATIONS] + 1
        counters[BlockCounter.CONDITION] = wp.where(
            counters[BlockCounter.ITERATIONS] < max_iterations, go_on, 0
        )

    @kernel
    def free_response(
        # model
        count: int,
        # in
        responses: wp.array2d(dtype=block),
        momentum: wp.array(dtype=vec3),
        # out
        response: wp.array(dtype=block),
    ):
        # W^T b, b the known part of the right-hand side
        b = wp.tid()
        total = block()
        for i in range(count):
            m = momentum[i]
            total += m[0] * responses[b, 3 * i]
            total += m[1] * responses[b, 3 * i + 1]
            total += m[2] * responses[b, 3 * i + 2]
        response[b] = total

    return SimpleNamespace(
        residual=residual,
        squares=squares,
        set_targets=set_targets,
        begin=begin,
        add_up=add_up,
        products=products,
        direction=direction,
        curvature=curvature,
        advance=advance,
        conclude=conclude,
        free_response=free_response,
    )
