"""Frictional contact of the surface nodes with the ground, on the step's own velocities.

Signorini's condition at velocity level with a gap term and Coulomb's law, solved by a primal-dual
active set (Hueeber, Stadler & Wohlmuth 2008). In each pass the modes (lift, stick, slide) say which
velocity components of a node are given; conjugate gradients solve the system for the others; the
residual at the given components is the contact impulse; and tests of impulse and velocity against
the complementarity conditions choose the modes of the next pass.

``friction_smooth.py`` and ``friction_polygon.py`` hold the laws of friction of a sliding node,
``stages.py`` says what the passes of a step may change, ``pass_conclusion.py`` when they end.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.contact.friction_directional import constant_factor, directional_factor
from warp_softbody.kernels.contact.friction_polygon import make_polygon_law
from warp_softbody.kernels.contact.friction_smooth import make_smooth_law
from warp_softbody.kernels.contact.modes import Mode
from warp_softbody.kernels.contact.stages import PICARD_PASSES, NodeChange, SearchStage, make_stages
from warp_softbody.kernels.contact.structs import make_contact_structs
from warp_softbody.kernels.linear import pcg as cg
from warp_softbody.kernels.linear.codes import Counter, Scalar, VelocityConstraint
from warp_softbody.kernels.linear.structs import make_linear_structs
from warp_softbody.kernels.precision import EPSILON, real

SUBJECT = "contact"


@cache
def make_active_set(
    precision: str, directional: bool = False, directions: int = 0
) -> SimpleNamespace:
    """Kernels ``impose``, ``hold_fixed`` and ``update_modes``.

    Args:
        precision: "float32" or "float64".
        directional: whether the coefficient of friction depends on the direction of sliding.
        directions: corners of the polygonal cone; 0 for the smooth cone.
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
    constraint_of, coulomb_violation, choose = law.constraint_of, law.coulomb_violation, law.choose
    stages = make_stages(precision, subject)
    stage_of, braked = stages.stage_of, stages.braked
    structs = make_contact_structs(precision)
    GroundContacts, ContactPlanes = structs.GroundContacts, structs.ContactPlanes
    MatrixRows = make_linear_structs(precision).MatrixRows
    VelocityUpdate = structs.VelocityUpdate
    ContactStates, PassRecord = structs.ContactStates, structs.PassRecord
    picard_passes = wp.constant(PICARD_PASSES)
    inner = wp.constant(scalar(law.inner_radius))
    rounding = wp.constant(scalar(8.0 * EPSILON[precision]))

    @func
    def along(axis: vec3, before: vec3, change: vec3):
        # in double precision: in single, the rounding of the sum of both would be felt
        total = wp.float64(0.0)
        for a in range(3):
            total += wp.float64(axis[a]) * (wp.float64(before[a]) + wp.float64(change[a]))
        return scalar(total)

    @kernel
    def impose(
        # model
        surface_nodes: wp.array(dtype=int),
        fixed: wp.array(dtype=int),
        # in
        planes: ContactPlanes,
        modes: wp.array(dtype=int),
        before: wp.array(dtype=vec3),
        # out
        constraints: wp.array(dtype=int),
        constraint_axes: wp.array(dtype=vec3),
        change: wp.array(dtype=vec3),
    ):
        c = wp.tid()
        i = surface_nodes[c]
        if fixed[i] == 0:
            mode = modes[c]
            n = planes.normals[i]
            given = planes.normal_velocity[c]
            kind = VelocityConstraint.NONE
            if mode == Mode.STICK:
                kind = VelocityConstraint.FIXED
                change[i] = given * n - before[i]
            elif mode != Mode.LIFT:
                kind, axis = constraint_of(mode, n)
                constraint_axes[i] = axis
                lacks = given - along(n, before[i], change[i])
                if kind == VelocityConstraint.LINE:
                    kept = along(axis, before[i], change[i])
                    change[i] = (given * n - before[i]) + kept * axis
                else:
                    change[i] = change[i] + lacks * n
            constraints[i] = kind

    @types.kernel(subject, "fixed")
    def hold_fixed(
        # model
        fixed: wp.array(dtype=int),
        # in
        handled: wp.array(dtype=vec3),
        before: wp.array(dtype=vec3),
        # out
        constraints: wp.array(dtype=int),
        change: wp.array(dtype=vec3),
    ):
        # handled: velocities that handles give; none where there are no handles
        i = wp.tid()
        if fixed[i] != 0:
            constraints[i] = VelocityConstraint.FIXED
            change[i] = -before[i]
            if handled.shape[0] > 0:
                change[i] = handled[i] - before[i]

    @func
    def constitutive_friction(mode: int, n: vec3, friction: vec3, known: vec3):
        # known: the linearised law at the velocity, which entered the solve where the node was free
        # to move; friction: the residual, which held it where it was not
        kind, axis = constraint_of(mode, n)
        if kind == VelocityConstraint.LINE:
            return friction + wp.dot(axis, known - friction) * axis
        return known - wp.dot(n, known) * n

    @func
    def solved_impulse(
        rows: MatrixRows,
        values: wp.array(dtype=mat33),
        right: wp.array(dtype=vec3),
        before: wp.array(dtype=vec3),
        change: wp.array(dtype=vec3),
        i: int,
    ):
        # the residual of the system at a node: what contact brought about there
        impulse = momentum_change(
            i,
            rows.row_start,
            rows.column,
            rows.masses,
            rows.damped_masses,
            values,
            before,
            change,
        )
        return impulse - right[i]

    @func
    def friction_of_stage(
        stage: int,
        passes: int,
        ground: GroundContacts,
        mode: int,
        n: vec3,
        friction: vec3,
        sliding: vec3,
        last: vec3,
        force: vec3,
        stiffness: mat33,
        bound: scalar,
        weight: scalar,
        left: scalar,
    ):
        # of a node that is pressed: next mode, whether the law is missed, and the linearised
        # friction, force and stiffness, with the velocity that it is made at
        tolerances = ground.tolerances
        if stage == SearchStage.NORMALS:
            return mode, int(0), force, stiffness, last
        if stage == SearchStage.LET_GO:
            first = passes == ground.max_passes
            next_mode, unsettled, brake = braked(
                mode, n, friction, sliding, inner * bound, weight, first, stiffness, tolerances
            )
            return next_mode, unsettled, vec3(), brake, sliding
        # in the second stage friction is a stiffness: it cannot reverse the sliding
        rules = wp.where(stage == SearchStage.FRICTION, picard_passes, passes)
        next_mode, unsettled, chosen_force, chosen_stiffness, made_at = choose(
            mode, n, friction, sliding, last, bound, weight, left, rules, tolerances
        )
        return next_mode, unsettled, chosen_force, chosen_stiffness, made_at

    @kernel
    def update_modes(
        # model
        ground: GroundContacts,
        rows: MatrixRows,
        # in
        node_rotations: wp.array(dtype=mat33),
        values: wp.array(dtype=mat33),
        right: wp.array(dtype=vec3),
        moved: VelocityUpdate,
        planes: ContactPlanes,
        counters: wp.array(dtype=int),
        scalars: wp.array(dtype=wp.float64),
        # in and out
        states: ContactStates,
        # out
        right_with_slip: wp.array(dtype=vec3),
        record: PassRecord,
    ):
        c = wp.tid()
        i = ground.nodes[c]
        before, change = moved.before, moved.change
        tolerances = ground.tolerances
        mode = states.modes[c]
        n = planes.normals[i]
        stage = stage_of(counters, ground.max_passes)
        record.changed[c] = NodeChange.NONE
        if ground.fixed[i] != 0:
            states.impulses[c] = vec3()
            return
        weight = scalar(0.3333333333333333) * wp.trace(values[rows.diagonal_slot[i]])
        impulse = vec3()
        if mode != Mode.LIFT:
            impulse = solved_impulse(rows, values, right, before, change, i)
        normal_impulse = wp.dot(n, impulse)
        normal_speed = along(n, before[i], change[i])
        least = planes.normal_velocity[c]
        velocity = before[i] + change[i]
        sliding = velocity - normal_speed * n
        friction = impulse - normal_impulse * n
        if mode != Mode.LIFT and mode != Mode.STICK:
            # the solve's residual is no friction
            known = states.friction_forces[i] - states.slip_stiffness[i] * velocity
            friction = constitutive_friction(mode, n, friction, known)
            impulse = normal_impulse * n + friction
        # a node comes and goes through frictionless sliding: only there does the normal impulse
        # speak for itself
        next_mode = Mode.LIFT
        force = vec3()
        stiffness = mat33()
        if mode == Mode.LIFT:
            record.violations[c] = vec2(
                weight * wp.max(least - normal_speed, scalar(0.0)), scalar(0.0)
            )
            if normal_speed < least - tolerances.normal_speed and stage != SearchStage.LET_GO:
                next_mode = Mode.SLIDE
                states.slip_velocities[i] = vec3()
        elif normal_impulse < -tolerances.impulse:
            record.violations[c] = vec2(-normal_impulse, wp.length(friction))
            if mode == Mode.STICK and stage != SearchStage.LET_GO:
                next_mode = Mode.SLIDE
                states.slip_velocities[i] = vec3()
            record.changed[c] = NodeChange.PRESSED
        else:
            trial = friction - weight * sliding
            factor = friction_factor(c, i, n, -trial, ground, node_rotations)
            bound = factor * ground.friction[c] * wp.max(normal_impulse, scalar(0.0))
            record.violations[c] = vec2(
                wp.max(-normal_impulse, scalar(0.0)), coulomb_violation(n, friction, trial, bound)
            )
            # what holds a node is known no closer than the residual that the solver leaves, or than
            # the rounding of the products with its change
            left = scalar(wp.sqrt(scalars[Scalar.FLOOR_SQUARE]))
            left += rounding * weight * wp.length(change[i])
            next_mode, unsettled, force, stiffness, made_at = friction_of_stage(
                stage,
                counters[Counter.PASSES],
                ground,
                mode,
                n,
                friction,
                sliding,
                states.slip_velocities[i],
                states.friction_forces[i],
                states.slip_stiffness[i],
                bound,
                weight,
                left,
            )
            record.changed[c] = unsettled
            states.slip_velocities[i] = made_at
        if next_mode != mode:
            record.changed[c] = wp.where(
                mode == Mode.LIFT or next_mode == Mode.LIFT, NodeChange.PRESSED, NodeChange.FRICTION
            )
        states.modes[c] = next_mode
        states.impulses[c] = impulse
        states.friction_forces[i] = force
        states.slip_stiffness[i] = stiffness
        right_with_slip[i] = right[i] + force

    return SimpleNamespace(impose=impose, hold_fixed=hold_fixed, update_modes=update_modes)
