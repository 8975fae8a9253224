"""Which bodies are in flight: who pushes whom, how fast each spins, and which take an arc."""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.flight.spin import make_spin
from warp_softbody.kernels.flight.structs import SUBJECT, make_flight_structs
from warp_softbody.kernels.linear.codes import Counter, VelocityConstraint
from warp_softbody.kernels.precision import real
from warp_softbody.kernels.rigid_bodies import make_rigid_bodies
from warp_softbody.kernels.widening import make_widening

LEAST_SWELLING = 1e-3
"""Strain w^2 (dt lambda + dt^2) / 2 of a straight path up to which it is taken: a thousandth is
less than the other errors of a step, and slow turns cost no second solve."""

FULL_SWELLING = 2e-3
"""The same from which the arc alone is taken; in between lies a blend of both."""

PLANNED_SHARE = 0.05
"""Share of its swelling that counts in a step that a controller has planned: the plan's linear maps
are those of the straight path, which is kept until it is off by more than two hundredths."""


@cache
def make_flight_groups(precision: str) -> SimpleNamespace:
    """Kernels that choose the bodies of a turning step, in the order of their launch."""
    types = real(precision)
    scalar, vec3, vec4 = types.scalar, types.vec3, types.vec4
    # every step asks which bodies turn, few steps have one that does
    kernel = types.kernel(SUBJECT, "choice")
    structs = make_flight_structs(precision)
    FlightBodies, StepStart, Spins = structs.FlightBodies, structs.StepStart, structs.Spins
    wide = make_widening(precision, SUBJECT).wide
    bodies_of = make_rigid_bodies(precision, SUBJECT)
    body_of, merge_groups = bodies_of.body_of, bodies_of.merge_groups
    spins_of = make_spin(precision)
    inverse_inertia, spin_of = spins_of.inverse_inertia, spins_of.spin_of
    vec3d = wp.vec3d
    zero, half, one = (wp.constant(wp.float64(x)) for x in (0.0, 0.5, 1.0))
    least_swelling = wp.constant(wp.float64(LEAST_SWELLING))
    swelling_span = wp.constant(wp.float64(FULL_SWELLING - LEAST_SWELLING))

    @types.kernel(SUBJECT, "pairs")
    def join_pushed(
        # model
        body_start: wp.array(dtype=int),
        # in
        found: wp.array(dtype=int),
        found_count: wp.array(dtype=int),
        nodes: wp.array(dtype=wp.vec4i),
        impulses: wp.array(dtype=vec3),
        balanced: wp.array(dtype=int),
        # out
        groups: wp.array(dtype=int),
    ):
        # in one thread: bodies that push each other, or were balanced as one, under the number of
        # the first of them
        for body in range(groups.shape[0]):
            groups[body] = balanced[body]
        for number in range(found_count[0]):
            c = found[number]
            if wp.length_sq(impulses[c]) > scalar(0.0):
                group = groups[body_of(nodes[c][0], body_start)]
                merge_groups(group, groups[body_of(nodes[c][2], body_start)], groups)

    @types.kernel(SUBJECT, "pairs")
    def spread_impulses(
        # model
        body_start: wp.array(dtype=int),
        # in
        found: wp.array(dtype=int),
        found_count: wp.array(dtype=int),
        nodes: wp.array(dtype=wp.vec4i),
        weights: wp.array(dtype=vec4),
        impulses: wp.array(dtype=vec3),
        # out
        pushes: wp.array(dtype=vec3),
    ):
        # one thread a body: what each of its nodes bears of the pairs
        body = wp.tid()
        first = body_start[body]
        last = body_start[body + 1]
        for i in range(first, last):
            pushes[i] = vec3()
        for number in range(found_count[0]):
            c = found[number]
            for a in range(4):
                i = nodes[c][a]
                if i >= first and i < last:
                    pushes[i] = pushes[i] + weights[c][a] * impulses[c]

    @kernel
    def find_spins(
        # model
        bodies: FlightBodies,
        stiffness_factors: wp.array(dtype=wp.float64),
        # in
        counted: wp.array(dtype=wp.float64),
        constraints: wp.array(dtype=int),
        start: StepStart,
        # out
        loose_bodies: wp.array(dtype=int),
        shares: wp.array(dtype=wp.float64),
        spins: Spins,
    ):
        # one thread a body: whether neither ground nor a fixed node holds it, and the share that
        # the arc is to have in its step
        body = wp.tid()
        shares[body] = zero
        loose_bodies[body] = 0
        first = bodies.node_start[body]
        last = bodies.node_start[body + 1]
        for i in range(first, last):
            if constraints[i] != VelocityConstraint.NONE:
                return
        center, drift, momentum, moments = spin_of(
            first, last, bodies.mass, start.positions, start.velocities
        )
        torque = vec3d()
        for i in range(first, last):
            push = wide(start.outer_impulses[i])
            if start.pushes:
                push += wide(start.pushes[i])
            torque += wp.cross(wide(start.positions[i]) - center, push)
        rate = inverse_inertia(moments) * (momentum + torque)
        swelling = counted[0] * half * stiffness_factors[body] * wp.length_sq(rate)
        s = wp.clamp((swelling - least_swelling) / swelling_span, zero, one)
        loose_bodies[body] = 1
        shares[body] = s * s * (wp.float64(3.0) - wp.float64(2.0) * s)
        spins.centers[body] = center
        spins.drifts[body] = drift
        spins.momenta[body] = momentum
        spins.torques[body] = torque
        spins.inertias[body] = moments

    @kernel
    def choose_bodies(
        # in
        groups: wp.array(dtype=int),
        loose_bodies: wp.array(dtype=int),
        shares: wp.array(dtype=wp.float64),
        # out
        turning: wp.array(dtype=int),
        any_turning: wp.array(dtype=int),
        counters: wp.array(dtype=int),
    ):
        # in one thread: the groups that nothing from outside holds, and of which one body turns
        count = groups.shape[0]
        any_turning[0] = 0
        for body in range(count):
            turning[body] = 0
            if shares[body] > zero:
                turning[body] = 1
                any_turning[0] = 1
        if any_turning[0] == 0:
            return
        # a last solve, and no search for modes
        counters[Counter.LOOSE] = 0
        for body in range(count):
            for other in range(count):
                if groups[other] == groups[body] and shares[other] > zero:
                    turning[body] = 1
        for body in range(count):
            if groups[body] < 0:
                # an edge of the ground holds it
                turning[body] = 0
            for other in range(count):
                if groups[other] == groups[body] and loose_bodies[other] == 0:
                    turning[body] = 0

    return SimpleNamespace(
        join_pushed=join_pushed,
        spread_impulses=spread_impulses,
        find_spins=find_spins,
        choose_bodies=choose_bodies,
    )
