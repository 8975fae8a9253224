"""Into the frames that turn with bodies: their rates, and velocities and loads in them."""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.flight.spin import make_spin
from warp_softbody.kernels.flight.structs import SUBJECT, make_flight_structs
from warp_softbody.kernels.linear.codes import VelocityConstraint
from warp_softbody.kernels.precision import real
from warp_softbody.kernels.rigid_bodies import make_rigid_bodies
from warp_softbody.kernels.widening import make_widening


@cache
def make_frames(precision: str) -> SimpleNamespace:
    """Kernels of the solve in the frames, in the order of their launch."""
    types = real(precision)
    scalar, vec3 = types.scalar, types.vec3
    kernel = types.kernel(SUBJECT)
    structs = make_flight_structs(precision)
    FlightBodies, StepStart = structs.FlightBodies, structs.StepStart
    Spins, Frames = structs.Spins, structs.Frames
    widening = make_widening(precision, SUBJECT)
    wide, narrow = widening.wide, widening.narrow
    body_of = make_rigid_bodies(precision, SUBJECT).body_of
    spin = make_spin(precision)
    turned, inverse_inertia, rate_of_step = spin.turned, spin.inverse_inertia, spin.rate_of_step
    vec3d = wp.vec3d
    one, two = wp.constant(wp.float64(1.0)), wp.constant(wp.float64(2.0))

    @kernel
    def find_frames(
        # model
        bodies: FlightBodies,
        # in
        turning: wp.array(dtype=int),
        spins: Spins,
        start: StepStart,
        # out
        frames: Frames,
    ):
        # one thread a body; the rate is that of the step's end, as in x+ = x + dt v+
        body = wp.tid()
        if turning[body] == 0:
            return
        dt = wp.float64(bodies.step_factors[0])
        moments = spins.inertias[body]
        inverse = inverse_inertia(moments)
        rate = rate_of_step(inverse, spins.momenta[body] + spins.torques[body], dt)
        spin = inverse * spins.momenta[body]
        center = spins.centers[body]
        drift = spins.drifts[body]
        # the rigid turn that Coriolis' turn makes of what has none
        spare = vec3d()
        for i in range(bodies.node_start[body], bodies.node_start[body + 1]):
            arm = wide(start.positions[i]) - center
            own = wide(start.velocities[i]) - drift - wp.cross(spin, arm)
            spare += wp.float64(bodies.mass[i]) * wp.cross(arm, turned(two * -dt * rate, own))
        frames.rates[body] = rate
        frames.spins[body] = spin
        frames.spares[body] = inverse * spare
        frames.eulers[body] = dt * (inverse * wp.cross(rate, moments * rate))
        # what the impulses that the step is given would turn is in the rate already
        frames.answers[body] = -(inverse * spins.torques[body])

    @kernel
    def enter_frames(
        # model
        bodies: FlightBodies,
        # in
        turning: wp.array(dtype=int),
        spins: Spins,
        frames: Frames,
        start: StepStart,
        # out
        constraints: wp.array(dtype=int),
        before: wp.array(dtype=vec3),
        first_change: wp.array(dtype=vec3),
        change: wp.array(dtype=vec3),
        loads: wp.array(dtype=vec3),
    ):
        # nodes of all other bodies keep what the step gave them
        i = wp.tid()
        body = body_of(i, bodies.node_start)
        loads[i] = vec3()
        if turning[body] == 0:
            constraints[i] = VelocityConstraint.FIXED
            return
        dt = wp.float64(bodies.step_factors[0])
        rate = frames.rates[body]
        drift = spins.drifts[body]
        arm = wide(start.positions[i]) - spins.centers[body]
        own = wide(start.velocities[i]) - drift - wp.cross(frames.spins[body], arm)
        own = turned(two * -dt * rate, own) - wp.cross(frames.spares[body], arm)
        # the load is that of the step's beginning; where a body without stiffness would fly apart
        # within the step it is weakened, so that it cannot give more energy than the turn loses
        square = dt * dt * wp.length_sq(rate)
        strength = one / (one + square * square)
        load = (-strength * dt) * wp.cross(rate, wp.cross(rate, arm))
        load += wp.cross(strength * frames.eulers[body] + frames.answers[body], arm)
        constraints[i] = VelocityConstraint.NONE
        before[i] = narrow(drift + own)
        first_change[i] = vec3()
        change[i] = vec3()
        loads[i] = narrow(wp.float64(bodies.mass[i]) * load)
        if start.pushes:
            loads[i] = loads[i] + start.pushes[i]

    @kernel
    def add_loads(
        # in
        right: wp.array(dtype=vec3),
        loads: wp.array(dtype=vec3),
        # out
        loaded: wp.array(dtype=vec3),
    ):
        i = wp.tid()
        loaded[i] = right[i] + loads[i]

    @types.kernel(SUBJECT, "place")
    def place(
        # model
        step_factors: wp.array(dtype=scalar),
        # in
        positions: wp.array(dtype=vec3),
        before: wp.array(dtype=vec3),
        change: wp.array(dtype=vec3),
        # out
        placed: wp.array(dtype=vec3),
    ):
        # in the frame, but for a common shift: where a Newton iteration takes its forces
        i = wp.tid()
        placed[i] = positions[i] + step_factors[0] * (before[i] + change[i])

    return SimpleNamespace(
        find_frames=find_frames,
        enter_frames=enter_frames,
        add_loads=add_loads,
        place=place,
    )
