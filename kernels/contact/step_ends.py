"""The right-hand side of a step, and the update of the state with what it is solved for."""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.contact.structs import make_contact_structs
from warp_softbody.kernels.linear.bsr_product import make_rows
from warp_softbody.kernels.linear.codes import Counter
from warp_softbody.kernels.precision import real

SUBJECT = "step_ends"


@cache
def make_step_ends(precision: str) -> SimpleNamespace:
    """Structs ``KnownForces``, ``RightSide``, ``VelocityUpdate``; kernels by order of launch."""
    types = real(precision)
    scalar, vec3, mat33 = types.scalar, types.vec3, types.mat33
    kernel, func = types.kernel(SUBJECT), types.func(SUBJECT)
    VelocityUpdate = make_contact_structs(precision).VelocityUpdate
    stiffness_of_sum = make_rows(precision, SUBJECT).stiffness_of_sum

    @wp.struct
    class KnownForces:
        """Impulses (n,) of elasticity and gravity, forces (n,) from outside, of muscles by corner.

        Corner k of a node, from ``node_start``, is slot ``node_corners[k]`` of the muscles'.
        """

        impulses: wp.array(dtype=vec3)
        external: wp.array(dtype=vec3)
        muscles: wp.array(dtype=vec3)
        has_muscles: int
        node_start: wp.array(dtype=int)
        node_corners: wp.array(dtype=int)

    @wp.struct
    class RightSide:
        """Known impulses (n,): without contact, with its friction, and those from outside alone."""

        right: wp.array(dtype=vec3)
        right_with_slip: wp.array(dtype=vec3)
        outer_impulses: wp.array(dtype=vec3)

    @func
    def given_force(forces: KnownForces, i: int):
        # from outside and of the muscles, at a node
        force = forces.external[i]
        if forces.has_muscles != 0:
            for k in range(forces.node_start[i], forces.node_start[i + 1]):
                force += forces.muscles[forces.node_corners[k]]
        return force

    @kernel
    def right_side(
        # model
        step_factors: wp.array(dtype=scalar),
        follows: int,
        # in
        forces: KnownForces,
        velocities: wp.array(dtype=vec3),
        increments: wp.array(dtype=vec3),
        friction_forces: wp.array(dtype=vec3),
        # out
        sides: RightSide,
        moved: VelocityUpdate,
        start: wp.array(dtype=vec3),
    ):
        i = wp.tid()
        sides.outer_impulses[i] = step_factors[0] * forces.external[i]
        known = forces.impulses[i] + step_factors[0] * given_force(forces, i)
        sides.right[i] = known
        sides.right_with_slip[i] = known + friction_forces[i]
        moved.before[i] = velocities[i]
        first = vec3()
        if follows != 0:
            first = increments[i]
        start[i] = first
        moved.change[i] = first

    @types.kernel(SUBJECT, "iterations")
    def newton_right_side(
        # model
        step_factors: wp.array(dtype=scalar),
        stiffness_share: wp.array(dtype=scalar),
        row_start: wp.array(dtype=int),
        column: wp.array(dtype=int),
        # in
        values: wp.array(dtype=mat33),
        forces: KnownForces,
        moved: VelocityUpdate,
        friction_forces: wp.array(dtype=vec3),
        # out
        sides: RightSide,
    ):
        # forces and K at x + dt v, v the last iterate, where the force is linear in v+ - v: what K
        # takes from v in the matrix is given back, but for damping
        i = wp.tid()
        stiff = stiffness_of_sum(i, row_start, column, values, moved.before, moved.change)
        known = forces.impulses[i] + step_factors[0] * given_force(forces, i)
        known += stiffness_share[i] * stiff
        sides.right[i] = known
        sides.right_with_slip[i] = known + friction_forces[i]

    @types.kernel(SUBJECT, "iterations")
    def begin_iteration(
        # out
        counters: wp.array(dtype=int),
    ):
        counters[Counter.EARLIER_PASSES] = (
            counters[Counter.EARLIER_PASSES] + counters[Counter.PASSES]
        )
        counters[Counter.PASSES] = 0
        counters[Counter.AGAIN] = 0
        counters[Counter.FRICTION_NEXT] = 0
        counters[Counter.LOOSE] = 0

    @kernel
    def advance_state(
        # model
        step_factors: wp.array(dtype=scalar),
        # in
        positions: wp.array(dtype=vec3),
        velocities: wp.array(dtype=vec3),
        change: wp.array(dtype=vec3),
        carry: wp.array(dtype=wp.vec3d),
        # out
        next_positions: wp.array(dtype=vec3),
        next_velocities: wp.array(dtype=vec3),
        next_increments: wp.array(dtype=vec3),
        next_carry: wp.array(dtype=wp.vec3d),
    ):
        i = wp.tid()
        if i < carry.shape[0]:
            next_carry[i] = carry[i]
        velocity = velocities[i] + change[i]
        next_increments[i] = change[i]
        next_velocities[i] = velocity
        next_positions[i] = positions[i] + step_factors[0] * velocity

    @kernel
    def exchange_states(
        # in and out
        positions: wp.array(dtype=vec3),
        velocities: wp.array(dtype=vec3),
        increments: wp.array(dtype=vec3),
        carry: wp.array(dtype=wp.vec3d),
        other_positions: wp.array(dtype=vec3),
        other_velocities: wp.array(dtype=vec3),
        other_increments: wp.array(dtype=vec3),
        other_carry: wp.array(dtype=wp.vec3d),
    ):
        i = wp.tid()
        if i < carry.shape[0]:
            kept = carry[i]
            carry[i] = other_carry[i]
            other_carry[i] = kept
        position = positions[i]
        positions[i] = other_positions[i]
        other_positions[i] = position
        velocity = velocities[i]
        velocities[i] = other_velocities[i]
        other_velocities[i] = velocity
        increment = increments[i]
        increments[i] = other_increments[i]
        other_increments[i] = increment

    @types.kernel(SUBJECT, "iterations")
    def add_up(
        # in
        before: wp.array(dtype=vec3),
        change: wp.array(dtype=vec3),
        # out
        velocities: wp.array(dtype=vec3),
    ):
        i = wp.tid()
        velocities[i] = before[i] + change[i]

    @types.kernel(SUBJECT, "iterations")
    def take_difference(
        # in
        before: wp.array(dtype=vec3),
        velocities: wp.array(dtype=vec3),
        # in and out
        change: wp.array(dtype=vec3),
    ):
        # where nothing was imposed, the change is left as it was, with all of its digits
        i = wp.tid()
        change[i] = change[i] + (velocities[i] - (before[i] + change[i]))

    @kernel
    def find_extremes(
        # in
        positions: wp.array(dtype=vec3),
        velocities: wp.array(dtype=vec3),
        # out
        extremes: wp.array(dtype=wp.float64),
    ):
        # largest coordinate and largest component of a velocity
        reach = scalar(0.0)
        speed = scalar(0.0)
        for i in range(positions.shape[0]):
            reach = wp.max(reach, wp.max(wp.abs(positions[i])))
            speed = wp.max(speed, wp.max(wp.abs(velocities[i])))
        extremes[0] = wp.float64(reach)
        extremes[1] = wp.float64(speed)

    return SimpleNamespace(
        KnownForces=KnownForces,
        RightSide=RightSide,
        VelocityUpdate=VelocityUpdate,
        right_side=right_side,
        newton_right_side=newton_right_side,
        begin_iteration=begin_iteration,
        advance_state=advance_state,
        exchange_states=exchange_states,
        add_up=add_up,
        take_difference=take_difference,
        find_extremes=find_extremes,
    )
