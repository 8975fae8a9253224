"""Momenta of bodies that are free to move: what solver and rounding leave over, given back.

The elastic and muscle forces of a body have no net force. So along every direction in which nothing
holds a body, its momentum changes by gravity, outer forces and friction alone, whatever the linear
solve leaves in its residual and whatever rounding does to velocities. A translation is in the null
space of K; adding ``c = (sum of M~)^-1 (what is missing)`` to all velocities of a body is therefore
the exact correction on that part of the solution, in the energy norm the best one.

They have no net torque either, and where nothing at all touches a body the same holds of its
angular momentum about its centre of mass, with the positions at the start of the step as arms
(``x+ x v+ = x x v+``, since ``x+ = x + dt v+``). The correction is a turn. The conserving tangent
annihilates turns; the others do not where the body is strained, and what they take from its spin is
an error of theirs that is mended here.

What the rounding of velocities then still takes is carried to the next step. Bodies that touch each
other form a group: inside it impulses are opposite and equal.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.contact.modes import Mode
from warp_softbody.kernels.linear.codes import VelocityConstraint
from warp_softbody.kernels.precision import real
from warp_softbody.kernels.rigid_bodies import make_rigid_bodies
from warp_softbody.kernels.widening import make_widening

SUBJECT = "rigid_balance"

LEAST_ANGLE = 1e-4
"""Sine of the angle between two directions in which nodes are held that makes them two."""


@cache
def make_rigid_balance(precision: str) -> SimpleNamespace:
    """Kernels ``join_touching`` and ``balance``."""
    types = real(precision)
    scalar, vec3, mat33 = types.scalar, types.vec3, types.mat33
    kernel, func = types.kernel(SUBJECT), types.func(SUBJECT)
    wide = make_widening(precision, SUBJECT).wide
    bodies_of = make_rigid_bodies(precision, SUBJECT)
    body_of, merge_groups = bodies_of.body_of, bodies_of.merge_groups
    inertia_of = bodies_of.inertia_of
    vec3d, mat33d = wp.vec3d, wp.mat33d
    least_inertia = wp.constant(wp.float64(1e-12))
    least_square = wp.constant(wp.float64(LEAST_ANGLE * LEAST_ANGLE))

    @func
    def wide_block(m: mat33):
        return wp.matrix_from_rows(
            wide(vec3(m[0, 0], m[0, 1], m[0, 2])),
            wide(vec3(m[1, 0], m[1, 1], m[1, 2])),
            wide(vec3(m[2, 0], m[2, 1], m[2, 2])),
        )

    @func
    def without(axis: vec3d, projector: mat33d):
        # the projector onto what is left of its space beside a direction that something holds
        rest = projector * axis
        square = wp.length_sq(rest)
        if square > least_square * wp.length_sq(axis):
            return projector - wp.outer(rest, rest) / square
        return projector

    @func
    def left_free(kind: int, axis: vec3d, projector: mat33d):
        if kind == VelocityConstraint.NONE:
            return projector
        if kind == VelocityConstraint.PLANE:
            return without(axis, projector)
        if kind == VelocityConstraint.FIXED:
            return mat33d()
        # free along a line alone
        rest = projector * axis
        across = wp.length_sq(axis) - wp.length_sq(rest)
        if across > least_square * wp.length_sq(axis):
            return mat33d()
        return wp.outer(axis, axis) / wp.length_sq(axis)

    @func
    def directions_left(
        group: int,
        node_start: wp.array(dtype=int),
        groups: wp.array(dtype=int),
        constraints: wp.array(dtype=int),
        constraint_axes: wp.array(dtype=vec3),
    ):
        # the projector onto the translations of a group that nothing holds
        projector = wp.identity(n=3, dtype=wp.float64)
        for body in range(groups.shape[0]):
            if groups[body] == group:
                for i in range(node_start[body], node_start[body + 1]):
                    if constraints[i] != VelocityConstraint.NONE:
                        projector = left_free(constraints[i], wide(constraint_axes[i]), projector)
                        if wp.trace(projector) < wp.float64(0.5):
                            return mat33d()
        return projector

    @wp.struct
    class FreeBodies:
        # what stays constant: first node of each body, number of the group of each, masses of the
        # nodes, kg, without and with damping, gravity, dt and its factors, and whether angular
        # momentum is balanced too
        node_start: wp.array(dtype=int)
        groups: wp.array(dtype=int)
        mass: wp.array(dtype=scalar)
        damped_mass: wp.array(dtype=scalar)
        gravity: wp.array(dtype=vec3)
        step_factors: wp.array(dtype=scalar)
        turns: int

    @kernel
    def balance(
        # model
        bodies: FreeBodies,
        # in
        positions: wp.array(dtype=vec3),
        constraints: wp.array(dtype=int),
        constraint_axes: wp.array(dtype=vec3),
        slip_stiffness: wp.array(dtype=mat33),
        friction_forces: wp.array(dtype=vec3),
        outer_impulses: wp.array(dtype=vec3),
        before: wp.array(dtype=vec3),
        carried: wp.array(dtype=vec3d),
        # in and out
        change: wp.array(dtype=vec3),
        # out
        carry: wp.array(dtype=vec3d),
    ):
        # one thread a group, the one of its first body; sums in double precision. The carries of
        # both momenta of a body stand side by side
        group = wp.tid()
        carry[2 * group] = vec3d()
        carry[2 * group + 1] = vec3d()
        if bodies.groups[group] != group:
            return
        projector = directions_left(
            group, bodies.node_start, bodies.groups, constraints, constraint_axes
        )
        if wp.trace(projector) < wp.float64(0.5):
            return
        free_to_turn = bodies.turns != 0 and wp.trace(projector) > wp.float64(2.5)
        missing = vec3d()
        turning = vec3d()
        answer = mat33d()
        center = vec3d()
        mass = wp.float64(0.0)
        fall = wp.float64(bodies.step_factors[0]) * wide(bodies.gravity[0])
        # moments about a point of the body, where sums lose no digits
        pivot = wide(positions[bodies.node_start[group]])
        moments = mat33d()
        for body in range(bodies.groups.shape[0]):
            if bodies.groups[body] == group:
                missing += carried[2 * body]
                turning += carried[2 * body + 1]
                for i in range(bodies.node_start[body], bodies.node_start[body + 1]):
                    m = wp.float64(bodies.mass[i])
                    damped = wp.float64(bodies.damped_mass[i])
                    old = wide(before[i])
                    own = m * fall + wide(outer_impulses[i])
                    own -= damped * wide(change[i]) + (damped - m) * old
                    mass += damped
                    missing += own
                    if free_to_turn:
                        arm = wide(positions[i]) - pivot
                        center += damped * arm
                        turning += wp.cross(arm, own)
                        moments += inertia_of(arm, damped)
                    if constraints[i] != VelocityConstraint.NONE:
                        slip = slip_stiffness[i]
                        missing += wide(friction_forces[i] - slip * (before[i] + change[i]))
                        answer += wide_block(slip)
        whole = missing
        missing = projector * missing
        answer += mass * wp.identity(n=3, dtype=wp.float64)
        # all of the mass in the directions that are held, so that there is an inverse
        beside = wp.identity(n=3, dtype=wp.float64) - projector
        inner = projector * answer * projector + wp.trace(answer) * beside
        shift = projector * (wp.inverse(inner) * missing)
        turn = vec3d()
        center = center / mass
        if free_to_turn:
            # about the centre of mass; a body of one line of nodes has no inertia about it
            turning -= wp.cross(center, whole)
            moments -= inertia_of(center, mass)
            moments += (least_inertia * wp.trace(moments)) * wp.identity(n=3, dtype=wp.float64)
            if wp.trace(moments) > wp.float64(0.0):
                turn = wp.inverse(moments) * turning
        taken = vec3d()
        turned = vec3d()
        for body in range(bodies.groups.shape[0]):
            if bodies.groups[body] == group:
                for i in range(bodies.node_start[body], bodies.node_start[body + 1]):
                    arm = wide(positions[i]) - pivot - center
                    new = wide(change[i]) + shift + wp.cross(turn, arm)
                    # the velocity after the step, as it will be rounded
                    last = before[i] + vec3(scalar(new[0]), scalar(new[1]), scalar(new[2]))
                    gained = wide(last) - wide(before[i]) - wide(change[i])
                    change[i] = vec3(scalar(new[0]), scalar(new[1]), scalar(new[2]))
                    impulse = wp.float64(bodies.damped_mass[i]) * gained
                    taken += impulse
                    if free_to_turn:
                        turned += wp.cross(arm, impulse)
                    if constraints[i] != VelocityConstraint.NONE:
                        taken += wide_block(slip_stiffness[i]) * gained
        carry[2 * group] = projector * (missing - taken)
        if free_to_turn:
            carry[2 * group + 1] = turning - turned

    @types.kernel(SUBJECT, "pairs")
    def join_touching(
        # model
        node_start: wp.array(dtype=int),
        # in
        found: wp.array(dtype=int),
        found_count: wp.array(dtype=int),
        nodes: wp.array(dtype=wp.vec4i),
        modes: wp.array(dtype=int),
        # out
        groups: wp.array(dtype=int),
    ):
        # in one thread
        for body in range(groups.shape[0]):
            groups[body] = body
        for number in range(found_count[0]):
            c = found[number]
            if modes[c] != Mode.LIFT:
                # the third node is of the other side, of a triangle as of an edge
                one = groups[body_of(nodes[c][0], node_start)]
                merge_groups(one, groups[body_of(nodes[c][2], node_start)], groups)
        # what an edge of the ground holds is no group that is free: it gets a number below zero
        for number in range(found_count[0]):
            c = found[number]
            if modes[c] != Mode.LIFT and nodes[c][0] == nodes[c][2]:
                group = groups[body_of(nodes[c][0], node_start)]
                for body in range(groups.shape[0]):
                    if group >= 0 and groups[body] == group:
                        groups[body] = -1 - group

    return SimpleNamespace(FreeBodies=FreeBodies, join_touching=join_touching, balance=balance)
