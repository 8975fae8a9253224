"""Frictional contact of the surface nodes with the ground, on the step's own velocities.

Signorini's condition at velocity level with a gap term and Coulomb's law, solved by a primal-dual
active set: the modes (lift, stick, slide) fix which velocity components are given, conjugate
gradients solve the true system for the rest, the residual at the given components is the contact
impulse, and natural-map tests on impulse and velocity choose the modes anew (Hueeber, Stadler &
Wohlmuth 2008). ``contact_smooth`` and ``contact_polygon`` have the friction of a sliding node, with
the bound of the last pass.

Passes come in three stages (``contact_stages``): at first all is chosen at once; later friction is
frozen until the nodes that are pressed have settled, then chosen again (a fixed point of Tresca
problems); at last nodes are only let go, under friction that can only brake, so that a step that
does not settle ends without impulses that pull, leave their cone or drive.
"""

from functools import cache
from types import SimpleNamespace

import numpy as np
import warp as wp

from warp_softbody.kernels.contact.friction_directional import constant_factor, directional_factor
from warp_softbody.kernels.contact.friction_polygon import make_polygon_law
from warp_softbody.kernels.contact.friction_smooth import make_smooth_law
from warp_softbody.kernels.contact.modes import Mode
from warp_softbody.kernels.contact.stages import PICARD_PASSES, NodeChange, SearchStage, make_stages
from warp_softbody.kernels.linear import pcg as cg
from warp_softbody.kernels.linear.codes import Counter, Scalar, VelocityConstraint
from warp_softbody.kernels.precision import real

SUBJECT = "contact"


