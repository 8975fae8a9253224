"""Out of the frames: bodies are taken along the arcs that these describe."""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.flight.spin import make_spin
from warp_softbody.kernels.flight.structs import SUBJECT, make_flight_structs
from warp_softbody.kernels.precision import real
from warp_softbody.kernels.rigid_bodies import make_rigid_bodies
from warp_softbody.kernels.widening import make_widening


@cache
def make_arcs(precision: str) -> SimpleNamespace:
    """Kernel ``leave_frames``."""
    types = real(precision)
    vec3 = types.vec3
    kernel, func = types.kernel(SUBJECT), types.func(SUBJECT)
    structs = make_flight_structs(precision)
    FlightBodies, StepStart, StepEnd = structs.FlightBodies, structs.StepStart, structs.StepEnd
    Spins, Frames = structs.Spins, structs.Frames
    widening = make_widening(precision, SUBJECT)
    wide, narrow = widening.wide, widening.narrow
    inertia_of = make_rigid_bodies(precision, SUBJECT).inertia_of
    spin = make_spin(precision)
    turned, inverse_inertia, spin_of = spin.turned, spin.inverse_inertia, spin.spin_of
    vec3d, mat33d = wp.vec3d, wp.mat33d
    zero, one = wp.constant(wp.float64(0.0)), wp.constant(wp.float64(1.0))

    @func
    def spares_of(
        body: int, bodies: FlightBodies, groups: wp.array(dtype=int), spins: Spins, start: StepStart
    ):
        # the impulse on a body, its part of the group's sum, the group's torque, and its inertia
        center = spins.centers[body]
        own = vec3d()
        own_mass = zero
        push = vec3d()
        mass = zero
        moment = vec3d()
        torque = vec3d()
        size = zero
        for other in range(groups.shape[0]):
            if groups[other] == groups[body]:
                size += wp.trace(spins.inertias[other])
                for i in range(bodies.node_start[other], bodies.node_start[other + 1]):
                    m = wp.float64(bodies.mass[i])
                    pushed = wide(start.pushes[i])
                    mass += m
                    moment += m * (spins.centers[other] - center)
                    push += pushed
                    torque += wp.cross(wide(start.positions[i]) - center, pushed)
                    if other == body:
                        own_mass += m
                        own += pushed
        share = push / mass
        return own, own_mass * share, torque - wp.cross(moment, share), size

    @kernel
    def leave_frames(
        # model
        bodies: FlightBodies,
        # in
        turning: wp.array(dtype=int),
        groups: wp.array(dtype=int),
        shares: wp.array(dtype=wp.float64),
        spins: Spins,
        frames: Frames,
        start: StepStart,
        carried: wp.array(dtype=vec3d),
        # in and out
        before: wp.array(dtype=vec3),
        change: wp.array(dtype=vec3),
        end: StepEnd,
        # out
        carry: wp.array(dtype=vec3d),
    ):
        # one thread a body; the straight path stands at the end already. Sums as in
        # ``rigid_balance``, with damped masses and what rounding left over before
        body = wp.tid()
        if turning[body] == 0:
            return
        first = bodies.node_start[body]
        last = bodies.node_start[body + 1]
        dt = wp.float64(bodies.step_factors[0])
        center = spins.centers[body]
        drift = spins.drifts[body]
        mass = zero
        fall = dt * wide(bodies.gravity[0])
        gain = carried[2 * body]
        straight_gain = vec3d()
        mean = vec3d()
        spin = vec3d()
        moments = mat33d()
        for i in range(first, last):
            m = wp.float64(bodies.mass[i])
            damped = wp.float64(bodies.damped_mass[i])
            arm = wide(start.positions[i]) - center
            own = (wide(before[i]) - drift) + wide(change[i])
            mass += damped
            gain += m * fall + wide(start.outer_impulses[i]) - (damped - m) * drift
            straight_gain += damped * (wide(end.velocities[i]) - drift)
            mean += damped * own
            spin += damped * wp.cross(arm, own)
            moments += inertia_of(arm, damped)
        # impulses inside a group add up to none but for rounding, which all share; as they do not
        # act in quite the same points, they make a torque, which is shared out by inertia
        wanted = spins.momenta[body] + spins.torques[body] + carried[2 * body + 1]
        if start.pushes:
            push, push_of_all, spare, size = spares_of(body, bodies, groups, spins, start)
            gain += push - push_of_all
            wanted -= (wp.trace(spins.inertias[body]) / size) * spare
        gain = gain / mass
        straight_gain = straight_gain / mass
        # what the solve found beside a rigid motion goes along the arc
        mean = mean / mass
        spin = inverse_inertia(moments) * spin
        turn = dt * frames.rates[body]
        shift = center + dt * (drift + gain)
        share = shares[body]
        straight = one - share
        for i in range(first, last):
            arm = wide(start.positions[i]) - center
            own = (wide(before[i]) - drift) + wide(change[i]) - mean - wp.cross(spin, arm)
            arc = shift + turned(turn, arm + dt * own)
            own = share * turned(turn, own)
            if straight > zero:
                # a group's turn may have moved the body's centre
                aside = dt * (gain - straight_gain)
                arc = share * arc + straight * (wide(end.positions[i]) + aside)
                own += straight * (wide(end.velocities[i]) - drift - straight_gain)
            end.positions[i] = narrow(arc)
            change[i] = narrow(own)
        # about the places as they are rounded
        middle, mean, momentum, moments = spin_of(
            first, last, bodies.damped_mass, end.positions, change
        )
        rate = inverse_inertia(moments) * (wanted - momentum)
        missing = vec3d()
        # what keeps the inertia from being singular is not to take from it
        lacking = wanted - momentum - moments * rate
        for i in range(first, last):
            arm = wide(end.positions[i]) - middle
            ideal = drift + gain + (wide(change[i]) - mean) + wp.cross(rate, arm)
            old = start.velocities[i]
            new = narrow(ideal - wide(old))
            after = old + new
            before[i] = old
            change[i] = new
            end.velocities[i] = after
            end.increments[i] = new
            impulse = wp.float64(bodies.damped_mass[i]) * (ideal - wide(after))
            missing += impulse
            lacking += wp.cross(arm, impulse)
        carry[2 * body] = missing
        carry[2 * body + 1] = lacking

    return SimpleNamespace(leave_frames=leave_frames)
