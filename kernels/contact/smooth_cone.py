"""The smooth cone of friction, for nodes on the ground and for pairs alike.

The projection onto its disc measures how far Coulomb's law is missed; the linearisation makes the
law part of a linear system.
"""

from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.contact.modes import SETTLED
from warp_softbody.kernels.precision import real


def make_smooth_cone(precision: str, subject: str) -> SimpleNamespace:
    """Functions ``disc_violation`` and ``linearised_friction`` for the kernels of a subject."""
    types = real(precision)
    scalar, vec3 = types.scalar, types.vec3
    func = types.func(subject)
    nearly = wp.constant(scalar(SETTLED))

    @func
    def disc_violation(friction: vec3, trial: vec3, bound: scalar):
        # distance of the friction from the projection of the trial onto the disc of the bound
        size = wp.length(trial)
        nearest = trial
        if size > bound:
            nearest = (bound / size) * trial
        return wp.length(friction - nearest)

    @func
    def linearised_friction(
        n: vec3, bound: scalar, sliding: vec3, last: vec3, slowest: scalar, newton: bool
    ):
        # -bound v / |v|: by Newton's method where v has nearly settled, else by Picard's
        speed = wp.max(wp.length(sliding), slowest)
        direction = sliding / speed
        force = vec3()
        stiffness = (bound / speed) * (wp.identity(n=3, dtype=scalar) - wp.outer(n, n))
        settled = wp.dot(last, direction) > nearly * wp.max(wp.length(last), speed)
        if settled and newton:
            force = -bound * direction
            stiffness -= (bound / speed) * wp.outer(direction, direction)
        return force, stiffness

    return SimpleNamespace(disc_violation=disc_violation, linearised_friction=linearised_friction)
