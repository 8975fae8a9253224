"""How a body spins: its momenta and inertia, and the rate of a step's turn.

All of it is in double precision, whatever the run's.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.flight.structs import SUBJECT
from warp_softbody.kernels.precision import real
from warp_softbody.kernels.rigid_bodies import make_rigid_bodies
from warp_softbody.kernels.widening import make_widening

AXIS_STAGES, AXIS_ITERATIONS = 4, 5
"""Of Newton's method for the axis: parts of the step that it is led through, iterations of each."""

MOST_ANGLE = 2.0
"""Turn of a step, rad, up to which its angle is exact."""


@cache
def make_spin(precision: str) -> SimpleNamespace:
    """Functions ``turned``, ``inverse_inertia``, ``rate_of_step`` and ``spin_of``."""
    types = real(precision)
    scalar, vec3 = types.scalar, types.vec3
    func = types.func(SUBJECT)
    wide = make_widening(precision, SUBJECT).wide
    inertia_of = make_rigid_bodies(precision, SUBJECT).inertia_of
    axis_stages, axis_iterations = wp.constant(AXIS_STAGES), wp.constant(AXIS_ITERATIONS)
    most_angle = wp.constant(wp.float64(MOST_ANGLE))
    vec3d, mat33d = wp.vec3d, wp.mat33d
    zero, half, one, two = (wp.constant(wp.float64(x)) for x in (0.0, 0.5, 1.0, 2.0))
    least_inertia = wp.constant(wp.float64(1e-12))

    @func
    def turned(rate: vec3d, v: vec3d):
        # exp(rate x) v (Rodrigues)
        angle = wp.length(rate)
        if angle == zero:
            return v
        n = rate / angle
        across = wp.cross(n, v)
        return v + wp.sin(angle) * across + (one - wp.cos(angle)) * wp.cross(n, across)

    @func
    def inverse_inertia(moments: mat33d):
        # a body of one line of nodes has no inertia about it
        size = wp.trace(moments)
        if not size > zero:
            return mat33d()
        return wp.inverse(moments + (least_inertia * size) * wp.identity(n=3, dtype=wp.float64))

    @func
    def rate_of_step(inverse: mat33d, momentum: vec3d, dt: wp.float64):
        # seen from the body, its angular momentum L turns by L' = L x w, w = I^-1 L. The midpoint
        # rule keeps the length of L and the energy L . w / 2, whatever the step: M, the mean of L
        # at both ends, obeys M - (dt / 2) M x I^-1 M = L. Its turn about I^-1 M is by
        # 2 atan(w dt / 2); with a dt that is lengthened it is by w dt, and keeps the same
        rate = inverse * momentum
        angle = wp.min(dt * wp.length(rate), most_angle)
        if angle == zero:
            return rate
        step = dt * wp.tan(half * angle) / (half * angle)
        identity = wp.identity(n=3, dtype=wp.float64)
        mean = momentum
        miss = momentum
        # Newton's method for a step that grows, as a slender body may wobble many times a step
        # counts that Warp does not know: written out, these loops take half a second to compile
        stages, iterations = int(axis_stages), int(axis_iterations)
        for stage in range(stages):
            part = half * step * wp.float64(stage + 1) / wp.float64(axis_stages)
            for _k in range(iterations):
                rate = inverse * mean
                miss = mean - part * wp.cross(mean, rate) - momentum
                slope = identity - part * (wp.skew(mean) * inverse - wp.skew(rate))
                mean -= wp.inverse(slope) * miss
        rate = inverse * mean
        miss = mean - half * step * wp.cross(mean, rate) - momentum
        if not wp.length(miss) < wp.float64(1e-6) * wp.length(momentum):
            # without the wobble: about its own axis L stays, and so does the energy
            along = wp.normalize(momentum)
            return wp.dot(along, inverse * momentum) * along
        speed = wp.length(rate)
        return (two * wp.atan(half * step * speed) / (dt * speed)) * rate

    @func
    def spin_of(
        first: int,
        last: int,
        masses: wp.array(dtype=scalar),
        positions: wp.array(dtype=vec3),
        velocities: wp.array(dtype=vec3),
    ):
        # of a body, with sums about a point of it that moves with it, where they lose no digits:
        # center, its velocity, angular momentum and inertia about it
        pivot = wide(positions[first])
        carrier = wide(velocities[first])
        mass = zero
        center = vec3d()
        drift = vec3d()
        momentum = vec3d()
        moments = mat33d()
        for i in range(first, last):
            m = wp.float64(masses[i])
            arm = wide(positions[i]) - pivot
            velocity = wide(velocities[i]) - carrier
            mass += m
            center += m * arm
            drift += m * velocity
            momentum += m * wp.cross(arm, velocity)
            moments += inertia_of(arm, m)
        center = center / mass
        drift = drift / mass
        momentum -= mass * wp.cross(center, drift)
        moments -= inertia_of(center, mass)
        return pivot + center, carrier + drift, momentum, moments

    return SimpleNamespace(
        turned=turned,
        inverse_inertia=inverse_inertia,
        rate_of_step=rate_of_step,
        spin_of=spin_of,
    )
