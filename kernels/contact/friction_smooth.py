"""Coulomb's law with the smooth cone.

A sliding node's friction -g v_t / |v_t|, g = mu f_n from the last pass, enters as force and
symmetric stiffness linearised at the last pass's velocity: by Newton's method (force -g d,
stiffness g / |v_t| across d) where that velocity has nearly settled, else by Picard (stiffness
g / |v_t| in every tangential direction), which is a descent method for given g and cannot reverse
the sliding.
"""

from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.contact.modes import LATE_PASSES, NEWTON_PASSES, Mode
from warp_softbody.kernels.contact.smooth_cone import make_smooth_cone
from warp_softbody.kernels.contact.structs import make_contact_structs
from warp_softbody.kernels.linear.codes import VelocityConstraint
from warp_softbody.kernels.precision import real


def make_smooth_law(precision: str, subject: str) -> SimpleNamespace:
    """Functions ``freedom_of``, ``coulomb_violation``, ``choose``; the cone's ``inner_radius``."""
    types = real(precision)
    scalar, vec3, mat33 = types.scalar, types.vec3, types.mat33
    func = types.func(subject)
    Tolerances = make_contact_structs(precision).Tolerances
    newton_passes, late_passes = wp.constant(NEWTON_PASSES), wp.constant(LATE_PASSES)
    cone = make_smooth_cone(precision, subject)
    disc_violation, linearised_friction = cone.disc_violation, cone.linearised_friction

    @func
    def freedom_of(mode: int, n: vec3):
        # kind of a sliding node, and the axis that goes with it
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
        margin = wp.min(weight * tolerances.sliding_speed, scalar(0.01) * bound)
        slips = size > bound + margin + tolerances.impulse
        if mode == Mode.SLIDE:
            slips = size > bound and wp.length(sliding) > tolerances.sliding_speed
            # friction that would reverse the sliding stops it instead
            slips = slips and wp.dot(last, sliding) >= scalar(0.0)
        if mode == Mode.STICK and passes >= newton_passes:
            # late in a step only what the law does not allow by far begins
            slips = size > scalar(1.5) * bound + margin + tolerances.impulse
        if slips:
            next_mode = Mode.SLIDE
            if mode == Mode.STICK:
                # the full friction against where it is driven; its speed is not known yet
                force = (bound / size) * trial
                made_at = (scalar(-1.0) / weight) * trial
            else:
                direction = sliding / wp.max(wp.length(sliding), tolerances.sliding_speed)
                law = friction + bound * direction
                if wp.length(law) > tolerances.friction_share * bound + tolerances.impulse + left:
                    unsettled = 1
                newton = passes < newton_passes or passes >= late_passes
                force, stiffness = linearised_friction(
                    n, bound, sliding, last, tolerances.sliding_speed, newton
                )
                made_at = sliding
        return next_mode, unsettled, force, stiffness, made_at

    return SimpleNamespace(
        freedom_of=freedom_of,
        coulomb_violation=coulomb_violation,
        choose=choose,
        inner_radius=1.0,
    )
