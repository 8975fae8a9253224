"""What contact holds, told to the coarse level: a correction of small rank to its solution.

The coarse matrix A is that of a body that nothing touches. Nodes whose velocities contact gives, or
brakes by slip stiffness, resist the motions of their aggregates by W_i, 3 x 3: on the given
components the diagonal block's mean, on the others slip stiffness. The nodes are parted into a
few groups; the coarse forces of a group that moves as one are the columns F, its resistance W, the
sum over its nodes. Then ``A + F W^-1 F^T`` is no more than what all nodes resist by themselves, and
its inverse is ``A^-1 - X (W + F^T X)^-1 F^T A^-1`` with X = A^-1 F (Woodbury). Three columns for
each group fill one block of right-hand sides.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.linear import pcg as cg
from warp_softbody.kernels.linear.codes import VelocityConstraint
from warp_softbody.kernels.precision import BLOCK, real

SUBJECT = "held_motions"

GROUPS = BLOCK // 3
"""Groups of nodes that contact holds."""

COLUMNS = 3 * GROUPS
"""Translations of all groups."""


@cache
def make_held_motions(precision: str) -> SimpleNamespace:
    """Kernels; ``warp_softbody.linear.held_motions`` puts them in order."""
    types = real(precision)
    scalar, vec3, mat33, block = types.scalar, types.vec3, types.mat33, types.block
    kernel = types.kernel(SUBJECT)
    groups, columns_used = wp.constant(GROUPS), wp.constant(COLUMNS)
    project = cg.make_conjugate_gradients(precision).project

    @kernel
    def find_resistances(
        # model
        diagonal_slot: wp.array(dtype=int),
        # in
        values: wp.array(dtype=mat33),
        constraints: wp.array(dtype=int),
        constraint_axes: wp.array(dtype=vec3),
        slip_stiffness: wp.array(dtype=mat33),
        # out
        resistances: wp.array(dtype=mat33),
    ):
        # symmetric, positive semi-definite: of the given components, and of friction on the others,
        # where more than the body's own stiffness would tell no more
        i = wp.tid()
        kind = constraints[i]
        axis = constraint_axes[i]
        slip = slip_stiffness[i]
        result = mat33()
        if kind != VelocityConstraint.NONE or wp.trace(slip) > scalar(0.0):
            size = scalar(0.3333333333333333) * wp.trace(values[diagonal_slot[i]])
            unit = wp.identity(n=3, dtype=scalar)
            free = wp.matrix_from_cols(
                project(kind, axis, unit[0]),
                project(kind, axis, unit[1]),
                project(kind, axis, unit[2]),
            )
            braked = size / wp.max(size, wp.trace(slip))
            result = size * (unit - free) + braked * free * slip * free
        resistances[i] = result

    @kernel
    def part_held_nodes(
        # model
        aggregate_of: wp.array(dtype=int),
        points: wp.array(dtype=vec3),
        # in
        resistances: wp.array(dtype=mat33),
        # out
        held: wp.array(dtype=int),
        distance: wp.array(dtype=scalar),
        group_of: wp.array(dtype=int),
        count: wp.array(dtype=int),
    ):
        # groups around nodes that are as far from each other as can be, one after the other
        found = int(0)
        for i in range(group_of.shape[0]):
            group_of[i] = -1
            if aggregate_of[i] >= 0 and wp.trace(resistances[i]) > scalar(0.0):
                held[found] = i
                distance[found] = wp.length_sq(points[i] - points[held[0]])
                found += 1
        count[0] = found
        for g in range(groups):
            centre = int(0)
            for k in range(found):
                if distance[k] > distance[centre]:
                    centre = k
            middle = points[held[centre]]
            for k in range(found):
                apart = wp.length_sq(points[held[k]] - middle)
                if g == 0 or apart < distance[k]:
                    distance[k] = apart
                    group_of[held[k]] = g

    @kernel
    def gather_columns(
        # model
        aggregate_start: wp.array(dtype=int),
        aggregate_nodes: wp.array(dtype=int),
        offsets: wp.array(dtype=vec3),
        # in
        resistances: wp.array(dtype=mat33),
        rotations: wp.array(dtype=mat33),
        group_of: wp.array(dtype=int),
        # out
        touched: wp.array(dtype=int),
        columns: wp.array2d(dtype=block),
    ):
        aggregate = wp.tid()
        found = int(0)
        f0 = block()
        f1 = block()
        f2 = block()
        m0 = block()
        m1 = block()
        m2 = block()
        for k in range(aggregate_start[aggregate], aggregate_start[aggregate + 1]):
            i = aggregate_nodes[k]
            group = group_of[i]
            if group >= 0:
                found = int(1)
                force = wp.transpose(rotations[i]) * resistances[i]
                moment = wp.skew(offsets[i]) * force
                for axis in range(3):
                    lane = 3 * group + axis
                    f0[lane] = f0[lane] + force[0, axis]
                    f1[lane] = f1[lane] + force[1, axis]
                    f2[lane] = f2[lane] + force[2, axis]
                    m0[lane] = m0[lane] + moment[0, axis]
                    m1[lane] = m1[lane] + moment[1, axis]
                    m2[lane] = m2[lane] + moment[2, axis]
        touched[aggregate] = found
        first = 6 * aggregate
        columns[0, first] = f0
        columns[0, first + 1] = f1
        columns[0, first + 2] = f2
        columns[0, first + 3] = m0
        columns[0, first + 4] = m1
        columns[0, first + 5] = m2

    @kernel
    def factorise_small(
        # model
        margin: wp.float64,
        # in
        resistances: wp.array(dtype=mat33),
        held: wp.array(dtype=int),
        group_of: wp.array(dtype=int),
        count: wp.array(dtype=int),
        touched: wp.array(dtype=int),
        columns: wp.array2d(dtype=block),
        answers: wp.array2d(dtype=block),
        # out
        small: wp.array2d(dtype=wp.float64),
    ):
        # small = lower Cholesky factor of W + F^T X
        for a in range(columns_used):
            for b in range(columns_used):
                small[a, b] = wp.float64(0.0)
        for k in range(count[0]):
            i = held[k]
            first = 3 * group_of[i]
            known = resistances[i]
            for a in range(3):
                for b in range(3):
                    small[first + a, first + b] += wp.float64(known[a, b])
        for aggregate in range(touched.shape[0]):
            if touched[aggregate] != 0:
                for row in range(6 * aggregate, 6 * aggregate + 6):
                    force = columns[0, row]
                    answer = answers[0, row]
                    for a in range(columns_used):
                        if force[a] != scalar(0.0):
                            for b in range(columns_used):
                                small[a, b] += wp.float64(force[a]) * wp.float64(answer[b])
        # a column whose pivot is no more than rounding is left out: its pivot is 0
        for a in range(columns_used):
            whole = small[a, a]
            for b in range(a + 1):
                rest = wp.float64(0.5) * (small[a, b] + small[b, a])
                for c in range(b):
                    rest -= small[a, c] * small[b, c]
                if b < a:
                    part = wp.float64(0.0)
                    if small[b, b] > wp.float64(0.0):
                        part = rest / small[b, b]
                    small[a, b] = part
                elif rest > margin * whole:
                    small[a, a] = wp.sqrt(rest)
                else:
                    small[a, a] = wp.float64(0.0)
            if small[a, a] == wp.float64(0.0):
                for b in range(a):
                    small[a, b] = wp.float64(0.0)

    @kernel
    def find_multipliers(
        # in
        count: wp.array(dtype=int),
        touched: wp.array(dtype=int),
        columns: wp.array2d(dtype=block),
        small: wp.array2d(dtype=wp.float64),
        motion: wp.array(dtype=vec3),
        # out
        work: wp.array(dtype=wp.float64),
        multipliers: wp.array(dtype=block),
    ):
        # (W + F^T X)^-1 F^T motion
        if count[0] == 0:
            return
        for a in range(columns_used):
            work[a] = wp.float64(0.0)
        for aggregate in range(touched.shape[0]):
            if touched[aggregate] != 0:
                for part in range(2):
                    moved = motion[2 * aggregate + part]
                    for axis in range(3):
                        force = columns[0, 6 * aggregate + 3 * part + axis]
                        for a in range(columns_used):
                            work[a] += wp.float64(force[a]) * wp.float64(moved[axis])
        for a in range(columns_used):
            for b in range(a):
                work[a] -= small[a, b] * work[b]
            scale = wp.float64(0.0)
            if small[a, a] > wp.float64(0.0):
                scale = wp.float64(1.0) / small[a, a]
            work[a] = work[a] * scale
        result = block()
        for back in range(columns_used):
            a = columns_used - 1 - back
            for b in range(a + 1, columns_used):
                work[a] -= small[b, a] * work[b]
            scale = wp.float64(0.0)
            if small[a, a] > wp.float64(0.0):
                scale = wp.float64(1.0) / small[a, a]
            work[a] = work[a] * scale
            result[a] = scalar(work[a])
        multipliers[0] = result

    @kernel
    def subtract_answers(
        # in
        count: wp.array(dtype=int),
        answers: wp.array2d(dtype=block),
        multipliers: wp.array(dtype=block),
        # out
        motion: wp.array(dtype=vec3),
    ):
        node = wp.tid()
        if count[0] == 0:
            return
        size = multipliers[0]
        given = vec3(
            wp.dot(answers[0, 3 * node], size),
            wp.dot(answers[0, 3 * node + 1], size),
            wp.dot(answers[0, 3 * node + 2], size),
        )
        motion[node] = motion[node] - given

    return SimpleNamespace(
        find_resistances=find_resistances,
        part_held_nodes=part_held_nodes,
        gather_columns=gather_columns,
        factorise_small=factorise_small,
        find_multipliers=find_multipliers,
        subtract_answers=subtract_answers,
    )
