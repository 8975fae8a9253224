"""A step of a body in flight in a frame that turns with it (docs/method.md section 1).

With c the centre of mass, r = x - c and w the rate of the frame, velocities are
``v = v_c + w x r + u``. In the frame the nodes bear, beside the elastic forces, the centrifugal
load -m w x (w x r) and Euler's -m a x r with I a = -w x I w, together without a torque, and the
Coriolis force, which turns u by -2 w dt and keeps its length. The solve finds u+, and the body is
taken along the arc that the frame describes::

    x+ = c+ + R (r + dt u+)      v+ = v_c+ + W x (x+ - c+) + R u+      R = exp(dt w)

W is the rate that gives the body its angular momentum at x+, so that this is kept to rounding. The
axis of w is that of I^-1 (L + R^T L), L seen from the body at both ends of the step: a turn about
it changes nothing of L . I^-1 L, so that a body that tumbles gains no energy, however far it turns
(the midpoint rule of Euler's equations).
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.linear.codes import Counter, VelocityConstraint
from warp_softbody.kernels.precision import real
from warp_softbody.kernels.widening import make_widening

SUBJECT = "turning"

LEAST_SWELLING = 1e-3
"""Strain w^2 (dt lambda + dt^2) / 2 of a straight path up to which it is taken: a thousandth is
less than the other errors of a step, and slow turns cost no second solve."""

FULL_SWELLING = 2e-3
"""The same from which the arc alone is taken; in between lies a blend of both."""

PLANNED_SHARE = 0.05
"""Share of its swelling that counts in a step that a controller has planned: the plan's linear maps
are those of the straight path, which is kept until it is off by more than two hundredths."""

AXIS_STAGES, AXIS_ITERATIONS = 4, 5
"""Of Newton's method for the axis: parts of the step that it is led through, iterations of each."""

MOST_ANGLE = 2.0
"""Turn of a step, rad, up to which its angle is exact."""


