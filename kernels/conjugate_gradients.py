"""Preconditioned conjugate gradients, one right-hand side, on the velocities contact leaves free.

The unknown is v+ in place. Each node is free, slides on a plane (its normal velocity is given) or
on a line (two components are given), or is held; the operator is S (M~ + G) S with S the projector
onto the free velocities and G the slip stiffness, a 3 x 3 block for each sliding node. Sums run
over fixed chunks of nodes in a fixed order, in double precision, so a run repeats bit for bit.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.precision import real
from warp_softbody.kernels.rows import make_rows

SUBJECT = "conjugate_gradients"

FREE = 0
SLIDES = 1
HELD = 2
LINE = 3

RESIDUAL_PRODUCT = 0
TARGET_SQUARE = 1
LAST_SQUARE = 2
STOP_SQUARE = 3
NEW_PRODUCT = 4
CURVATURE = 5
SCALARS = 6

ITERATIONS = 0
CONDITION = 1
TOTAL_ITERATIONS = 2
UNCONVERGED = 3
LOOSE = 7
COUNTERS = 10

LOOSE_REDUCTION = 0.03
"""Reduction of the residual in a solve whose only purpose is to choose contact modes."""


@cache
def make_conjugate_gradients(precision: str) -> SimpleNamespace:
    """Kernels of the iteration; ``warp_softbody.linear_solver`` puts them in order."""
    types = real(precision)
    scalar, vec3, mat33 = types.scalar, types.vec3, types.mat33
    kernel, func = types.kernel(SUBJECT), types.func(SUBJECT)
    free = wp.constant(FREE)
    slides, line = wp.constant(SLIDES), wp.constant(LINE)
    loose_square = wp.constant(wp.float64(LOOSE_REDUCTION * LOOSE_REDUCTION))

    @func
    def project(kind: int, axis: vec3, value: vec3):
        # the axis is normal to the plane of a node that slides, or lies along its line
        if kind == free:
            return value
        if kind == slides:
            return value - wp.dot(axis, value) * axis
        if kind == line:
            return wp.dot(axis, value) * axis
        return vec3()

    part_of_row = make_rows(precision, SUBJECT).part_of_row

    @func
    def row_product(
        i: int,
        row_start: wp.array(dtype=int),
        column: wp.array(dtype=int),
        values: wp.array(dtype=mat33),
        x: wp.array(dtype=vec3),
    ):
        return part_of_row(row_start[i], row_start[i + 1], column, values, x)

    @func
    def double_dot(a: vec3, b: vec3):
        return (
            wp.float64(a[0]) * wp.float64(b[0])
            + wp.float64(a[1]) * wp.float64(b[1])
            + wp.float64(a[2]) * wp.float64(b[2])
        )

    @func
    def total_of(partial: wp.array(dtype=wp.float64)):
        total = wp.float64(0.0)
        for k in range(partial.shape[0]):
            total += partial[k]
        return total

    @kernel
    def set_target(
        # model
        relative_tolerance: wp.array(dtype=wp.float64),
        fixed: wp.array(dtype=int),
        # in
        momentum: wp.array(dtype=vec3),
        # out
        scalars: wp.array(dtype=wp.float64),
    ):
        # a fixed node's right-hand side is what holds it, and is no measure of the motion
        total = wp.float64(0.0)
        for i in range(momentum.shape[0]):
            if fixed[i] == 0:
                total += double_dot(momentum[i], momentum[i])
        tolerance = relative_tolerance[0]
        scalars[TARGET_SQUARE] = tolerance * tolerance * total

    @kernel
    def residual(
        # model
        chunk: int,
        row_start: wp.array(dtype=int),
        column: wp.array(dtype=int),
        # in
        values: wp.array(dtype=mat33),
        kinds: wp.array(dtype=int),
        axes: wp.array(dtype=vec3),
        slip_stiffness: wp.array(dtype=mat33),
        right_side: wp.array(dtype=vec3),
        x: wp.array(dtype=vec3),
        # out
        r: wp.array(dtype=vec3),
        partial: wp.array(dtype=wp.float64),
    ):
        c = wp.tid()
        total = wp.float64(0.0)
        for i in range(c * chunk, wp.min((c + 1) * chunk, x.shape[0])):
            value = right_side[i] - row_product(i, row_start, column, values, x)
            value -= slip_stiffness[i] * x[i]
            value = project(kinds[i], axes[i], value)
            r[i] = value
            total += double_dot(value, value)
        partial[c] = total

    @kernel
    def begin(
        # in
        partial: wp.array(dtype=wp.float64),
        # out
        scalars: wp.array(dtype=wp.float64),
        counters: wp.array(dtype=int),
    ):
        square = total_of(partial)
        scalars[LAST_SQUARE] = square
        scalars[RESIDUAL_PRODUCT] = wp.float64(0.0)
        stop = scalars[TARGET_SQUARE]
        if counters[LOOSE] != 0:
            stop = wp.max(stop, loose_square * square)
        scalars[STOP_SQUARE] = stop
        counters[ITERATIONS] = 0
        counters[CONDITION] = wp.where(square > stop, 1, 0)

    @kernel
    def filtered_product(
        # model
        chunk: int,
        # in
        kinds: wp.array(dtype=int),
        axes: wp.array(dtype=vec3),
        r: wp.array(dtype=vec3),
        # out
        z: wp.array(dtype=vec3),
        partial: wp.array(dtype=wp.float64),
    ):
        c = wp.tid()
        total = wp.float64(0.0)
        for i in range(c * chunk, wp.min((c + 1) * chunk, r.shape[0])):
            value = project(kinds[i], axes[i], z[i])
            z[i] = value
            total += double_dot(r[i], value)
        partial[c] = total

    @kernel
    def add_up(
        # model
        index: int,
        # in
        partial: wp.array(dtype=wp.float64),
        # out
        scalars: wp.array(dtype=wp.float64),
    ):
        # once, for every chunk that needs the sum
        scalars[index] = total_of(partial)

    @kernel
    def direction(
        # model
        chunk: int,
        # in
        scalars: wp.array(dtype=wp.float64),
        z: wp.array(dtype=vec3),
        # out
        p: wp.array(dtype=vec3),
    ):
        # the old product is kept until ``advance`` of this iteration has used the new one
        c = wp.tid()
        old = scalars[RESIDUAL_PRODUCT]
        beta = scalar(0.0)
        if old > wp.float64(0.0):
            beta = scalar(scalars[NEW_PRODUCT] / old)
        for i in range(c * chunk, wp.min((c + 1) * chunk, z.shape[0])):
            p[i] = z[i] + beta * p[i]

    @kernel
    def product(
        # model
        chunk: int,
        row_start: wp.array(dtype=int),
        column: wp.array(dtype=int),
        # in
        values: wp.array(dtype=mat33),
        kinds: wp.array(dtype=int),
        axes: wp.array(dtype=vec3),
        slip_stiffness: wp.array(dtype=mat33),
        p: wp.array(dtype=vec3),
        # out
        q: wp.array(dtype=vec3),
        partial: wp.array(dtype=wp.float64),
    ):
        c = wp.tid()
        total = wp.float64(0.0)
        for i in range(c * chunk, wp.min((c + 1) * chunk, p.shape[0])):
            value = row_product(i, row_start, column, values, p)
            value += slip_stiffness[i] * p[i]
            value = project(kinds[i], axes[i], value)
            q[i] = value
            total += double_dot(p[i], value)
        partial[c] = total

    @kernel
    def advance(
        # model
        chunk: int,
        # in
        scalars: wp.array(dtype=wp.float64),
        p: wp.array(dtype=vec3),
        q: wp.array(dtype=vec3),
        # out
        x: wp.array(dtype=vec3),
        r: wp.array(dtype=vec3),
        partial: wp.array(dtype=wp.float64),
    ):
        c = wp.tid()
        curvature = scalars[CURVATURE]
        alpha = scalar(0.0)
        if curvature > wp.float64(0.0):
            alpha = scalar(scalars[NEW_PRODUCT] / curvature)
        total = wp.float64(0.0)
        for i in range(c * chunk, wp.min((c + 1) * chunk, x.shape[0])):
            x[i] = x[i] + alpha * p[i]
            value = r[i] - alpha * q[i]
            r[i] = value
            total += double_dot(value, value)
        partial[c] = total

    @kernel
    def conclude(
        # model
        max_iterations: int,
        # in
        partial: wp.array(dtype=wp.float64),
        # out
        scalars: wp.array(dtype=wp.float64),
        counters: wp.array(dtype=int),
    ):
        # written so that a residual that is not a number ends the loop
        square = total_of(partial)
        scalars[RESIDUAL_PRODUCT] = scalars[NEW_PRODUCT]
        scalars[LAST_SQUARE] = square
        counters[ITERATIONS] = counters[ITERATIONS] + 1
        counters[TOTAL_ITERATIONS] = counters[TOTAL_ITERATIONS] + 1
        go_on = int(0)
        if square > scalars[STOP_SQUARE]:
            if counters[ITERATIONS] < max_iterations:
                go_on = 1
            else:
                counters[UNCONVERGED] = counters[UNCONVERGED] + 1
        counters[CONDITION] = go_on

    return SimpleNamespace(
        set_target=set_target,
        residual=residual,
        begin=begin,
        filtered_product=filtered_product,
        add_up=add_up,
        direction=direction,
        product=product,
        advance=advance,
        conclude=conclude,
        row_product=row_product,
        project=project,
    )
