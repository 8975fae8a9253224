"""Coulomb's law on the smooth cone, for nodes on the ground.

The constitutive friction of a sliding node is -g v_t / |v_t|, with the bound g = mu f_n of the last
pass. It enters the linear system as a force and a symmetric stiffness, linearised at the velocity
of the last pass: by Newton's method (force -g d, stiffness g / |v_t| across the direction d) where
that velocity has nearly settled, else by Picard's (stiffness g / |v_t| in every tangential
direction), which is a descent method for a given g and cannot reverse the sliding.
"""

from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.contact.modes import (
    BEYOND,
    LATE_EXCESS,
    LATE_PASSES,
    MISSED,
    NEWTON_PASSES,
    Mode,
)
from warp_softbody.kernels.contact.smooth_cone import make_smooth_cone
from warp_softbody.kernels.contact.structs import make_contact_structs
from warp_softbody.kernels.linear.codes import VelocityConstraint
from warp_softbody.kernels.precision import real


def make_smooth_law(precision: str, subject: str) -> SimpleNamespace:
    """Functions ``constraint_of``, ``coulomb_violation``, ``choose``; ``inner_radius``.

    Every law of friction has them. ``inner_radius`` is the radius of the largest disc within the
    cone, in parts of the bound.
    """
    types = real(precision)
    scalar, vec3, mat33 = types.scalar, types.vec3, types.mat33
    func = types.func(subject)
    Tolerances = make_contact_structs(precision).Tolerances
    newton_passes, late_passes = wp.constant(NEWTON_PASSES), wp.constant(LATE_PASSES)
    beyond, missed = wp.constant(scalar(BEYOND)), wp.constant(scalar(MISSED))
    late_excess = wp.constant(scalar(LATE_EXCESS))
    cone = make_smooth_cone(precision, subject)
    disc_violation, linearised_friction = cone.disc_violation, cone.linearised_friction

    @func
    def constraint_of(mode: int, n: vec3):
        # the velocity constraint of a sliding node, and the axis that goes with it
        return VelocityConstraint.PLANE, n

    @func
    def coulomb_violation(n: vec3, friction: vec3, trial: vec3, bound: scalar):
        # every direction across the normal is alike
        return disc_violation(friction, trial, bound)

    @func
    def choose(
        mode: int,
        n: vec3,
        friction: vec3,
        sliding: vec3,
        last: vec3,
        bound: scalar,
        weight: scalar,
        left: scalar,
        passes: int,
        tolerances: Tolerances,
    ):
        # next mode, whether the law is missed, force, stiffness, velocity they are made at
        next_mode = Mode.STICK
        unsettled = int(0)
        force = vec3()
        stiffness = mat33()
        made_at = last
        trial = friction - weight * sliding
        size = wp.length(trial)
        # to begin, it must exceed the cone by what would move its own block noticeably
        margin = wp.min(weight * tolerances.sliding_speed, beyond * bound)
        slips = size > bound + margin + tolerances.impulse
        if mode == Mode.SLIDE:
            slips = size > bound and wp.length(sliding) > tolerances.sliding_speed
            # friction that would reverse the sliding stops it instead
            slips = slips and wp.dot(last, sliding) >= scalar(0.0)
        if mode == Mode.STICK and passes >= newton_passes:
            # late in a step only what the law does not allow by far begins
            slips = size > (scalar(1.0) + late_excess) * bound + margin + tolerances.impulse
        if slips:
            next_mode = Mode.SLIDE
            if mode == Mode.STICK:
                # the full friction against where it is driven; its speed is not known yet
                force = (bound / size) * trial
                made_at = (scalar(-1.0) / weight) * trial
            else:
                direction = sliding / wp.max(wp.length(sliding), tolerances.sliding_speed)
                law = friction + bound * direction
                if wp.length(law) > missed * bound + tolerances.impulse + left:
                    unsettled = 1
                newton = passes < newton_passes or passes >= late_passes
                force, stiffness = linearised_friction(
                    n, bound, sliding, last, tolerances.sliding_speed, newton
                )
                made_at = sliding
        return next_mode, unsettled, force, stiffness, made_at

    return SimpleNamespace(
        constraint_of=constraint_of,
        coulomb_violation=coulomb_violation,
        choose=choose,
        inner_radius=1.0,
    )
