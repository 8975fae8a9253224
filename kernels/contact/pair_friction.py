"""Coulomb's law of a pair on the smooth cone, with scales of its own.

The constitutive friction of a sliding pair is -g u_t / |u_t|, with its relative velocity u and the
bound g = mu f_n of the last pass; it is linearised as in ``friction_smooth.py``. Which speed counts
as none is taken from the pair itself: the one with which its own block of the matrix answers a
thousandth of the bound. So stiff and soft, large and small bodies are treated alike, with and
without gravity.

A pair that friction holds at its full bound goes on sliding, however slowly, until friction would
reverse it. Were it stopped where the bound of this pass exceeds that of the last by a little, or
where it is slow, it would be held beyond its cone in the next pass and begin again: for ever.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.contact.modes import (
    BEYOND,
    LAST_PASSES,
    LATE_EXCESS,
    MISSED,
    SHRUNK,
    SLOW,
    Mode,
)
from warp_softbody.kernels.contact.smooth_cone import make_smooth_cone
from warp_softbody.kernels.precision import real


@cache
def make_pair_friction(precision: str, subject: str) -> SimpleNamespace:
    """Functions ``disc_violation`` and ``choose`` for the kernels of pairs."""
    types = real(precision)
    scalar, vec3, mat33 = types.scalar, types.vec3, types.mat33
    func = types.func(subject)
    last_passes = wp.constant(LAST_PASSES)
    slow_share, missed = wp.constant(scalar(SLOW)), wp.constant(scalar(MISSED))
    beyond = wp.constant(scalar(BEYOND))
    shrunk, late_excess = wp.constant(scalar(SHRUNK)), wp.constant(scalar(LATE_EXCESS))
    tiny = wp.constant(scalar(types.tiny))
    cone = make_smooth_cone(precision, subject)
    linearised_friction = cone.linearised_friction

    @func
    def choose(
        mode: int,
        n: vec3,
        friction: vec3,
        sliding: vec3,
        last: vec3,
        pushed: bool,
        bound: scalar,
        weight: scalar,
        left: scalar,
        passes: int,
    ):
        # next mode, whether the law is missed, force, stiffness, velocity they are made at.
        # pushed: whether the friction of the last pass was a force of full size
        next_mode = Mode.STICK
        unsettled = int(0)
        force = vec3()
        stiffness = mat33()
        made_at = last
        trial = friction - weight * sliding
        size = wp.length(trial)
        speed = wp.length(sliding)
        slowest = slow_share * bound / weight + tiny
        excess = beyond * bound + left
        if passes >= last_passes:
            excess += late_excess * bound
        slips = size > bound + excess
        if mode == Mode.SLIDE:
            turned = wp.dot(last, sliding) < scalar(0.0)
            stopped = speed < slowest or size < shrunk * bound
            slips = not turned and (pushed or not stopped)
        if bound <= left:
            # nothing holds it
            slips = mode == Mode.SLIDE or size > bound + excess
            bound = scalar(0.0)
        if slips:
            next_mode = Mode.SLIDE
            if mode == Mode.STICK:
                # the full friction against where it is driven; its speed is not known yet
                force = (bound / wp.max(size, tiny)) * trial
                made_at = (scalar(-1.0) / weight) * trial
            elif bound > scalar(0.0):
                law = friction + (bound / wp.max(speed, slowest)) * sliding
                if wp.length(law) > missed * bound + left:
                    unsettled = 1
                force, stiffness = linearised_friction(n, bound, sliding, last, slowest, True)
                made_at = sliding
        return next_mode, unsettled, force, stiffness, made_at

    return SimpleNamespace(disc_violation=cone.disc_violation, choose=choose)