@cache
def make_contact(precision: str, directional: bool = False, directions: int = 0) -> SimpleNamespace:
    """Kernels ``impose``, ``hold_fixed``, ``update_modes`` and ``conclude_pass``.

    With ``directional`` the friction of a node depends on the direction in which it slides; with
    ``directions`` the cone has so many, and is smooth without.
    """
    subject = "directional_contact" if directional else SUBJECT
    if directions:
        subject += f"_of_{directions}"
    types = real(precision)
    scalar, vec3, mat33 = types.scalar, types.vec3, types.mat33
    kernel, func = types.kernel(subject), types.func(subject)
    vec2 = wp.types.vector(length=2, dtype=scalar)
    momentum_change = cg.make_conjugate_gradients(precision).momentum_change
    make_factor = directional_factor if directional else constant_factor
    friction_factor = make_factor(precision, subject)
    law = make_smooth_law(precision, subject)
    if directions:
        law = make_polygon_law(precision, subject, directions)
    freedom_of, coulomb_violation, choose = law.freedom_of, law.coulomb_violation, law.choose
    stages = make_stages(precision, subject)
    stage_of, braked, next_stage = stages.stage_of, stages.braked, stages.next_stage
    picard_passes = wp.constant(PICARD_PASSES)
    inner = wp.constant(scalar(law.inner_radius))
    rounding = wp.constant(scalar(8.0 * float(np.finfo(precision).eps)))

    @func
    def along(axis: vec3, before: vec3, change: vec3):
        # of their sum, whose rounding would be felt
        sum = wp.float64(0.0)
        for a in range(3):
            sum += wp.float64(axis[a]) * (wp.float64(before[a]) + wp.float64(change[a]))
        return scalar(sum)

    @kernel
    def impose(
        # model
        surface_nodes: wp.array(dtype=int),
        fixed: wp.array(dtype=int),
        # in
        normals: wp.array(dtype=vec3),
        modes: wp.array(dtype=int),
        normal_velocity: wp.array(dtype=scalar),
        before: wp.array(dtype=vec3),
        # out
        kinds: wp.array(dtype=int),
        axes: wp.array(dtype=vec3),
        change: wp.array(dtype=vec3),
    ):
        c = wp.tid()
        i = surface_nodes[c]
        if fixed[i] == 0:
            mode = modes[c]
            n = normals[i]
            kind = VelocityConstraint.NONE
            if mode == Mode.STICK:
                kind = VelocityConstraint.FIXED
                change[i] = normal_velocity[c] * n - before[i]
            elif mode != Mode.LIFT:
                kind, axis = freedom_of(mode, n)
                axes[i] = axis
                lacks = normal_velocity[c] - along(n, before[i], change[i])
                if kind == VelocityConstraint.LINE:
                    kept = along(axis, before[i], change[i])
                    change[i] = (normal_velocity[c] * n - before[i]) + kept * axis
                else:
                    change[i] = change[i] + lacks * n
            kinds[i] = kind

    @kernel
    def hold_fixed(
        # model
        fixed: wp.array(dtype=int),
        # in
        before: wp.array(dtype=vec3),
        # out
        kinds: wp.array(dtype=int),
        change: wp.array(dtype=vec3),
    ):
        i = wp.tid()
        if fixed[i] != 0:
            kinds[i] = VelocityConstraint.FIXED
            change[i] = -before[i]

    @func
    def law_s_friction(mode: int, n: vec3, friction: vec3, known: vec3):
        # what entered the solve where the node was free to move, what held it where it was not
        kind, axis = freedom_of(mode, n)
        if kind == VelocityConstraint.LINE:
            return friction + wp.dot(axis, known - friction) * axis
        return known - wp.dot(n, known) * n

    @kernel
    def update_modes(
        # model
        surface_nodes: wp.array(dtype=int),
        fixed: wp.array(dtype=int),
        row_start: wp.array(dtype=int),
        column: wp.array(dtype=int),
        diagonal_slot: wp.array(dtype=int),
        masses: wp.array(dtype=scalar),
        damped_masses: wp.array(dtype=scalar),
        friction_coefficient: wp.array(dtype=scalar),
        forward: wp.array(dtype=vec3),
        friction_factors: wp.array2d(dtype=scalar),
        tolerances: wp.array(dtype=scalar),
        max_passes: int,
        # in
        node_rotations: wp.array(dtype=mat33),
        values: wp.array(dtype=mat33),
        right: wp.array(dtype=vec3),
        before: wp.array(dtype=vec3),
        change: wp.array(dtype=vec3),
        normals: wp.array(dtype=vec3),
        normal_velocity: wp.array(dtype=scalar),
        counters: wp.array(dtype=int),
        scalars: wp.array(dtype=wp.float64),
        # out
        modes: wp.array(dtype=int),
        impulses: wp.array(dtype=vec3),
        friction_forces: wp.array(dtype=vec3),
        slip_velocities: wp.array(dtype=vec3),
        slip_stiffness: wp.array(dtype=mat33),
        right_with_slip: wp.array(dtype=vec3),
        changed: wp.array(dtype=int),
        violations: wp.array(dtype=vec2),
    ):
        # tolerances: impulse, normal velocity, relative friction, speed that counts as sliding
        c = wp.tid()
        i = surface_nodes[c]
        mode = modes[c]
        n = normals[i]
        stage = stage_of(counters, max_passes)
        changed[c] = 0
        if fixed[i] != 0:
            impulses[c] = vec3()
            return
        weight = scalar(0.3333333333333333) * wp.trace(values[diagonal_slot[i]])
        impulse = vec3()
        if mode != Mode.LIFT:
            impulse = momentum_change(
                i, row_start, column, masses, damped_masses, values, before, change
            )
            impulse -= right[i]
        normal_impulse = wp.dot(n, impulse)
        normal_speed = along(n, before[i], change[i])
        velocity = before[i] + change[i]
        sliding = velocity - normal_speed * n
        friction = impulse - normal_impulse * n
        if mode != Mode.LIFT and mode != Mode.STICK:
            # the solve's residual is no friction
            known = friction_forces[i] - slip_stiffness[i] * velocity
            friction = law_s_friction(mode, n, friction, known)
            impulse = normal_impulse * n + friction
        # a node comes and goes through frictionless sliding: only there does the normal impulse
        # speak for itself
        next_mode = Mode.LIFT
        force = vec3()
        stiffness = mat33()
        if mode == Mode.LIFT:
            violations[c] = vec2(
                weight * wp.max(normal_velocity[c] - normal_speed, scalar(0.0)), scalar(0.0)
            )
            if normal_speed < normal_velocity[c] - tolerances[1] and stage != SearchStage.LET_GO:
                next_mode = Mode.SLIDE
                slip_velocities[i] = vec3()
        elif normal_impulse < -tolerances[0]:
            violations[c] = vec2(-normal_impulse, wp.length(friction))
            if mode == Mode.STICK and stage != SearchStage.LET_GO:
                next_mode = Mode.SLIDE
                slip_velocities[i] = vec3()
            changed[c] = NodeChange.PRESSED
        else:
            trial = friction - weight * sliding
            factor = friction_factor(c, i, n, -trial, forward, friction_factors, node_rotations)
            bound = factor * friction_coefficient[c] * wp.max(normal_impulse, scalar(0.0))
            violations[c] = vec2(
                wp.max(-normal_impulse, scalar(0.0)), coulomb_violation(n, friction, trial, bound)
            )
            # what holds a node is known no closer than the residual that the solver leaves, or than
            # the rounding of the products with its change
            left = scalar(wp.sqrt(scalars[Scalar.FLOOR_SQUARE]))
            left += rounding * weight * wp.length(change[i])
            last = slip_velocities[i]
            if stage == SearchStage.NORMALS:
                next_mode = mode
                force = friction_forces[i]
                stiffness = slip_stiffness[i]
            elif stage == SearchStage.LET_GO:
                first = counters[Counter.PASSES] == max_passes
                next_mode, unsettled, stiffness = braked(
                    mode,
                    n,
                    friction,
                    sliding,
                    inner * bound,
                    weight,
                    first,
                    slip_stiffness[i],
                    tolerances,
                )
                changed[c] = unsettled
                slip_velocities[i] = sliding
            else:
                passes = counters[Counter.PASSES]
                if stage == SearchStage.FRICTION:
                    # stiffness for friction: it cannot reverse the sliding
                    passes = picard_passes
                next_mode, unsettled, force, stiffness, made_at = choose(
                    mode, n, friction, sliding, last, bound, weight, left, passes, tolerances
                )
                changed[c] = unsettled
                slip_velocities[i] = made_at
        if next_mode != mode:
            changed[c] = wp.where(
                mode == Mode.LIFT or next_mode == Mode.LIFT, NodeChange.PRESSED, NodeChange.FRICTION
            )
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
        violations: wp.array(dtype=vec2),
        # out
        counters: wp.array(dtype=int),
        largest_violations: wp.array(dtype=vec2),
    ):
        total = int(0)
        normals_changed = int(0)
        touching = int(0)
        largest = vec2()
        for c in range(changed.shape[0]):
            if changed[c] != 0:
                total += 1
            if changed[c] == NodeChange.PRESSED:
                normals_changed += 1
            largest = wp.max(largest, violations[c])
            if modes[c] != Mode.LIFT:
                touching += 1
        counters[Counter.TOUCHING] = touching
        largest_violations[0] = largest
        next_stage(total, normals_changed, max_passes, counters)

    return SimpleNamespace(
        impose=impose,
        hold_fixed=hold_fixed,
        update_modes=update_modes,
        conclude_pass=conclude_pass,
    )