@cache
def make_turning(precision: str) -> SimpleNamespace:
    """Kernels of a turning step, in the order of their launch."""
    types = real(precision)
    scalar, vec3, vec4 = types.scalar, types.vec3, types.vec4
    kernel, func = types.kernel(SUBJECT), types.func(SUBJECT)
    widening = make_widening(precision, SUBJECT)
    wide, narrow = widening.wide, widening.narrow
    axis_stages, axis_iterations = wp.constant(AXIS_STAGES), wp.constant(AXIS_ITERATIONS)
    most_angle = wp.constant(wp.float64(MOST_ANGLE))
    vec3d, mat33d = wp.vec3d, wp.mat33d
    zero, half, one, two = (wp.constant(wp.float64(x)) for x in (0.0, 0.5, 1.0, 2.0))
    least_inertia = wp.constant(wp.float64(1e-12))
    least_swelling = wp.constant(wp.float64(LEAST_SWELLING))
    swelling_span = wp.constant(wp.float64(FULL_SWELLING - LEAST_SWELLING))

    @func
    def body_of(node: int, body_start: wp.array(dtype=int)):
        body = int(0)
        while body_start[body + 1] <= node:
            body += 1
        return body

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
    def inertia_of(arm: vec3d, mass: wp.float64):
        identity = wp.identity(n=3, dtype=wp.float64)
        return mass * (wp.length_sq(arm) * identity - wp.outer(arm, arm))

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
        for stage in range(axis_stages):
            part = half * step * wp.float64(stage + 1) / wp.float64(axis_stages)
            for _k in range(axis_iterations):
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

    @kernel
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
        count = groups.shape[0]
        for body in range(count):
            groups[body] = balanced[body]
        for number in range(found_count[0]):
            c = found[number]
            if wp.length_sq(impulses[c]) > scalar(0.0):
                one = groups[body_of(nodes[c][0], body_start)]
                other = groups[body_of(nodes[c][2], body_start)]
                if one != other:
                    for body in range(count):
                        if groups[body] == wp.max(one, other):
                            groups[body] = wp.min(one, other)

    @kernel
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
        body_start: wp.array(dtype=int),
        masses: wp.array(dtype=scalar),
        stiffness_factors: wp.array(dtype=wp.float64),
        # in
        counted: wp.array(dtype=wp.float64),
        kinds: wp.array(dtype=int),
        positions: wp.array(dtype=vec3),
        velocities: wp.array(dtype=vec3),
        outer_impulses: wp.array(dtype=vec3),
        pushes: wp.array(dtype=vec3),
        # out
        loose_bodies: wp.array(dtype=int),
        shares: wp.array(dtype=wp.float64),
        centers: wp.array(dtype=vec3d),
        drifts: wp.array(dtype=vec3d),
        momenta: wp.array(dtype=vec3d),
        torques: wp.array(dtype=vec3d),
        inertias: wp.array(dtype=mat33d),
    ):
        # one thread a body: whether neither ground nor a fixed node holds it, and the share that
        # the arc is to have in its step
        body = wp.tid()
        shares[body] = zero
        loose_bodies[body] = 0
        first = body_start[body]
        last = body_start[body + 1]
        for i in range(first, last):
            if kinds[i] != VelocityConstraint.NONE:
                return
        center, drift, momentum, moments = spin_of(first, last, masses, positions, velocities)
        torque = vec3d()
        for i in range(first, last):
            push = wide(outer_impulses[i])
            if pushes:
                push += wide(pushes[i])
            torque += wp.cross(wide(positions[i]) - center, push)
        rate = inverse_inertia(moments) * (momentum + torque)
        swelling = counted[0] * half * stiffness_factors[body] * wp.length_sq(rate)
        s = wp.clamp((swelling - least_swelling) / swelling_span, zero, one)
        loose_bodies[body] = 1
        shares[body] = s * s * (wp.float64(3.0) - wp.float64(2.0) * s)
        centers[body] = center
        drifts[body] = drift
        momenta[body] = momentum
        torques[body] = torque
        inertias[body] = moments

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
            for other in range(count):
                if groups[other] == groups[body] and loose_bodies[other] == 0:
                    turning[body] = 0

    @kernel
    def find_frames(
        # model
        body_start: wp.array(dtype=int),
        masses: wp.array(dtype=scalar),
        step_factors: wp.array(dtype=scalar),
        # in
        turning: wp.array(dtype=int),
        centers: wp.array(dtype=vec3d),
        drifts: wp.array(dtype=vec3d),
        momenta: wp.array(dtype=vec3d),
        torques: wp.array(dtype=vec3d),
        inertias: wp.array(dtype=mat33d),
        positions: wp.array(dtype=vec3),
        velocities: wp.array(dtype=vec3),
        # out
        rates: wp.array(dtype=vec3d),
        spins: wp.array(dtype=vec3d),
        spares: wp.array(dtype=vec3d),
        eulers: wp.array(dtype=vec3d),
        answers: wp.array(dtype=vec3d),
    ):
        # one thread a body; the rate is that of the step's end, as in x+ = x + dt v+
        body = wp.tid()
        if turning[body] == 0:
            return
        dt = wp.float64(step_factors[0])
        moments = inertias[body]
        inverse = inverse_inertia(moments)
        rate = rate_of_step(inverse, momenta[body] + torques[body], dt)
        spin = inverse * momenta[body]
        center = centers[body]
        # the rigid turn that Coriolis' turn makes of what has none
        spare = vec3d()
        for i in range(body_start[body], body_start[body + 1]):
            arm = wide(positions[i]) - center
            own = wide(velocities[i]) - drifts[body] - wp.cross(spin, arm)
            spare += wp.float64(masses[i]) * wp.cross(arm, turned(two * -dt * rate, own))
        rates[body] = rate
        spins[body] = spin
        spares[body] = inverse * spare
        eulers[body] = dt * (inverse * wp.cross(rate, moments * rate))
        # what the impulses that the step is given would turn is in the rate already
        answers[body] = -(inverse * torques[body])

    @kernel
    def enter_frames(
        # model
        body_start: wp.array(dtype=int),
        masses: wp.array(dtype=scalar),
        step_factors: wp.array(dtype=scalar),
        # in
        turning: wp.array(dtype=int),
        centers: wp.array(dtype=vec3d),
        drifts: wp.array(dtype=vec3d),
        rates: wp.array(dtype=vec3d),
        spins: wp.array(dtype=vec3d),
        spares: wp.array(dtype=vec3d),
        eulers: wp.array(dtype=vec3d),
        answers: wp.array(dtype=vec3d),
        positions: wp.array(dtype=vec3),
        velocities: wp.array(dtype=vec3),
        pushes: wp.array(dtype=vec3),
        # out
        kinds: wp.array(dtype=int),
        before: wp.array(dtype=vec3),
        start: wp.array(dtype=vec3),
        change: wp.array(dtype=vec3),
        loads: wp.array(dtype=vec3),
    ):
        # nodes of all other bodies keep what the step gave them
        i = wp.tid()
        body = body_of(i, body_start)
        loads[i] = vec3()
        if turning[body] == 0:
            kinds[i] = VelocityConstraint.FIXED
            return
        dt = wp.float64(step_factors[0])
        rate = rates[body]
        arm = wide(positions[i]) - centers[body]
        own = wide(velocities[i]) - drifts[body] - wp.cross(spins[body], arm)
        own = turned(two * -dt * rate, own) - wp.cross(spares[body], arm)
        # the load is that of the step's beginning; where a body without stiffness would fly apart
        # within the step it is weakened, so that it cannot give more energy than the turn loses
        square = dt * dt * wp.length_sq(rate)
        strength = one / (one + square * square)
        load = (-strength * dt) * wp.cross(rate, wp.cross(rate, arm))
        load += wp.cross(strength * eulers[body] + answers[body], arm)
        kinds[i] = VelocityConstraint.NONE
        before[i] = narrow(drifts[body] + own)
        start[i] = vec3()
        change[i] = vec3()
        loads[i] = narrow(wp.float64(masses[i]) * load)
        if pushes:
            loads[i] = loads[i] + pushes[i]

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

    @kernel
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

    @func
    def spares_of(
        body: int,
        body_start: wp.array(dtype=int),
        masses: wp.array(dtype=scalar),
        groups: wp.array(dtype=int),
        centers: wp.array(dtype=vec3d),
        inertias: wp.array(dtype=mat33d),
        positions: wp.array(dtype=vec3),
        pushes: wp.array(dtype=vec3),
    ):
        # the impulse on a body, its part of the group's sum, the group's torque, and its inertia
        center = centers[body]
        own = vec3d()
        own_mass = zero
        push = vec3d()
        mass = zero
        moment = vec3d()
        torque = vec3d()
        size = zero
        for other in range(groups.shape[0]):
            if groups[other] == groups[body]:
                size += wp.trace(inertias[other])
                for i in range(body_start[other], body_start[other + 1]):
                    m = wp.float64(masses[i])
                    mass += m
                    moment += m * (centers[other] - center)
                    push += wide(pushes[i])
                    torque += wp.cross(wide(positions[i]) - center, wide(pushes[i]))
                    if other == body:
                        own_mass += m
                        own += wide(pushes[i])
        share = push / mass
        return own, own_mass * share, torque - wp.cross(moment, share), size

    @kernel
    def leave_frames(
        # model
        body_start: wp.array(dtype=int),
        masses: wp.array(dtype=scalar),
        damped_masses: wp.array(dtype=scalar),
        gravity: wp.array(dtype=vec3),
        step_factors: wp.array(dtype=scalar),
        # in
        turning: wp.array(dtype=int),
        groups: wp.array(dtype=int),
        shares: wp.array(dtype=wp.float64),
        centers: wp.array(dtype=vec3d),
        drifts: wp.array(dtype=vec3d),
        momenta: wp.array(dtype=vec3d),
        torques: wp.array(dtype=vec3d),
        inertias: wp.array(dtype=mat33d),
        rates: wp.array(dtype=vec3d),
        positions: wp.array(dtype=vec3),
        velocities: wp.array(dtype=vec3),
        outer_impulses: wp.array(dtype=vec3),
        pushes: wp.array(dtype=vec3),
        carried: wp.array(dtype=vec3d),
        # in and out
        before: wp.array(dtype=vec3),
        change: wp.array(dtype=vec3),
        next_positions: wp.array(dtype=vec3),
        next_velocities: wp.array(dtype=vec3),
        # out
        next_increments: wp.array(dtype=vec3),
        carry: wp.array(dtype=vec3d),
    ):
        # one thread a body; the straight path stands in the next state. Sums as in
        # ``rigid_balance``, with damped masses and what rounding left over before
        body = wp.tid()
        if turning[body] == 0:
            return
        first = body_start[body]
        last = body_start[body + 1]
        dt = wp.float64(step_factors[0])
        center = centers[body]
        drift = drifts[body]
        mass = zero
        fall = dt * wide(gravity[0])
        gain = carried[2 * body]
        straight_gain = vec3d()
        mean = vec3d()
        spin = vec3d()
        moments = mat33d()
        for i in range(first, last):
            m = wp.float64(masses[i])
            damped = wp.float64(damped_masses[i])
            arm = wide(positions[i]) - center
            own = (wide(before[i]) - drift) + wide(change[i])
            mass += damped
            gain += m * fall + wide(outer_impulses[i]) - (damped - m) * drift
            straight_gain += damped * (wide(next_velocities[i]) - drift)
            mean += damped * own
            spin += damped * wp.cross(arm, own)
            moments += inertia_of(arm, damped)
        # impulses inside a group add up to none but for rounding, which all share; as they do not
        # act in quite the same points, they make a torque, which is shared out by inertia
        wanted = momenta[body] + torques[body] + carried[2 * body + 1]
        if pushes:
            push, push_of_all, spare, size = spares_of(
                body, body_start, masses, groups, centers, inertias, positions, pushes
            )
            gain += push - push_of_all
            wanted -= (wp.trace(inertias[body]) / size) * spare
        gain = gain / mass
        straight_gain = straight_gain / mass
        # what the solve found beside a rigid motion goes along the arc
        mean = mean / mass
        spin = inverse_inertia(moments) * spin
        turn = dt * rates[body]
        shift = center + dt * (drift + gain)
        share = shares[body]
        straight = one - share
        for i in range(first, last):
            arm = wide(positions[i]) - center
            own = (wide(before[i]) - drift) + wide(change[i]) - mean - wp.cross(spin, arm)
            arc = shift + turned(turn, arm + dt * own)
            own = share * turned(turn, own)
            if straight > zero:
                # a group's turn may have moved the body's centre
                aside = dt * (gain - straight_gain)
                arc = share * arc + straight * (wide(next_positions[i]) + aside)
                own += straight * (wide(next_velocities[i]) - drift - straight_gain)
            next_positions[i] = narrow(arc)
            change[i] = narrow(own)
        # about the places as they are rounded
        end, mean, momentum, moments = spin_of(first, last, damped_masses, next_positions, change)
        rate = inverse_inertia(moments) * (wanted - momentum)
        missing = vec3d()
        # what keeps the inertia from being singular is not to take from it
        lacking = wanted - momentum - moments * rate
        for i in range(first, last):
            arm = wide(next_positions[i]) - end
            ideal = drift + gain + (wide(change[i]) - mean) + wp.cross(rate, arm)
            old = velocities[i]
            new = narrow(ideal - wide(old))
            after = old + new
            before[i] = old
            change[i] = new
            next_velocities[i] = after
            next_increments[i] = new
            impulse = wp.float64(damped_masses[i]) * (ideal - wide(after))
            missing += impulse
            lacking += wp.cross(arm, impulse)
        carry[2 * body] = missing
        carry[2 * body + 1] = lacking

    return SimpleNamespace(
        join_pushed=join_pushed,
        spread_impulses=spread_impulses,
        find_spins=find_spins,
        choose_bodies=choose_bodies,
        find_frames=find_frames,
        enter_frames=enter_frames,
        add_loads=add_loads,
        place=place,
        leave_frames=leave_frames,
    )
