"""Modes of pairs: the active set of ``active_set.py``, with scales taken from the pairs.

The velocity of a pair is that of its first side relative to the second, and its impulse acts on the
first side; the nodes of both sides bear it by their weights. The pair's own block of the matrix is
that of both sides in series. An impulse below a millionth of the largest of any pair counts as
none.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.contact.modes import Mode
from warp_softbody.kernels.contact.pair_constraints import DAMPING, SUBJECT, make_pair_constraints
from warp_softbody.kernels.contact.pair_friction import make_pair_friction
from warp_softbody.kernels.contact.structs import make_contact_structs, make_pair_structs
from warp_softbody.kernels.linear.codes import Counter, Scalar
from warp_softbody.kernels.linear.structs import make_linear_structs
from warp_softbody.kernels.precision import EPSILON, real

LEAST_SHARE = 1e-6
"""Of the largest impulse of any pair, what counts as none."""


@cache
def make_pair_active_set(precision: str) -> SimpleNamespace:
    """Kernels that turn a solved pass into impulses, and impulses into the next modes."""
    types = real(precision)
    scalar, vec3, mat33 = types.scalar, types.vec3, types.mat33
    kernel, func = types.kernel(SUBJECT), types.func(SUBJECT)
    vec2 = wp.types.vector(length=2, dtype=scalar)
    rows = make_pair_constraints(precision)
    structs = make_pair_structs(precision)
    Pairs, DelassusWork = structs.Pairs, structs.DelassusWork
    NodeConstraints = make_linear_structs(precision).NodeConstraints
    structs = make_contact_structs(precision)
    ContactStates, PassRecord = structs.ContactStates, structs.PassRecord
    relative, multipliers, stiffen = rows.relative, rows.multipliers, rows.stiffen
    narrow, remove = rows.narrow, rows.remove
    damping = wp.constant(wp.float64(DAMPING))
    law = make_pair_friction(precision, SUBJECT)
    least_share = wp.constant(scalar(LEAST_SHARE))
    rounding = wp.constant(scalar(8.0 * EPSILON[precision]))

    @func
    def share(pairs: Pairs, c: int, impulse: vec3, out: wp.array(dtype=vec3)):
        k, w = pairs.nodes[c], pairs.weights[c]
        for a in range(4):
            out[k[a]] = out[k[a]] + w[a] * impulse

    @kernel
    def find_impulses(
        # in
        pairs: Pairs,
        modes: wp.array(dtype=int),
        constraints: NodeConstraints,
        frictions: wp.array(dtype=vec3),
        stiffness: wp.array(dtype=mat33),
        x: wp.array(dtype=vec3),
        right: wp.array(dtype=vec3),
        # in and out
        work: DelassusWork,
        r: wp.array(dtype=vec3),
        # out
        impulses: wp.array(dtype=vec3),
        right_with_pairs: wp.array(dtype=vec3),
        largest_impulse: wp.array(dtype=scalar),
    ):
        # r: S (b - M~ x) with all friction forces in b; what is left of it on the rows is borne by
        # them
        for i in range(right.shape[0]):
            right_with_pairs[i] = right[i]
        for number in range(pairs.found_count[0]):
            impulses[pairs.found[number]] = vec3()
        stiffen(pairs, constraints, work, stiffness, wp.float64(-1.0), x, r)
        # the second time takes off what the damping left
        for _ in range(2):
            multipliers(pairs, modes, constraints, work, r, damping)
            for row in range(pairs.active_count[0]):
                impulses[pairs.active[row]] = impulses[pairs.active[row]] - narrow(work.y[row])
            remove(pairs, constraints, work, wp.float64(-1.0), r)
        largest = scalar(0.0)
        for row in range(pairs.active_count[0]):
            c = pairs.active[row]
            impulse = impulses[c]
            if modes[c] == Mode.SLIDE:
                impulse += frictions[c] - stiffness[c] * narrow(relative(pairs, c, x))
            impulses[c] = impulse
            largest = wp.max(largest, wp.length_sq(impulse))
            share(pairs, c, impulse, right_with_pairs)
        largest_impulse[0] = wp.sqrt(largest)

    @func
    def mobility(
        i: int,
        fixed: wp.array(dtype=int),
        diagonal_slot: wp.array(dtype=int),
        values: wp.array(dtype=mat33),
    ):
        if fixed[i] != 0:
            return scalar(0.0)
        return scalar(3.0) / wp.trace(values[diagonal_slot[i]])

    @kernel
    def update_pairs(
        # model
        fixed: wp.array(dtype=int),
        diagonal_slot: wp.array(dtype=int),
        friction_coefficient: scalar,
        approach: scalar,
        # in
        pairs: Pairs,
        values: wp.array(dtype=mat33),
        x: wp.array(dtype=vec3),
        largest_impulse: wp.array(dtype=scalar),
        counters: wp.array(dtype=int),
        scalars: wp.array(dtype=wp.float64),
        # in and out
        states: ContactStates,
        # out
        record: PassRecord,
    ):
        number = wp.tid()
        if number >= pairs.found_count[0]:
            return
        c = pairs.found[number]
        pushed = wp.length_sq(states.friction_forces[c]) > scalar(0.0)
        record.changed[c] = 0
        record.violations[c] = vec2()
        states.friction_forces[c] = vec3()
        states.slip_stiffness[c] = mat33()
        k, w = pairs.nodes[c], pairs.weights[c]
        n = pairs.normals[c]
        mode = states.modes[c]
        least = pairs.normal_velocity[c]
        give = scalar(0.0)
        for a in range(4):
            give += w[a] * w[a] * mobility(k[a], fixed, diagonal_slot, values)
        if give == scalar(0.0):
            return
        weight = scalar(1.0) / give
        none = least_share * largest_impulse[0]
        u = narrow(relative(pairs, c, x))
        impulse = states.impulses[c]
        normal_impulse = wp.dot(n, impulse)
        normal_speed = wp.dot(n, u)
        sliding = u - normal_speed * n
        friction = impulse - normal_impulse * n
        next_mode = Mode.LIFT
        if mode == Mode.LIFT:
            record.violations[c] = vec2(
                weight * wp.max(least - normal_speed, scalar(0.0)), scalar(0.0)
            )
            if normal_speed < least - approach:
                next_mode = Mode.SLIDE
                states.slip_velocities[c] = vec3()
        elif normal_impulse < -none:
            record.violations[c] = vec2(-normal_impulse, wp.length(friction))
            if mode == Mode.STICK:
                next_mode = Mode.SLIDE
                record.changed[c] = 1
                states.slip_velocities[c] = vec3()
        else:
            bound = (
                pairs.friction_factor[c]
                * friction_coefficient
                * wp.max(normal_impulse, scalar(0.0))
            )
            trial = friction - weight * sliding
            record.violations[c] = vec2(
                wp.max(-normal_impulse, scalar(0.0)),
                law.disc_violation(friction, trial, bound),
            )
            # the law cannot be kept closer than the residual that the solver leaves, or than the
            # rounding of the products with this node's velocity
            left = none + scalar(wp.sqrt(scalars[Scalar.FLOOR_SQUARE]))
            left += rounding * weight * wp.length(x[k[0]])
            last = states.slip_velocities[c]
            next_mode, unsettled, force, block, made_at = law.choose(
                mode,
                n,
                friction,
                sliding,
                last,
                pushed,
                bound,
                weight,
                left,
                counters[Counter.PASSES],
            )
            record.changed[c] = unsettled
            states.friction_forces[c] = force
            states.slip_stiffness[c] = block
            states.slip_velocities[c] = made_at
        if next_mode != mode:
            record.changed[c] = 1
        states.modes[c] = next_mode

    @kernel
    def add_frictions(
        # in
        pairs: Pairs,
        modes: wp.array(dtype=int),
        frictions: wp.array(dtype=vec3),
        right: wp.array(dtype=vec3),
        ground_frictions: wp.array(dtype=vec3),
        # out
        right_with_slip: wp.array(dtype=vec3),
    ):
        for i in range(right.shape[0]):
            right_with_slip[i] = right[i] + ground_frictions[i]
        for number in range(pairs.found_count[0]):
            c = pairs.found[number]
            if modes[c] == Mode.SLIDE:
                share(pairs, c, frictions[c], right_with_slip)

    return SimpleNamespace(
        find_impulses=find_impulses, update_pairs=update_pairs, add_frictions=add_frictions
    )
