"""Modes of the pairs of a node and a triangle: the rules of ``kernels/contact.py``, smooth cone.

Velocity and impulse are those of the node relative to the triangle; the triangle's corners bear the
opposite impulse by their weights. A pair's own block is that of the two sides in series.
"""

from functools import cache
from types import SimpleNamespace

import numpy as np
import warp as wp

from warp_softbody.kernels import stopping
from warp_softbody.kernels.contact_modes import LIFT, SLIDE, STICK
from warp_softbody.kernels.contact_smooth import make_smooth_law
from warp_softbody.kernels.contact_stages import AGAIN, CHANGED, PASSES, TOUCHING
from warp_softbody.kernels.pair_rows import DAMPING, SUBJECT, make_pair_rows
from warp_softbody.kernels.precision import real


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
    lift, stick, slide = wp.constant(LIFT), wp.constant(STICK), wp.constant(SLIDE)
    law = make_smooth_law(precision, SUBJECT)
    rounding = wp.constant(scalar(8.0 * float(np.finfo(precision).eps)))

    @func
    def share(pairs: Pairs, c: int, impulse: vec3, out: wp.array(dtype=vec3)):
        k, w, i = pairs.corners[c], pairs.weights[c], pairs.nodes[c]
        out[i] = out[i] + impulse
        out[k[0]] = out[k[0]] - w[0] * impulse
        out[k[1]] = out[k[1]] - w[1] * impulse
        out[k[2]] = out[k[2]] - w[2] * impulse

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
    ):
        # r: S (b - M~ x) with all friction forces in b; what is left of it on the rows is borne by
        # them
        for i in range(right.shape[0]):
            right_with_pairs[i] = right[i]
        for c in range(modes.shape[0]):
            impulses[c] = vec3()
        stiffen(pairs, freedom, work, stiffness, wp.float64(-1.0), x, r)
        # the second time takes off what the damping left
        for _ in range(2):
            multipliers(pairs, modes, freedom, work, r, damping)
            for row in range(pairs.count[0]):
                impulses[pairs.rows[row]] = impulses[pairs.rows[row]] - narrow(work.y[row])
            remove(pairs, freedom, work, wp.float64(-1.0), r)
        for row in range(pairs.count[0]):
            c = pairs.rows[row]
            impulse = impulses[c]
            if modes[c] == slide:
                impulse += frictions[c] - stiffness[c] * narrow(relative(pairs, c, x))
            impulses[c] = impulse
            share(pairs, c, impulse, right_with_pairs)

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
        tolerances: wp.array(dtype=scalar),
        # in
        pairs: Pairs,
        values: wp.array(dtype=mat33),
        x: wp.array(dtype=vec3),
        impulses: wp.array(dtype=vec3),
        counters: wp.array(dtype=int),
        scalars: wp.array(dtype=wp.float64),
        # in and out
        modes: wp.array(dtype=int),
        slip_velocities: wp.array(dtype=vec3),
        # out
        frictions: wp.array(dtype=vec3),
        stiffness: wp.array(dtype=mat33),
        changed: wp.array(dtype=int),
        violations: wp.array(dtype=vec2),
    ):
        c = wp.tid()
        changed[c] = 0
        violations[c] = vec2()
        frictions[c] = vec3()
        stiffness[c] = mat33()
        k = pairs.corners[c]
        if k[0] < 0:
            return
        w = pairs.weights[c]
        n = pairs.normals[c]
        mode = modes[c]
        least = pairs.least[c]
        give = mobility(pairs.nodes[c], fixed, diagonal_slot, values)
        for a in range(3):
            give += w[a] * w[a] * mobility(k[a], fixed, diagonal_slot, values)
        if give == scalar(0.0):
            return
        weight = scalar(1.0) / give
        u = narrow(relative(pairs, c, x))
        impulse = impulses[c]
        normal_impulse = wp.dot(n, impulse)
        normal_speed = wp.dot(n, u)
        sliding = u - normal_speed * n
        friction = impulse - normal_impulse * n
        next_mode = lift
        if mode == lift:
            violations[c] = vec2(weight * wp.max(least - normal_speed, scalar(0.0)), scalar(0.0))
            if normal_speed < least - tolerances[1]:
                next_mode = slide
                slip_velocities[c] = vec3()
        elif normal_impulse < -tolerances[0]:
            violations[c] = vec2(-normal_impulse, wp.length(friction))
            if mode == stick:
                next_mode = slide
                changed[c] = 1
                slip_velocities[c] = vec3()
        else:
            bound = friction_coefficient * wp.max(normal_impulse, scalar(0.0))
            trial = friction - weight * sliding
            violations[c] = vec2(
                wp.max(-normal_impulse, scalar(0.0)),
                law.coulomb_violation(n, friction, trial, bound),
            )
            # the law cannot be kept closer than the residual that the solver leaves, or than the
            # rounding of the products with this node's velocity
            left = scalar(wp.sqrt(scalars[stopping.FLOOR_SQUARE]))
            left += rounding * weight * wp.length(x[pairs.nodes[c]])
            last = slip_velocities[c]
            next_mode, unsettled, force, block, made_at = law.choose(
                mode, n, friction, sliding, last, bound, weight, left, counters[PASSES], tolerances
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
        for c in range(modes.shape[0]):
            if modes[c] == slide:
                share(pairs, c, frictions[c], right_with_slip)

    @kernel
    def conclude_pairs(
        # model
        max_passes: int,
        # in
        changed: wp.array(dtype=int),
        modes: wp.array(dtype=int),
        violations: wp.array(dtype=vec2),
        # in and out
        counters: wp.array(dtype=int),
        largest_violations: wp.array(dtype=vec2),
    ):
        # on top of what ``conclude_pass`` made of the ground's contacts
        total = int(0)
        touching = int(0)
        largest = largest_violations[0]
        for c in range(modes.shape[0]):
            total += changed[c]
            largest = wp.max(largest, violations[c])
            if modes[c] != lift:
                touching += 1
        counters[TOUCHING] = counters[TOUCHING] + touching
        counters[CHANGED] = counters[CHANGED] + total
        largest_violations[0] = largest
        if total > 0:
            counters[AGAIN] = wp.where(counters[PASSES] < max_passes, 1, 0)
            counters[stopping.LOOSE] = wp.where(counters[PASSES] < max_passes - 1, 1, 0)

    return SimpleNamespace(
        find_impulses=find_impulses,
        update_pairs=update_pairs,
        add_frictions=add_frictions,
        conclude_pairs=conclude_pairs,
    )
