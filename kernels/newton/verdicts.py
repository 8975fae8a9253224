"""Verdicts on iterates of Newton's method: accepted, to be halved, or refused for good."""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.linear.stopping import make_stopping
from warp_softbody.kernels.newton.codes import (
    MOST_HALVINGS,
    MOST_OF_DRIFT,
    SUFFICIENT,
    NewtonCount,
    NewtonScalar,
)
from warp_softbody.kernels.precision import real

SUBJECT = "newton_verdicts"


@cache
def make_newton_verdicts(precision: str) -> SimpleNamespace:
    """Kernels of one thread, in the order in which a step needs them."""
    types = real(precision)
    kernel = types.kernel(SUBJECT)
    total_of = make_stopping(precision).total_of
    most_halvings = wp.constant(MOST_HALVINGS)
    most_of_drift = wp.constant(wp.float64(MOST_OF_DRIFT))
    sufficient = wp.constant(wp.float64(SUFFICIENT))

    @kernel
    def note_left(
        # in
        merits: wp.array(dtype=wp.float64),
        # out
        scalars: wp.array(dtype=wp.float64),
    ):
        scalars[NewtonScalar.LEFT] = wp.sqrt(total_of(merits))

    @kernel
    def begin(
        # in
        merits: wp.array(dtype=wp.float64),
        # out
        scalars: wp.array(dtype=wp.float64),
        counters: wp.array(dtype=int),
    ):
        # the first iterate may overshoot, as where a body turns by much, if others make it good
        most = most_of_drift * scalars[NewtonScalar.DRIFT]
        scalars[NewtonScalar.BASE] = wp.min(wp.sqrt(total_of(merits)), most)
        scalars[NewtonScalar.ACCEPTED] = wp.float64(wp.inf)
        counters[NewtonCount.GO_ON] = 1
        counters[NewtonCount.STALLED] = 0
        counters[NewtonCount.ITERATION] = 0
        counters[NewtonCount.HALVED] = 0

    @kernel
    def judge(
        # in
        merits: wp.array(dtype=wp.float64),
        roundings: wp.array(dtype=wp.float64),
        # out
        scalars: wp.array(dtype=wp.float64),
        counters: wp.array(dtype=int),
        accepted: wp.array(dtype=wp.float64),
    ):
        # written so that a merit that is not a number is refused
        merit = total_of(merits)
        halved = counters[NewtonCount.HALVED]
        share = wp.pow(wp.float64(0.5), wp.float64(halved))
        most = (wp.float64(1.0) - sufficient * share) * scalars[NewtonScalar.ACCEPTED]
        most = wp.max(most, wp.sqrt(total_of(roundings)))
        # a solve that has failed is no excuse
        most += wp.min(scalars[NewtonScalar.LEFT], most)
        counters[NewtonCount.HALVE] = 0
        if wp.sqrt(merit) <= most:
            scalars[NewtonScalar.ACCEPTED] = wp.sqrt(merit)
            k = counters[NewtonCount.ITERATION]
            counters[NewtonCount.ITERATION] = k + 1
            counters[NewtonCount.HALVED] = 0
            while k < accepted.shape[0]:
                accepted[k] = merit
                k += 1
        elif halved < most_halvings:
            counters[NewtonCount.HALVE] = 1
            counters[NewtonCount.HALVED] = halved + 1
            counters[NewtonCount.ALL_HALVINGS] = counters[NewtonCount.ALL_HALVINGS] + 1
        else:
            # the same equations would give the same step again
            counters[NewtonCount.GO_ON] = 0
            counters[NewtonCount.STALLED] = 1
            counters[NewtonCount.ALL_STALLS] = counters[NewtonCount.ALL_STALLS] + 1

    @kernel
    def conclude(
        # in
        roundings: wp.array(dtype=wp.float64),
        scalars: wp.array(dtype=wp.float64),
        # out
        counters: wp.array(dtype=int),
    ):
        most = wp.max(scalars[NewtonScalar.BASE], wp.sqrt(total_of(roundings)))
        counters[NewtonCount.DIVERGED] = 1
        if scalars[NewtonScalar.ACCEPTED] <= most + wp.min(scalars[NewtonScalar.LEFT], most):
            counters[NewtonCount.DIVERGED] = 0
        else:
            # what failed is tried again
            stalled = counters[NewtonCount.STALLED]
            counters[NewtonCount.ALL_STALLS] = counters[NewtonCount.ALL_STALLS] - stalled

    @kernel
    def begin_again(
        # in
        merits: wp.array(dtype=wp.float64),
        # out
        scalars: wp.array(dtype=wp.float64),
        counters: wp.array(dtype=int),
    ):
        # the true equations may leave more of the base than the linear ones
        base = wp.max(scalars[NewtonScalar.BASE], wp.sqrt(total_of(merits)))
        most = most_of_drift * scalars[NewtonScalar.DRIFT]
        counters[NewtonCount.DRIFTS] = 1
        if base <= most:
            counters[NewtonCount.DRIFTS] = 0
            most = base
        scalars[NewtonScalar.ACCEPTED] = most
        counters[NewtonCount.GO_ON] = 1
        counters[NewtonCount.STALLED] = 0
        counters[NewtonCount.ITERATION] = 0
        counters[NewtonCount.HALVE] = 1
        counters[NewtonCount.HALVED] = 1
        counters[NewtonCount.ALL_HALVINGS] = counters[NewtonCount.ALL_HALVINGS] + 1

    @kernel
    def resume(
        # in
        merits: wp.array(dtype=wp.float64),
        # out
        scalars: wp.array(dtype=wp.float64),
        counters: wp.array(dtype=int),
        accepted: wp.array(dtype=wp.float64),
    ):
        # the first equations are those of the step's start; about its base they are other ones
        merit = total_of(merits)
        scalars[NewtonScalar.ACCEPTED] = wp.sqrt(merit)
        counters[NewtonCount.GO_ON] = 1
        counters[NewtonCount.STALLED] = 0
        counters[NewtonCount.ITERATION] = 1
        counters[NewtonCount.HALVED] = 0
        counters[NewtonCount.ALL_STALLS] = counters[NewtonCount.ALL_STALLS] - 1
        for k in range(accepted.shape[0]):
            accepted[k] = merit

    return SimpleNamespace(
        note_left=note_left,
        begin=begin,
        judge=judge,
        conclude=conclude,
        begin_again=begin_again,
        resume=resume,
    )
