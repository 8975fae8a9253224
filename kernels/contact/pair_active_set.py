"""Modes of pairs: the rules of ``kernels/contact/active_set.py``, with scales taken from the pairs.

Velocity and impulse are those of the one side relative to the other; the nodes of both bear the
impulse by their weights. A pair's own block is that of the two sides in series. An impulse counts
as none below a millionth of the largest of any pair.
"""

from functools import cache
from types import SimpleNamespace

import numpy as np
import warp as wp

from warp_softbody.kernels.contact.modes import Mode
from warp_softbody.kernels.contact.pair_constraints import DAMPING, SUBJECT, make_pair_rows
from warp_softbody.kernels.contact.pair_friction import make_pair_friction
from warp_softbody.kernels.contact.stages import ALL_PASSES
from warp_softbody.kernels.linear.codes import Counter, Scalar
from warp_softbody.kernels.precision import real

LEAST_SHARE = 1e-6
"""Of the largest impulse of any pair, what counts as none."""


@cache
def make_pair_modes(precision: str) -> SimpleNamespace:
    """Kernels that turn a solved pass into impulses, and impulses into the next modes."""
    types = real(precision)
    scalar, vec3, mat33 = types.scalar, types.vec3, types.mat33
    kernel, func = types.kernel(SUBJECT), types.func(SUBJECT)
    vec2 = wp.types.vector(length=2, dtype=scalar)
    rows = make_pair_rows(precision)
    Pairs, Work, Freedom = rows.Pairs, rows.Work, rows.Freedom
    relative, multipliers, stiffen = rows.relative, rows.multipliers, rows.stiffen
    narrow, remove = rows.narrow, rows.remove
    damping = wp.constant(wp.float64(DAMPING))
    all_passes = wp.constant(ALL_PASSES)
    law = make_pair_friction(precision, SUBJECT)
    least_share = wp.constant(scalar(LEAST_SHARE))
    rounding = wp.constant(scalar(8.0 * float(np.finfo(precision).eps)))

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
        freedom: Freedom,
        work: Work,
        frictions: wp.array(dtype=vec3),
        stiffness: wp.array(dtype=mat33),
        x: wp.array(dtype=vec3),
        right: wp.array(dtype=vec3),
        # in and out
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
        stiffen(pairs, freedom, work, stiffness, wp.float64(-1.0), x, r)
        # the second time takes off what the damping left
        for _ in range(2):
            multipliers(pairs, modes, freedom, work, r, damping)
            for row in range(pairs.count[0]):
                impulses[pairs.rows[row]] = impulses[pairs.rows[row]] - narrow(work.y[row])
            remove(pairs, freedom, work, wp.float64(-1.0), r)
        largest = scalar(0.0)
        for row in range(pairs.count[0]):
            c = pairs.rows[row]
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
        impulses: wp.array(dtype=vec3),
        largest_impulse: wp.array(dtype=scalar),
        counters: wp.array(dtype=int),
        scalars: wp.array(dtype=wp.float64),
        # in and out
        modes: wp.array(dtype=int),
        slip_velocities: wp.array(dtype=vec3),
        frictions: wp.array(dtype=vec3),
        # out
        stiffness: wp.array(dtype=mat33),
        changed: wp.array(dtype=int),
        violations: wp.array(dtype=vec2),
    ):
        number = wp.tid()
        if number >= pairs.found_count[0]:
            return
        c = pairs.found[number]
        pushed = wp.length_sq(frictions[c]) > scalar(0.0)
        changed[c] = 0
        violations[c] = vec2()
        frictions[c] = vec3()
        stiffness[c] = mat33()
        k, w = pairs.nodes[c], pairs.weights[c]
        n = pairs.normals[c]
        mode = modes[c]
        least = pairs.least[c]
        give = scalar(0.0)
        for a in range(4):
            give += w[a] * w[a] * mobility(k[a], fixed, diagonal_slot, values)
        if give == scalar(0.0):
            return
        weight = scalar(1.0) / give
        none = least_share * largest_impulse[0]
        u = narrow(relative(pairs, c, x))
        impulse = impulses[c]
        normal_impulse = wp.dot(n, impulse)
        normal_speed = wp.dot(n, u)
        sliding = u - normal_speed * n
        friction = impulse - normal_impulse * n
        next_mode = Mode.LIFT
        if mode == Mode.LIFT:
            violations[c] = vec2(weight * wp.max(least - normal_speed, scalar(0.0)), scalar(0.0))
            if normal_speed < least - approach:
                next_mode = Mode.SLIDE
                slip_velocities[c] = vec3()
        elif normal_impulse < -none:
            violations[c] = vec2(-normal_impulse, wp.length(friction))
            if mode == Mode.STICK:
                next_mode = Mode.SLIDE
                changed[c] = 1
                slip_velocities[c] = vec3()
        else:
            bound = pairs.roughness[c] * friction_coefficient * wp.max(normal_impulse, scalar(0.0))
            trial = friction - weight * sliding
            violations[c] = vec2(
                wp.max(-normal_impulse, scalar(0.0)),
                law.disc_violation(friction, trial, bound),
            )
            # the law cannot be kept closer than the residual that the solver leaves, or than the
            # rounding of the products with this node's velocity
            left = none + scalar(wp.sqrt(scalars[Scalar.FLOOR_SQUARE]))
            left += rounding * weight * wp.length(x[k[0]])
            last = slip_velocities[c]
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
            changed[c] = unsettled
            frictions[c] = force
            stiffness[c] = block
            slip_velocities[c] = made_at
        if next_mode != mode:
            changed[c] = 1
        modes[c] = next_mode

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

    @kernel
    def conclude_pairs(
        # model
        max_passes: int,
        # in
        pairs: Pairs,
        changed: wp.array(dtype=int),
        modes: wp.array(dtype=int),
        violations: wp.array(dtype=vec2),
        # in and out
        counters: wp.array(dtype=int),
        largest_violations: wp.array(dtype=vec2),
        # out
        unsettled: wp.array(dtype=int),
        worst: wp.array(dtype=int),
    ):
        # on top of what ``conclude_pass`` made of the ground's contacts
        total = int(0)
        touching = int(0)
        largest = largest_violations[0]
        most = scalar(0.0)
        worst[0] = -1
        for number in range(pairs.found_count[0]):
            c = pairs.found[number]
            total += changed[c]
            largest = wp.max(largest, violations[c])
            size = wp.max(violations[c][0], violations[c][1])
            if size > most:
                most = size
                worst[0] = c
            if modes[c] != Mode.LIFT:
                touching += 1
        counters[Counter.TOUCHING] = counters[Counter.TOUCHING] + touching
        counters[Counter.CHANGED] = counters[Counter.CHANGED] + total
        largest_violations[0] = largest
        unsettled[0] = total
        if total > 0:
            # what pairs have not found by then they do not find later
            limit = wp.min(max_passes, all_passes)
            if counters[Counter.PASSES] < limit:
                counters[Counter.AGAIN] = 1
            counters[Counter.LOOSE] = wp.where(counters[Counter.PASSES] < limit - 1, 1, 0)

    return SimpleNamespace(
        find_impulses=find_impulses,
        update_pairs=update_pairs,
        add_frictions=add_frictions,
        conclude_pairs=conclude_pairs,
    )
