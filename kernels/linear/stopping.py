"""When conjugate gradients stop: at a tolerance, or with the error of the time step.

A step that follows its time error starts its solve from the velocities extrapolated from the last
two. They are off by (v+ - v) - (v - v-), twice the error that the implicit Euler step makes in v+.
As M~ >= M, the residual bounds the momentum that an unfinished solve is off by; it may be
``TIME_ERROR_SHARE`` of the step's own error, and need not be less than the tolerance allows. What
is left of the net momentum shows as a force from nowhere, and may be ``NET_SHARE`` of that error.

The tolerance is relative to the momentum of the nodes. Of a fast body in short steps that would be
more than a step changes, so it allows at most ``MOST_OF_CHANGE`` times as much of the impulses that
the step is given, or of the largest residual that one of its solves starts from.

Solves that only seek contact modes stop at a reduction of their residual instead. Those of a hasty
solver stop far earlier in the first passes of a step, and its first solve is of that kind where the
modes of the last step took long to settle; the last solve of a step is one to the tolerance.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.linear.codes import Counter, Scalar
from warp_softbody.kernels.precision import real

SUBJECT = "conjugate_gradients"

LOOSE_REDUCTION = 0.03
"""Reduction of the residual in a solve whose only purpose is to choose contact modes."""

EARLY_REDUCTIONS = ((3, 0.2), (6, 0.1))
"""The same of a hasty solver, before so many passes of a step: its early modes are guesses."""

UNSETTLED_PASSES = 3
"""Passes of the last step from which on a hasty solver takes the first one of the next step for
such a guess too; a step that merely lasts needs one or two."""

MOST_OF_CHANGE = 30.0
"""Times the tolerance, of what a step changes, that its residual may be."""

TIME_ERROR_SHARE = 0.05
"""Of the error that the step itself makes, what the solve may add where it follows that error."""

NET_SHARE = 0.002
"""The same of the net momentum of all nodes."""


@cache
def make_stopping(precision: str) -> SimpleNamespace:
    """Kernels that set, follow and check the residual at which the iteration stops."""
    types = real(precision)
    scalar, vec3 = types.scalar, types.vec3
    kernel, func = types.kernel(SUBJECT), types.func(SUBJECT)
    most_square = wp.constant(wp.float64(MOST_OF_CHANGE * MOST_OF_CHANGE))
    loose_square = wp.constant(wp.float64(LOOSE_REDUCTION * LOOSE_REDUCTION))
    (first_passes, first), (second_passes, second) = EARLY_REDUCTIONS
    first_passes, second_passes = wp.constant(first_passes), wp.constant(second_passes)
    first_square = wp.constant(wp.float64(first * first))
    second_square = wp.constant(wp.float64(second * second))
    unsettled_passes = wp.constant(UNSETTLED_PASSES)
    share_square = wp.constant(wp.float64((0.5 * TIME_ERROR_SHARE) ** 2))
    net_square = wp.constant(wp.float64((0.5 * NET_SHARE) ** 2))

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

    @func
    def net_is_left(
        count: int,
        change_partial: wp.array(dtype=wp.float64),
        net_partial: wp.array(dtype=wp.vec3d),
        square: wp.float64,
        scalars: wp.array(dtype=wp.float64),
    ):
        # nodes that move alike have a momentum of sqrt(count) times the norm over them
        net = wp.vec3d()
        for k in range(net_partial.shape[0]):
            net += net_partial[k]
        allowed = net_square * wp.float64(count) * total_of(change_partial)
        size = wp.length_sq(net)  # type: ignore[call-overload]
        return size > allowed and square > scalars[Scalar.FLOOR_SQUARE]

    @kernel
    def begin_step(
        # model
        hasty: int,
        # in and out
        counters: wp.array(dtype=int),
    ):
        # counters are those of the last step
        guess = hasty != 0 and counters[Counter.PASSES] >= unsettled_passes
        for k in range(counters.shape[0]):
            counters[k] = 0
        counters[Counter.LOOSE] = wp.where(guess, 1, 0)

    @kernel
    def set_target(
        # model
        relative_tolerance: wp.array(dtype=wp.float64),
        fixed: wp.array(dtype=int),
        masses: wp.array(dtype=scalar),
        # in
        before: wp.array(dtype=vec3),
        impulses: wp.array(dtype=vec3),
        # out
        scalars: wp.array(dtype=wp.float64),
    ):
        # a fixed node's right-hand side is what holds it, and is no measure of the motion
        total = wp.float64(0.0)
        given = wp.float64(0.0)
        for i in range(impulses.shape[0]):
            if fixed[i] == 0:
                momentum = masses[i] * before[i] + impulses[i]
                total += double_dot(momentum, momentum)
                given += double_dot(impulses[i], impulses[i])
        square = relative_tolerance[0] * relative_tolerance[0]
        scalars[Scalar.WHOLE_SQUARE] = square * total
        scalars[Scalar.CHANGE_SQUARE] = square * given

    @func
    def follow_time_error(
        change_partial: wp.array(dtype=wp.float64), scalars: wp.array(dtype=wp.float64)
    ):
        # the start is off by (v+ - v) - (v - v-), twice what the step is off by; as M~ >= M, the
        # residual bounds the momentum that the solve is off by
        square = share_square * total_of(change_partial)
        scalars[Scalar.TARGET_SQUARE] = wp.max(scalars[Scalar.FLOOR_SQUARE], square)

    @kernel
    def begin(
        # model
        relative_tolerance: wp.array(dtype=wp.float64),
        follows: int,
        nodes: int,
        hasty: int,
        # in
        partial: wp.array(dtype=wp.float64),
        change_partial: wp.array(dtype=wp.float64),
        net_partial: wp.array(dtype=wp.vec3d),
        first: int,
        again: int,
        # out
        scalars: wp.array(dtype=wp.float64),
        counters: wp.array(dtype=int),
    ):
        square = total_of(partial)
        scalars[Scalar.LAST_SQUARE] = square
        scalars[Scalar.RESIDUAL_PRODUCT] = wp.float64(0.0)
        tolerance = relative_tolerance[0]
        change = wp.max(scalars[Scalar.CHANGE_SQUARE], tolerance * tolerance * square)
        scalars[Scalar.CHANGE_SQUARE] = change
        # what contact imposes on a body at rest is momentum too
        whole = tolerance * tolerance * total_of(change_partial)
        scalars[Scalar.WHOLE_SQUARE] = wp.max(scalars[Scalar.WHOLE_SQUARE], whole)
        scalars[Scalar.FLOOR_SQUARE] = wp.min(scalars[Scalar.WHOLE_SQUARE], most_square * change)
        scalars[Scalar.TARGET_SQUARE] = scalars[Scalar.FLOOR_SQUARE]
        if follows != 0:
            follow_time_error(change_partial, scalars)
        stop = scalars[Scalar.TARGET_SQUARE]
        if counters[Counter.LOOSE] != 0:
            loose = loose_square
            if hasty != 0:
                passes = counters[Counter.PASSES]
                if passes < first_passes:
                    loose = first_square
                elif passes < second_passes:
                    loose = second_square
            stop = wp.max(stop, loose * square)
        scalars[Scalar.STOP_SQUARE] = stop
        counters[Counter.ITERATIONS] = 0
        if again != 0:
            counters[Counter.UNCONVERGED] = counters[Counter.UNCONVERGED] - 1
        counters[Counter.FAILED] = 0
        # an extrapolation that is good enough by itself would carry its error on from step to step
        least = stop
        if follows != 0 and first != 0:
            least = wp.float64(0.0)
        go_on = square > least
        if follows != 0 and counters[Counter.LOOSE] == 0:
            go_on = go_on or net_is_left(nodes, change_partial, net_partial, square, scalars)
        counters[Counter.CONDITION] = wp.where(go_on, 1, 0)

    @kernel
    def conclude(
        # model
        max_iterations: int,
        follows: int,
        nodes: int,
        # in
        partial: wp.array(dtype=wp.float64),
        change_partial: wp.array(dtype=wp.float64),
        net_partial: wp.array(dtype=wp.vec3d),
        # out
        scalars: wp.array(dtype=wp.float64),
        counters: wp.array(dtype=int),
    ):
        # written so that a residual that is not a number ends the loop
        square = total_of(partial)
        scalars[Scalar.RESIDUAL_PRODUCT] = scalars[Scalar.NEW_PRODUCT]
        scalars[Scalar.LAST_SQUARE] = square
        counters[Counter.ITERATIONS] = counters[Counter.ITERATIONS] + 1
        counters[Counter.TOTAL_ITERATIONS] = counters[Counter.TOTAL_ITERATIONS] + 1
        if follows != 0:
            follow_time_error(change_partial, scalars)
            loose = wp.where(
                counters[Counter.LOOSE] != 0,
                scalars[Scalar.STOP_SQUARE],
                wp.float64(0.0),
            )
            scalars[Scalar.STOP_SQUARE] = wp.max(scalars[Scalar.TARGET_SQUARE], loose)
        go_on = int(0)
        unfinished = square > scalars[Scalar.STOP_SQUARE]
        if follows != 0 and counters[Counter.LOOSE] == 0:
            left = net_is_left(nodes, change_partial, net_partial, square, scalars)
            unfinished = unfinished or left
        if unfinished:
            # a matrix that rounding has left indefinite ends the iteration
            curved = scalars[Scalar.CURVATURE] > wp.float64(0.0)
            sound = scalars[Scalar.NEW_PRODUCT] > wp.float64(0.0)
            if curved and sound and counters[Counter.ITERATIONS] < max_iterations:
                go_on = 1
            else:
                counters[Counter.UNCONVERGED] = counters[Counter.UNCONVERGED] + 1
                counters[Counter.FAILED] = 1
        counters[Counter.CONDITION] = go_on

    return SimpleNamespace(
        double_dot=double_dot,
        total_of=total_of,
        begin_step=begin_step,
        set_target=set_target,
        begin=begin,
        conclude=conclude,
    )
