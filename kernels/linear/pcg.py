"""Preconditioned conjugate gradients, one right-hand side, on the velocities contact leaves free.

``M~ v+ = M v + b``, with b the impulses of given forces; the unknown is the change v+ - v, in
place, so that rounding is that of the change, not of the velocity. Each node is free, slides on a
plane (its normal velocity is given) or on a line (two components are given), or is held; the
operator is S (M~ + G) S with S the projector onto the free velocities and G the slip stiffness, a
3 x 3 block for each sliding node. Sums run over fixed chunks of nodes in a fixed order, in double
precision, so a run repeats bit for bit.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.linear.bsr_product import make_rows
from warp_softbody.kernels.linear.codes import Scalar, VelocityConstraint
from warp_softbody.kernels.linear.stopping import SUBJECT, make_stopping
from warp_softbody.kernels.linear.structs import make_linear_structs
from warp_softbody.kernels.precision import real


@cache
def make_conjugate_gradients(precision: str) -> SimpleNamespace:
    """Kernels of the iteration; ``warp_softbody.linear.pcg`` puts them in order."""
    types = real(precision)
    scalar, vec3, mat33 = types.scalar, types.vec3, types.mat33
    kernel, func = types.kernel(SUBJECT), types.func(SUBJECT)
    plain = types.kernel(SUBJECT, "plain")
    structs = make_linear_structs(precision)
    NodeConstraints, ResidualSums = structs.NodeConstraints, structs.ResidualSums
    stopping = make_stopping(precision)
    double_dot, total_of = stopping.double_dot, stopping.total_of

    @func
    def project(kind: int, axis: vec3, value: vec3):
        # the axis is normal to the plane of a node that slides, or lies along its line
        if kind == VelocityConstraint.NONE:
            return value
        if kind == VelocityConstraint.PLANE:
            return value - wp.dot(axis, value) * axis
        if kind == VelocityConstraint.LINE:
            return wp.dot(axis, value) * axis
        return vec3()

    stiffness_of_sum = make_rows(precision, SUBJECT).stiffness_of_sum

    @func
    def momentum_change(
        i: int,
        row_start: wp.array(dtype=int),
        column: wp.array(dtype=int),
        masses: wp.array(dtype=scalar),
        damped_masses: wp.array(dtype=scalar),
        values: wp.array(dtype=mat33),
        before: wp.array(dtype=vec3),
        change: wp.array(dtype=vec3),
    ):
        # M~ v+ - M v at a node, what its forces have to bring about, for v+ = before + change. M v+
        # and M v are never formed: beside them, what a small step changes is rounding.
        inertia = damped_masses[i] * change[i] + (damped_masses[i] - masses[i]) * before[i]
        return inertia + stiffness_of_sum(i, row_start, column, values, before, change)

    @func
    def moved_square(mass: scalar, start: vec3, now: vec3):
        moved = mass * (now - start)
        return double_dot(moved, moved)

    @plain
    def filtered_product(
        # model
        chunk: int,
        # in
        constraints: NodeConstraints,
        r: wp.array(dtype=vec3),
        # out
        z: wp.array(dtype=vec3),
        partial: wp.array(dtype=wp.float64),
    ):
        c = wp.tid()
        total = wp.float64(0.0)
        for i in range(c * chunk, wp.min((c + 1) * chunk, r.shape[0])):
            value = project(constraints.kinds[i], constraints.axes[i], z[i])
            z[i] = value
            total += double_dot(r[i], value)
        partial[c] = total

    @kernel
    def add_up(
        # model
        index: int,
        # in
        partial: wp.array(dtype=wp.float64),
        # out
        scalars: wp.array(dtype=wp.float64),
    ):
        # once, for every chunk that needs the sum
        scalars[index] = total_of(partial)

    @kernel
    def add_up_curvature(
        # in
        partial: wp.array(dtype=wp.float64),
        mass_partial: wp.array(dtype=wp.float64),
        # out
        scalars: wp.array(dtype=wp.float64),
    ):
        # stiffness is never less than none, but for rounding, whose steps would have no bound
        stiff = wp.max(total_of(partial), wp.float64(0.0))
        scalars[Scalar.CURVATURE] = total_of(mass_partial) + stiff

    @plain
    def direction(
        # model
        chunk: int,
        # in
        scalars: wp.array(dtype=wp.float64),
        z: wp.array(dtype=vec3),
        # out
        p: wp.array(dtype=vec3),
    ):
        # the old product is kept until ``advance`` of this iteration has used the new one
        c = wp.tid()
        old = scalars[Scalar.RESIDUAL_PRODUCT]
        beta = scalar(0.0)
        if old > wp.float64(0.0):
            beta = scalar(scalars[Scalar.NEW_PRODUCT] / old)
        for i in range(c * chunk, wp.min((c + 1) * chunk, z.shape[0])):
            p[i] = z[i] + beta * p[i]

    @plain
    def advance(
        # model
        chunk: int,
        follows: int,
        masses: wp.array(dtype=scalar),
        # in
        scalars: wp.array(dtype=wp.float64),
        p: wp.array(dtype=vec3),
        q: wp.array(dtype=vec3),
        start: wp.array(dtype=vec3),
        # out
        change: wp.array(dtype=vec3),
        r: wp.array(dtype=vec3),
        sums: ResidualSums,
    ):
        c = wp.tid()
        net = wp.vec3d()
        moved = wp.float64(0.0)
        curvature = scalars[Scalar.CURVATURE]
        alpha = scalar(0.0)
        if curvature > wp.float64(0.0):
            alpha = scalar(scalars[Scalar.NEW_PRODUCT] / curvature)
        total = wp.float64(0.0)
        for i in range(c * chunk, wp.min((c + 1) * chunk, change.shape[0])):
            change[i] = change[i] + alpha * p[i]
            value = r[i] - alpha * q[i]
            r[i] = value
            total += double_dot(value, value)
            if follows != 0:
                moved += moved_square(masses[i], start[i], change[i])
                net += wp.vec3d(wp.float64(value[0]), wp.float64(value[1]), wp.float64(value[2]))
        sums.squares[c] = total
        sums.moved[c] = moved
        sums.net[c] = net

    return SimpleNamespace(
        filtered_product=filtered_product,
        add_up=add_up,
        add_up_curvature=add_up_curvature,
        direction=direction,
        advance=advance,
        moved_square=moved_square,
        momentum_change=momentum_change,
        project=project,
    )


@cache
def make_products(precision: str) -> SimpleNamespace:
    """Kernels ``residual`` and ``product``; ``product_lanes`` has the same in native code."""
    types = real(precision)
    vec3, mat33 = types.vec3, types.mat33
    plain = types.kernel(SUBJECT, "plain")
    double_dot = make_stopping(precision).double_dot
    iteration = make_conjugate_gradients(precision)
    project, moved_square = iteration.project, iteration.moved_square
    row_products = make_rows(precision, SUBJECT)
    stiffness_of_row = row_products.stiffness_of_row
    stiffness_of_sum = row_products.stiffness_of_sum
    structs = make_linear_structs(precision)
    MatrixRows, ResidualSums = structs.MatrixRows, structs.ResidualSums
    NodeConstraints = structs.NodeConstraints

    @plain
    def residual(
        # model
        chunk: int,
        follows: int,
        rows: MatrixRows,
        # in
        values: wp.array(dtype=mat33),
        constraints: NodeConstraints,
        slip_stiffness: wp.array(dtype=mat33),
        right_side: wp.array(dtype=vec3),
        before: wp.array(dtype=vec3),
        start: wp.array(dtype=vec3),
        change: wp.array(dtype=vec3),
        # out
        r: wp.array(dtype=vec3),
        sums: ResidualSums,
    ):
        c = wp.tid()
        net = wp.vec3d()
        total = wp.float64(0.0)
        moved = wp.float64(0.0)
        for i in range(c * chunk, wp.min((c + 1) * chunk, change.shape[0])):
            mass = rows.masses[i]
            damped = rows.damped_masses[i]
            inertia = damped * change[i] + (damped - mass) * before[i]
            stiff = stiffness_of_sum(i, rows.row_start, rows.column, values, before, change)
            value = right_side[i] - (inertia + stiff)
            value -= slip_stiffness[i] * (before[i] + change[i])
            value = project(constraints.kinds[i], constraints.axes[i], value)
            r[i] = value
            total += double_dot(value, value)
            moved += moved_square(mass, start[i], change[i])
            if follows != 0:
                net += wp.vec3d(wp.float64(value[0]), wp.float64(value[1]), wp.float64(value[2]))
        sums.squares[c] = total
        sums.moved[c] = moved
        sums.net[c] = net

    @plain
    def product(
        # model
        chunk: int,
        rows: MatrixRows,
        # in
        values: wp.array(dtype=mat33),
        constraints: NodeConstraints,
        slip_stiffness: wp.array(dtype=mat33),
        p: wp.array(dtype=vec3),
        # out
        q: wp.array(dtype=vec3),
        partial: wp.array(dtype=wp.float64),
        mass_partial: wp.array(dtype=wp.float64),
    ):
        c = wp.tid()
        total = wp.float64(0.0)
        inertia = wp.float64(0.0)
        for i in range(c * chunk, wp.min((c + 1) * chunk, p.shape[0])):
            own = rows.damped_masses[i] * p[i]
            stiff = stiffness_of_row(i, rows.row_start, rows.column, values, p)
            stiff += slip_stiffness[i] * p[i]
            q[i] = project(constraints.kinds[i], constraints.axes[i], own + stiff)
            total += double_dot(p[i], stiff)
            inertia += double_dot(p[i], own)
        partial[c] = total
        mass_partial[c] = inertia

    return SimpleNamespace(residual=residual, product=product)
