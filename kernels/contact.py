"""Frictional contact of the surface nodes with a plane, on the step's own velocities.

Signorini's condition at velocity level with a gap term and Coulomb's law with the smooth cone,
solved by a primal-dual active set: the modes (lift, stick, slide) fix which velocity components are
given, conjugate gradients solve the true system for the rest, the residual at the given components
is the contact impulse, and natural-map tests on impulse and velocity choose the modes anew
(Hueeber, Stadler & Wohlmuth 2008). A sliding node's friction -g v_t / |v_t|, g = mu f_n from the
last pass, enters as force and symmetric stiffness linearised at the last pass's velocity: by
Newton's method (force -g d, stiffness g / |v_t| across d) where that velocity has nearly settled,
else by Picard (stiffness g / |v_t| in every tangential direction), which is a descent method for
given g and cannot reverse the sliding.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels import conjugate_gradients as cg
from warp_softbody.kernels.precision import real

SUBJECT = "contact"

LIFT = 0
STICK = 1
SLIDE = 2

NEWTON_PASSES = 4
"""Active-set passes of a step in which nodes may begin to slide and Newton's linearisation is
used."""

PASSES = 4
AGAIN = 5
TOUCHING = 6
CHANGED = 8
EARLIER_PASSES = 9


@cache
def make_contact(precision: str) -> SimpleNamespace:
    """Kernels ``detect``, ``impose``, ``update_modes``, ``conclude_pass`` and the step's ends."""
    types = real(precision)
    scalar, vec3, mat33 = types.scalar, types.vec3, types.mat33
    kernel, func = types.kernel(SUBJECT), types.func(SUBJECT)
    functions = cg.make_conjugate_gradients(precision)
    row_product = functions.row_product
    free, slides, held = wp.constant(cg.FREE), wp.constant(cg.SLIDES), wp.constant(cg.HELD)
    newton_passes = wp.constant(NEWTON_PASSES)
    lift, stick, slide = wp.constant(LIFT), wp.constant(STICK), wp.constant(SLIDE)

    @kernel
    def right_side(
        # model
        node_start: wp.array(dtype=int),
        node_corners: wp.array(dtype=int),
        step_factors: wp.array(dtype=scalar),
        has_muscles: int,
        # in
        momentum: wp.array(dtype=vec3),
        external_forces: wp.array(dtype=vec3),
        muscle_forces: wp.array(dtype=vec3),
        velocities: wp.array(dtype=vec3),
        friction_forces: wp.array(dtype=vec3),
        # out
        right: wp.array(dtype=vec3),
        right_with_slip: wp.array(dtype=vec3),
        x: wp.array(dtype=vec3),
    ):
        i = wp.tid()
        force = external_forces[i]
        if has_muscles != 0:
            for k in range(node_start[i], node_start[i + 1]):
                force += muscle_forces[node_corners[k]]
        known = momentum[i] + step_factors[0] * force
        right[i] = known
        right_with_slip[i] = known + friction_forces[i]
        x[i] = velocities[i]

    @kernel
    def newton_right_side(
        # model
        node_start: wp.array(dtype=int),
        node_corners: wp.array(dtype=int),
        step_factors: wp.array(dtype=scalar),
        mass: wp.array(dtype=scalar),
        row_start: wp.array(dtype=int),
        column: wp.array(dtype=int),
        has_muscles: int,
        # in
        values: wp.array(dtype=mat33),
        momentum: wp.array(dtype=vec3),
        external_forces: wp.array(dtype=vec3),
        muscle_forces: wp.array(dtype=vec3),
        x: wp.array(dtype=vec3),
        friction_forces: wp.array(dtype=vec3),
        # out
        right: wp.array(dtype=vec3),
        right_with_slip: wp.array(dtype=vec3),
    ):
        # forces and K at x + dt v, v the last iterate, where the force is linear in v+ - v: what K
        # takes from v in the matrix is given back, but for damping
        i = wp.tid()
        force = external_forces[i]
        if has_muscles != 0:
            for k in range(node_start[i], node_start[i + 1]):
                force += muscle_forces[node_corners[k]]
        stiff = row_product(i, row_start, column, values, x) - (mass[i] * step_factors[2]) * x[i]
        dt = step_factors[0]
        known = momentum[i] + dt * force + (dt * dt / step_factors[1]) * stiff
        right[i] = known
        right_with_slip[i] = known + friction_forces[i]

    @kernel
    def begin_iteration(
        # out
        counters: wp.array(dtype=int),
    ):
        counters[EARLIER_PASSES] = counters[EARLIER_PASSES] + counters[PASSES]
        counters[PASSES] = 0
        counters[AGAIN] = 0
        counters[cg.LOOSE] = 0

    @kernel
    def detect(
        # model
        surface_nodes: wp.array(dtype=int),
        plane_normal: wp.array(dtype=vec3),
        plane: wp.array(dtype=scalar),
        step_factors: wp.array(dtype=scalar),
        # in
        positions: wp.array(dtype=vec3),
        # out
        normal_velocity: wp.array(dtype=scalar),
        normals: wp.array(dtype=vec3),
    ):
        # plane: offset, friction, recovery speed
        c = wp.tid()
        i = surface_nodes[c]
        n = plane_normal[0]
        gap = wp.dot(n, positions[i]) - plane[0]
        normals[i] = n
        normal_velocity[c] = wp.min(-gap / step_factors[0], plane[2])

    @kernel
    def impose(
        # model
        surface_nodes: wp.array(dtype=int),
        fixed: wp.array(dtype=int),
        plane_normal: wp.array(dtype=vec3),
        # in
        modes: wp.array(dtype=int),
        normal_velocity: wp.array(dtype=scalar),
        # out
        kinds: wp.array(dtype=int),
        x: wp.array(dtype=vec3),
    ):
        c = wp.tid()
        i = surface_nodes[c]
        if fixed[i] == 0:
            mode = modes[c]
            n = plane_normal[0]
            kind = free
            if mode == stick:
                kind = held
                x[i] = normal_velocity[c] * n
            elif mode == slide:
                kind = slides
                x[i] = x[i] + (normal_velocity[c] - wp.dot(n, x[i])) * n
            kinds[i] = kind

    @kernel
    def hold_fixed(
        # model
        fixed: wp.array(dtype=int),
        # out
        kinds: wp.array(dtype=int),
        x: wp.array(dtype=vec3),
    ):
        i = wp.tid()
        if fixed[i] != 0:
            kinds[i] = held
            x[i] = vec3()

    @func
    def linearised_friction(
        n: vec3, bound: scalar, sliding: vec3, last: vec3, slowest: scalar, newton: bool
    ):
        # -bound v / |v|: by Newton's method where v has nearly settled, else by Picard's
        speed = wp.max(wp.length(sliding), slowest)
        direction = sliding / speed
        force = vec3()
        stiffness = (bound / speed) * (wp.identity(n=3, dtype=scalar) - wp.outer(n, n))
        settled = wp.dot(last, direction) > scalar(0.7) * wp.max(wp.length(last), speed)
        if settled and newton:
            force = -bound * direction
            stiffness -= (bound / speed) * wp.outer(direction, direction)
        return force, stiffness

    @kernel
    def update_modes(
        # model
        surface_nodes: wp.array(dtype=int),
        fixed: wp.array(dtype=int),
        row_start: wp.array(dtype=int),
        column: wp.array(dtype=int),
        diagonal_slot: wp.array(dtype=int),
        plane_normal: wp.array(dtype=vec3),
        plane: wp.array(dtype=scalar),
        tolerances: wp.array(dtype=scalar),
        # in
        values: wp.array(dtype=mat33),
        right: wp.array(dtype=vec3),
        x: wp.array(dtype=vec3),
        normal_velocity: wp.array(dtype=scalar),
        counters: wp.array(dtype=int),
        # out
        modes: wp.array(dtype=int),
        impulses: wp.array(dtype=vec3),
        friction_forces: wp.array(dtype=vec3),
        slip_velocities: wp.array(dtype=vec3),
        slip_stiffness: wp.array(dtype=mat33),
        right_with_slip: wp.array(dtype=vec3),
        changed: wp.array(dtype=int),
    ):
        # tolerances: impulse, normal velocity, relative friction, speed that counts as sliding
        c = wp.tid()
        i = surface_nodes[c]
        mode = modes[c]
        n = plane_normal[0]
        changed[c] = 0
        if fixed[i] != 0:
            impulses[c] = vec3()
            return
        impulse = row_product(i, row_start, column, values, x) - right[i]
        normal_impulse = wp.dot(n, impulse)
        normal_speed = wp.dot(n, x[i])
        sliding = x[i] - normal_speed * n
        friction = impulse - normal_impulse * n
        # a node comes and goes through frictionless sliding: only there does the normal impulse
        # speak for itself
        next_mode = lift
        force = vec3()
        stiffness = mat33()
        if mode == lift:
            impulse = vec3()
            if normal_speed < normal_velocity[c] - tolerances[1]:
                next_mode = slide
                slip_velocities[i] = vec3()
        elif normal_impulse < -tolerances[0]:
            if mode == stick:
                next_mode = slide
                changed[c] = 1
                slip_velocities[i] = vec3()
        else:
            bound = plane[1] * wp.max(normal_impulse, scalar(0.0))
            weight = scalar(0.3333333333333333) * wp.trace(values[diagonal_slot[i]])
            trial = friction - weight * sliding
            size = wp.length(trial)
            next_mode = stick
            # to begin, it must exceed the cone by what would move its own block noticeably
            margin = wp.min(weight * tolerances[3], scalar(0.01) * bound)
            slips = size > bound + margin + tolerances[0]
            if mode == slide:
                slips = size > bound and wp.length(sliding) > tolerances[3]
                # friction that would reverse the sliding stops it instead
                slips = slips and wp.dot(slip_velocities[i], sliding) >= scalar(0.0)
            if slips and (mode == slide or counters[PASSES] < newton_passes):
                next_mode = slide
                if mode == stick:
                    # the full friction against where it is driven; its speed is not known yet
                    force = (bound / size) * trial
                    slip_velocities[i] = (scalar(-1.0) / weight) * trial
                else:
                    direction = sliding / wp.max(wp.length(sliding), tolerances[3])
                    law = friction + bound * direction
                    if wp.length(law) > tolerances[2] * bound + tolerances[0]:
                        changed[c] = 1
                    newton = counters[PASSES] < newton_passes
                    force, stiffness = linearised_friction(
                        n, bound, sliding, slip_velocities[i], tolerances[3], newton
                    )
                    slip_velocities[i] = sliding
        if next_mode != mode:
            changed[c] = 1
        modes[c] = next_mode
        impulses[c] = impulse
        friction_forces[i] = force
        slip_stiffness[i] = stiffness
        right_with_slip[i] = right[i] + force

    @kernel
    def conclude_pass(
        # model
        max_passes: int,
        # in
        changed: wp.array(dtype=int),
        modes: wp.array(dtype=int),
        # out
        counters: wp.array(dtype=int),
    ):
        total = int(0)
        touching = int(0)
        for c in range(changed.shape[0]):
            total += changed[c]
            if modes[c] != lift:
                touching += 1
        # modes are sought with loose solves; once they settle, one solve to the tolerance must
        # confirm them
        counters[PASSES] = counters[PASSES] + 1
        counters[TOUCHING] = touching
        counters[CHANGED] = total
        unconfirmed = total > 0 or counters[cg.LOOSE] != 0
        counters[AGAIN] = wp.where(unconfirmed and counters[PASSES] < max_passes, 1, 0)
        counters[cg.LOOSE] = wp.where(total > 0 and counters[PASSES] < max_passes - 1, 1, 0)

    @kernel
    def advance_state(
        # model
        step_factors: wp.array(dtype=scalar),
        # in
        positions: wp.array(dtype=vec3),
        x: wp.array(dtype=vec3),
        # out
        next_positions: wp.array(dtype=vec3),
        next_velocities: wp.array(dtype=vec3),
    ):
        i = wp.tid()
        next_velocities[i] = x[i]
        next_positions[i] = positions[i] + step_factors[0] * x[i]

    return SimpleNamespace(
        right_side=right_side,
        newton_right_side=newton_right_side,
        begin_iteration=begin_iteration,
        detect=detect,
        impose=impose,
        hold_fixed=hold_fixed,
        update_modes=update_modes,
        conclude_pass=conclude_pass,
        advance_state=advance_state,
    )
