"""Two-level preconditioner: Gauss-Seidel on the nodes, rigid motions of aggregates underneath.

One application is a forward sweep from zero, a correction out of the coarse space, and a backward
sweep, so it is symmetric and positive definite. The coarse space holds the six rigid motions of
each aggregate of nodes; node i of aggregate I moves by ``Q_i (u_I + w_I x d_i)`` with Q_i its
rotation since rest and d_i its rest place about the middle of I, in units of the aggregate's size.
So the coarse matrix of the rest shape serves for every pose. Rows of the matrix have their columns
in rising order: what stands before the diagonal block is what a forward sweep has passed.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.linear import pcg as cg
from warp_softbody.kernels.linear.bsr_product import make_rows
from warp_softbody.kernels.linear.codes import VelocityConstraint
from warp_softbody.kernels.precision import real

SUBJECT = "two_level"


@cache
def make_two_level(precision: str) -> SimpleNamespace:
    """Kernels of one application; ``warp_softbody.linear.preconditioner`` puts them in order."""
    types = real(precision)
    scalar, vec3, mat33, block = types.scalar, types.vec3, types.mat33, types.block
    kernel, func = types.kernel(SUBJECT), types.func(SUBJECT)
    plain = types.kernel(SUBJECT, "plain")

    project = cg.make_conjugate_gradients(precision).project
    part_of_row = make_rows(precision, SUBJECT).part_of_row

    @kernel
    def invert_pivots(
        # model
        diagonal_slot: wp.array(dtype=int),
        # in
        values: wp.array(dtype=mat33),
        constraints: wp.array(dtype=int),
        constraint_axes: wp.array(dtype=vec3),
        slip_stiffness: wp.array(dtype=mat33),
        # out
        pivot_inverse: wp.array(dtype=mat33),
    ):
        # of the diagonal block on the velocities left free; zero on those that contact gives
        i = wp.tid()
        pivot = values[diagonal_slot[i]] + slip_stiffness[i]
        kind = constraints[i]
        axis = constraint_axes[i]
        inverse = mat33()
        if kind == VelocityConstraint.PLANE:
            across = wp.identity(n=3, dtype=scalar) - wp.outer(axis, axis)
            size = scalar(0.3333333333333333) * wp.trace(pivot)
            bounded = across * pivot * across + size * wp.outer(axis, axis)
            inverse = across * wp.inverse(bounded) * across
        elif kind == VelocityConstraint.LINE:
            inverse = wp.outer(axis, axis) / wp.dot(axis, pivot * axis)
        elif kind != VelocityConstraint.FIXED:
            inverse = wp.inverse(pivot)
        pivot_inverse[i] = scalar(0.5) * (inverse + wp.transpose(inverse))

    @plain
    def sweep_forward(
        # model
        row_start: wp.array(dtype=int),
        column: wp.array(dtype=int),
        diagonal_slot: wp.array(dtype=int),
        # in
        values: wp.array(dtype=mat33),
        pivot_inverse: wp.array(dtype=mat33),
        residual: wp.array(dtype=vec3),
        # out
        z: wp.array(dtype=vec3),
    ):
        for i in range(z.shape[0]):
            known = part_of_row(row_start[i], diagonal_slot[i], column, values, z)
            z[i] = pivot_inverse[i] * (residual[i] - known)

    @plain
    def restrict(
        # model
        row_start: wp.array(dtype=int),
        column: wp.array(dtype=int),
        diagonal_slot: wp.array(dtype=int),
        aggregate_start: wp.array(dtype=int),
        aggregate_nodes: wp.array(dtype=int),
        offsets: wp.array(dtype=vec3),
        # in
        values: wp.array(dtype=mat33),
        constraints: wp.array(dtype=int),
        constraint_axes: wp.array(dtype=vec3),
        rotations: wp.array(dtype=mat33),
        z: wp.array(dtype=vec3),
        # out
        coarse: wp.array(dtype=vec3),
    ):
        # after a forward sweep the residual is minus what stands behind the diagonal
        aggregate = wp.tid()
        force = vec3()
        moment = vec3()
        for k in range(aggregate_start[aggregate], aggregate_start[aggregate + 1]):
            i = aggregate_nodes[k]
            behind = part_of_row(diagonal_slot[i] + 1, row_start[i + 1], column, values, z)
            behind = wp.transpose(rotations[i]) * project(
                constraints[i], constraint_axes[i], behind
            )
            force -= behind
            moment -= wp.cross(offsets[i], behind)
        coarse[2 * aggregate] = force
        coarse[2 * aggregate + 1] = moment

    @plain
    def prolong(
        # model
        aggregate_of: wp.array(dtype=int),
        offsets: wp.array(dtype=vec3),
        # in
        constraints: wp.array(dtype=int),
        constraint_axes: wp.array(dtype=vec3),
        rotations: wp.array(dtype=mat33),
        coarse: wp.array(dtype=vec3),
        # out
        z: wp.array(dtype=vec3),
    ):
        i = wp.tid()
        aggregate = aggregate_of[i]
        if aggregate >= 0:
            motion = coarse[2 * aggregate] + wp.cross(coarse[2 * aggregate + 1], offsets[i])
            z[i] = z[i] + project(constraints[i], constraint_axes[i], rotations[i] * motion)

    @plain
    def sweep_backward(
        # model
        row_start: wp.array(dtype=int),
        column: wp.array(dtype=int),
        diagonal_slot: wp.array(dtype=int),
        # in
        values: wp.array(dtype=mat33),
        pivot_inverse: wp.array(dtype=mat33),
        residual: wp.array(dtype=vec3),
        # out
        z: wp.array(dtype=vec3),
    ):
        count = z.shape[0]
        for back in range(count):
            i = count - 1 - back
            slot = diagonal_slot[i]
            known = part_of_row(row_start[i], slot, column, values, z)
            known += part_of_row(slot + 1, row_start[i + 1], column, values, z)
            z[i] = pivot_inverse[i] * (residual[i] - known)

    @func
    def block_row(
        b: int,
        first: int,
        last: int,
        column: wp.array(dtype=int),
        values: wp.array(dtype=mat33),
        x: wp.array2d(dtype=block),
    ):
        y0 = block()
        y1 = block()
        y2 = block()
        for k in range(first, last):
            A = values[k]
            j = 3 * column[k]
            x0 = x[b, j]
            x1 = x[b, j + 1]
            x2 = x[b, j + 2]
            y0 += A[0, 0] * x0 + A[0, 1] * x1 + A[0, 2] * x2
            y1 += A[1, 0] * x0 + A[1, 1] * x1 + A[1, 2] * x2
            y2 += A[2, 0] * x0 + A[2, 1] * x1 + A[2, 2] * x2
        return y0, y1, y2

    @func
    def block_times(A: mat33, x0: block, x1: block, x2: block):
        y0 = A[0, 0] * x0 + A[0, 1] * x1 + A[0, 2] * x2
        y1 = A[1, 0] * x0 + A[1, 1] * x1 + A[1, 2] * x2
        y2 = A[2, 0] * x0 + A[2, 1] * x1 + A[2, 2] * x2
        return y0, y1, y2

    @func
    def relax_block(
        b: int,
        i: int,
        pivot_inverse: mat33,
        residual: wp.array2d(dtype=block),
        known0: block,
        known1: block,
        known2: block,
        z: wp.array2d(dtype=block),
    ):
        r0 = residual[b, 3 * i] - known0
        r1 = residual[b, 3 * i + 1] - known1
        r2 = residual[b, 3 * i + 2] - known2
        z0, z1, z2 = block_times(pivot_inverse, r0, r1, r2)
        z[b, 3 * i] = z0
        z[b, 3 * i + 1] = z1
        z[b, 3 * i + 2] = z2

    @plain
    def sweep_forward_block(
        # model
        row_start: wp.array(dtype=int),
        column: wp.array(dtype=int),
        diagonal_slot: wp.array(dtype=int),
        # in
        values: wp.array(dtype=mat33),
        pivot_inverse: wp.array(dtype=mat33),
        residual: wp.array2d(dtype=block),
        # out
        z: wp.array2d(dtype=block),
    ):
        b = wp.tid()
        for i in range(diagonal_slot.shape[0]):
            y0, y1, y2 = block_row(b, row_start[i], diagonal_slot[i], column, values, z)
            relax_block(b, i, pivot_inverse[i], residual, y0, y1, y2, z)

    @plain
    def restrict_block(
        # model
        row_start: wp.array(dtype=int),
        column: wp.array(dtype=int),
        diagonal_slot: wp.array(dtype=int),
        aggregate_start: wp.array(dtype=int),
        aggregate_nodes: wp.array(dtype=int),
        offsets: wp.array(dtype=vec3),
        # in
        values: wp.array(dtype=mat33),
        constraints: wp.array(dtype=int),
        constraint_axes: wp.array(dtype=vec3),
        rotations: wp.array(dtype=mat33),
        z: wp.array2d(dtype=block),
        # out
        coarse: wp.array2d(dtype=block),
    ):
        # the controller's matrix has no contact in it: aggregates hold free nodes alone
        b, aggregate = wp.tid()
        f0 = block()
        f1 = block()
        f2 = block()
        m0 = block()
        m1 = block()
        m2 = block()
        for k in range(aggregate_start[aggregate], aggregate_start[aggregate + 1]):
            i = aggregate_nodes[k]
            y0, y1, y2 = block_row(b, diagonal_slot[i] + 1, row_start[i + 1], column, values, z)
            y0, y1, y2 = block_times(wp.transpose(rotations[i]), y0, y1, y2)
            d = offsets[i]
            f0 += y0
            f1 += y1
            f2 += y2
            m0 += d[1] * y2 - d[2] * y1
            m1 += d[2] * y0 - d[0] * y2
            m2 += d[0] * y1 - d[1] * y0
        first = 6 * aggregate
        coarse[b, first] = -f0
        coarse[b, first + 1] = -f1
        coarse[b, first + 2] = -f2
        coarse[b, first + 3] = -m0
        coarse[b, first + 4] = -m1
        coarse[b, first + 5] = -m2

    @plain
    def prolong_block(
        # model
        aggregate_of: wp.array(dtype=int),
        offsets: wp.array(dtype=vec3),
        # in
        constraints: wp.array(dtype=int),
        constraint_axes: wp.array(dtype=vec3),
        rotations: wp.array(dtype=mat33),
        coarse: wp.array2d(dtype=block),
        # out
        z: wp.array2d(dtype=block),
    ):
        b, i = wp.tid()
        if aggregate_of[i] >= 0:
            first = 6 * aggregate_of[i]
            d = offsets[i]
            w0 = coarse[b, first + 3]
            w1 = coarse[b, first + 4]
            w2 = coarse[b, first + 5]
            u0 = coarse[b, first] + w1 * d[2] - w2 * d[1]
            u1 = coarse[b, first + 1] + w2 * d[0] - w0 * d[2]
            u2 = coarse[b, first + 2] + w0 * d[1] - w1 * d[0]
            u0, u1, u2 = block_times(rotations[i], u0, u1, u2)
            z[b, 3 * i] = z[b, 3 * i] + u0
            z[b, 3 * i + 1] = z[b, 3 * i + 1] + u1
            z[b, 3 * i + 2] = z[b, 3 * i + 2] + u2

    @plain
    def sweep_backward_block(
        # model
        row_start: wp.array(dtype=int),
        column: wp.array(dtype=int),
        diagonal_slot: wp.array(dtype=int),
        # in
        values: wp.array(dtype=mat33),
        pivot_inverse: wp.array(dtype=mat33),
        residual: wp.array2d(dtype=block),
        # out
        z: wp.array2d(dtype=block),
    ):
        b = wp.tid()
        count = diagonal_slot.shape[0]
        for back in range(count):
            i = count - 1 - back
            slot = diagonal_slot[i]
            y0, y1, y2 = block_row(b, row_start[i], slot, column, values, z)
            a0, a1, a2 = block_row(b, slot + 1, row_start[i + 1], column, values, z)
            relax_block(b, i, pivot_inverse[i], residual, y0 + a0, y1 + a1, y2 + a2, z)

    return SimpleNamespace(
        invert_pivots=invert_pivots,
        sweep_forward=sweep_forward,
        restrict=restrict,
        prolong=prolong,
        sweep_backward=sweep_backward,
        sweep_forward_block=sweep_forward_block,
        restrict_block=restrict_block,
        prolong_block=prolong_block,
        sweep_backward_block=sweep_backward_block,
    )
