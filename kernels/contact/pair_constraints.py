"""Velocity constraints of pairs of surfaces, inside conjugate gradients.

Row p of C takes velocities to u_p = sum_k w_k v_k over the four nodes of a pair, whose weights add
up to zero: a node (1) and the corners of a triangle, or the two ends of an edge and those of
another. u_p is the velocity of the one point relative to the other. For a sticking pair all of u_p
is given, for a sliding one n . u_p.

S is the projector of the ground's velocity constraints, and N = 1 or n n^T picks what is given of a
pair. The velocities left free are the null space of N C S, and
``P = S - S C^T N (N C S C^T N)^+ N C S`` projects onto it. The matrix in the middle is the pairs'
Delassus matrix with unit masses. Systems with it are solved by conjugate gradients of their own, in
one thread and in double precision: pairs are few beside nodes, and rows that nearly repeat each
other take most of single precision's digits. Where the velocities asked of such rows may
contradict, a little is added to its diagonal; where even that takes long, they are factorised.

A sliding pair's friction adds a stiffness D to the matrix: C^T D C.
"""

from functools import cache
from types import SimpleNamespace
from typing import Any

import warp as wp

from warp_softbody.kernels.contact.held_rows import make_held_rows
from warp_softbody.kernels.contact.modes import Mode
from warp_softbody.kernels.contact.pair_factor import make_pair_factor
from warp_softbody.kernels.contact.structs import make_pair_structs
from warp_softbody.kernels.linear.codes import VelocityConstraint
from warp_softbody.kernels.linear.structs import make_linear_structs
from warp_softbody.kernels.precision import real
from warp_softbody.kernels.widening import make_widening

SUBJECT = "pairs"

MOST_ITERATIONS = 200
"""Most iterations with the Delassus matrix; a dozen suffice."""

HARD = {"float32": 60, "float64": 120}
"""Iterations of a solve without damping that tell that rows are nearly dependent: they are
factorised, and the solves to come with these modes are exact."""

ENOUGH = {"float32": 1e-8, "float64": 1e-13}
"""Relative residual of those solves; a little less than rounding of what they project."""

DAMPING = 1e-3
"""Added to the diagonal of the Delassus matrix, whose entries lie between 1 and 2, where rows may
contradict."""


@cache
def make_pair_constraints(precision: str) -> SimpleNamespace:
    """Kernels that project nodal vectors, and functions for the other kernels of pairs."""
    types = real(precision)
    vec3, mat33 = types.vec3, types.mat33
    kernel, func = types.kernel(SUBJECT), types.func(SUBJECT)
    widening = make_widening(precision, SUBJECT)
    wide, narrow = widening.wide, widening.narrow
    most, hard = wp.constant(MOST_ITERATIONS), wp.constant(HARD[precision])
    vec3d = wp.vec3d
    enough = wp.constant(wp.float64(ENOUGH[precision] ** 2))
    damping = wp.constant(wp.float64(DAMPING))
    none = wp.constant(wp.float64(0.0))
    structs = make_pair_structs(precision)
    Pairs, DelassusWork = structs.Pairs, structs.DelassusWork
    NodeConstraints = make_linear_structs(precision).NodeConstraints

    @func
    def relative(pairs: Pairs, c: int, v: wp.array(dtype=vec3)):
        k, w = pairs.nodes[c], pairs.weights[c]
        u = vec3d()
        for a in range(4):
            u += wp.float64(w[a]) * wide(v[k[a]])
        return u

    @func
    def relative_work(pairs: Pairs, c: int, v: wp.array(dtype=vec3d)):
        k, w = pairs.nodes[c], pairs.weights[c]
        u = vec3d()
        for a in range(4):
            u += wp.float64(w[a]) * v[k[a]]
        return u

    @func
    def left_free(constraints: NodeConstraints, i: int, v: vec3d):
        # S at a node
        if constraints.kinds[i] == VelocityConstraint.NONE:
            return v
        axis = wide(constraints.axes[i])
        if constraints.kinds[i] == VelocityConstraint.PLANE:
            return v - (wp.dot(axis, v) / wp.dot(axis, axis)) * axis
        if constraints.kinds[i] == VelocityConstraint.LINE:
            return (wp.dot(axis, v) / wp.dot(axis, axis)) * axis
        return vec3d()

    @func
    def spread(
        pairs: Pairs,
        constraints: NodeConstraints,
        forces: wp.array(dtype=vec3d),
        nodal: wp.array(dtype=vec3d),
    ):
        # nodal = S C^T forces, at the nodes of the rows; few of them touch the ground as well
        for number in range(pairs.node_counts[0]):
            nodal[pairs.touched[number]] = vec3d()
        for row in range(pairs.active_count[0]):
            c = pairs.active[row]
            k, w = pairs.nodes[c], pairs.weights[c]
            for a in range(4):
                nodal[k[a]] = nodal[k[a]] + wp.float64(w[a]) * forces[row]
        for number in range(pairs.node_counts[1]):
            i = pairs.constrained[number]
            nodal[i] = left_free(constraints, i, nodal[i])

    @func
    def given(pairs: Pairs, c: int, mode: int, u: vec3d):
        if mode == Mode.STICK:
            return u
        n = wide(pairs.normals[c])
        return (wp.dot(n, u) / wp.dot(n, n)) * n

    @func
    def apply(
        pairs: Pairs,
        modes: wp.array(dtype=int),
        constraints: NodeConstraints,
        x: wp.array(dtype=vec3d),
        nodal: wp.array(dtype=vec3d),
        out: wp.array(dtype=vec3d),
    ):
        # out = N C S C^T N x, and nodal = S C^T N x; x obeys N x = x
        spread(pairs, constraints, x, nodal)
        for row in range(pairs.active_count[0]):
            c = pairs.active[row]
            out[row] = given(pairs, c, modes[c], relative_work(pairs, c, nodal))

    is_held = make_held_rows(precision, SUBJECT, left_free).is_held
    factor = make_pair_factor(precision, SUBJECT, apply)
    factorise, solve_factor = factor.factorise, factor.solve_factor

    @func
    def solve(
        pairs: Pairs,
        modes: wp.array(dtype=int),
        constraints: NodeConstraints,
        work: DelassusWork,
        added: wp.float64,
    ):
        # y of (N C S C^T N + added) y = r, and how often; r is used up; redundant rows share their
        # part
        count = pairs.active_count[0]
        square = wp.float64(0.0)
        for row in range(count):
            work.y[row] = vec3d()
            work.p[row] = work.r[row]
            square += wp.length_sq(work.r[row])
        stop = enough * square
        iteration = int(0)
        while square > stop and iteration < most:
            apply(pairs, modes, constraints, work.p, work.nodal, work.q)
            curvature = wp.float64(0.0)
            for row in range(count):
                work.q[row] = work.q[row] + added * work.p[row]
                curvature += wp.dot(work.p[row], work.q[row])
            iteration += 1
            if curvature > wp.float64(0.0):
                alpha = square / curvature
                last = square
                square = wp.float64(0.0)
                for row in range(count):
                    work.y[row] = work.y[row] + alpha * work.p[row]
                    work.r[row] = work.r[row] - alpha * work.q[row]
                    square += wp.length_sq(work.r[row])
                beta = square / last
                for row in range(count):
                    work.p[row] = work.r[row] + beta * work.p[row]
            else:
                iteration = most
        return iteration

    @func
    def multipliers(
        pairs: Pairs,
        modes: wp.array(dtype=int),
        constraints: NodeConstraints,
        work: DelassusWork,
        v: wp.array(dtype=vec3),
        added: wp.float64,
    ):
        # y of (N C S C^T N + added) y = N C v, for v = S v
        for row in range(pairs.active_count[0]):
            c = pairs.active[row]
            work.r[row] = given(pairs, c, modes[c], relative(pairs, c, v))
        if added == none and work.rank[0] >= 0:
            solve_factor(pairs, modes, work)
        elif solve(pairs, modes, constraints, work, added) >= hard and added == none:
            factorise(pairs, modes, constraints, work)
            if work.rank[0] >= 0:
                for row in range(pairs.active_count[0]):
                    c = pairs.active[row]
                    work.r[row] = given(pairs, c, modes[c], relative(pairs, c, v))
                solve_factor(pairs, modes, work)

    @func
    def remove(
        pairs: Pairs,
        constraints: NodeConstraints,
        work: DelassusWork,
        factor: wp.float64,
        v: wp.array(dtype=vec3),
    ):
        # v += factor S C^T y
        spread(pairs, constraints, work.y, work.nodal)
        for number in range(pairs.node_counts[0]):
            i = pairs.touched[number]
            v[i] = narrow(wide(v[i]) + factor * work.nodal[i])

    @func
    def stiffen(
        pairs: Pairs,
        constraints: NodeConstraints,
        work: DelassusWork,
        stiffness: wp.array(dtype=mat33),
        factor: wp.float64,
        x: wp.array(dtype=vec3),
        out: wp.array(dtype=vec3),
    ):
        # out += factor S C^T D C x; the product x^T C^T D C x
        total = wp.float64(0.0)
        for row in range(pairs.active_count[0]):
            c = pairs.active[row]
            u = narrow(relative(pairs, c, x))
            force = stiffness[c] * u
            work.y[row] = wide(force)
            total += wp.dot(wide(u), work.y[row])
        remove(pairs, constraints, work, factor, out)
        return total

    @kernel
    def list_rows(
        # in
        modes: wp.array(dtype=int),
        constraints: NodeConstraints,
        # in and out
        pairs: Pairs,
    ):
        # the pairs that hold something, their nodes, and those of them that touch the ground
        count = int(0)
        for number in range(pairs.found_count[0]):
            c = pairs.found[number]
            if modes[c] != Mode.LIFT and not is_held(pairs, c, modes[c], constraints):
                pairs.active[count] = c
                count += 1
        pairs.active_count[0] = count
        touched = int(0)
        held = int(0)
        for row in range(count):
            k = pairs.nodes[pairs.active[row]]
            for a in range(4):
                i = k[a]
                if pairs.marks[i] == 0:
                    pairs.marks[i] = 1
                    pairs.touched[touched] = i
                    touched += 1
                    if constraints.kinds[i] != VelocityConstraint.NONE:
                        pairs.constrained[held] = i
                        held += 1
        for number in range(touched):
            pairs.marks[pairs.touched[number]] = 0
        pairs.node_counts[0] = touched
        pairs.node_counts[1] = held

    @kernel
    def impose(
        # in
        pairs: Pairs,
        modes: wp.array(dtype=int),
        constraints: NodeConstraints,
        # in and out
        work: DelassusWork,
        x: wp.array(dtype=vec3),
    ):
        # the nearest x that has the relative velocities given; the second time takes off what the
        # damping left
        work.rank[0] = -1
        for _ in range(2):
            for row in range(pairs.active_count[0]):
                c = pairs.active[row]
                wanted = wide(pairs.normal_velocity[c] * pairs.normals[c])
                work.r[row] = given(pairs, c, modes[c], wanted - relative(pairs, c, x))
            solve(pairs, modes, constraints, work, damping)
            remove(pairs, constraints, work, wp.float64(1.0), x)

    @kernel
    def finish_residual(
        # in
        pairs: Pairs,
        modes: wp.array(dtype=int),
        constraints: NodeConstraints,
        stiffness: wp.array(dtype=mat33),
        x: wp.array(dtype=vec3),
        # in and out
        work: DelassusWork,
        r: wp.array(dtype=vec3),
        # out
        partial: wp.array(dtype=wp.float64),
    ):
        # r = P (b - M~ x - C^T D C x) from S (b - M~ x), and its square
        if pairs.active_count[0] > 0:
            stiffen(pairs, constraints, work, stiffness, wp.float64(-1.0), x, r)
            multipliers(pairs, modes, constraints, work, r, none)
            remove(pairs, constraints, work, wp.float64(-1.0), r)
            total = wp.float64(0.0)
            for i in range(r.shape[0]):
                total += wp.length_sq(wide(r[i]))
            for k in range(partial.shape[0]):
                partial[k] = wp.float64(0.0)
            partial[0] = total

    @kernel
    def project_pairs(
        # in
        pairs: Pairs,
        modes: wp.array(dtype=int),
        constraints: NodeConstraints,
        # in and out
        work: DelassusWork,
        v: wp.array(dtype=vec3),
    ):
        # v = P v for v = S v
        if pairs.active_count[0] > 0:
            multipliers(pairs, modes, constraints, work, v, none)
            remove(pairs, constraints, work, wp.float64(-1.0), v)

    @kernel
    def finish_product(
        # in
        pairs: Pairs,
        modes: wp.array(dtype=int),
        constraints: NodeConstraints,
        stiffness: wp.array(dtype=mat33),
        p: wp.array(dtype=vec3),
        # in and out
        work: DelassusWork,
        q: wp.array(dtype=vec3),
        partial: wp.array(dtype=wp.float64),
    ):
        # q = P (M~ + C^T D C) p from S M~ p
        if pairs.active_count[0] > 0:
            added = stiffen(pairs, constraints, work, stiffness, wp.float64(1.0), p, q)
            partial[0] = partial[0] + added
            multipliers(pairs, modes, constraints, work, q, none)
            remove(pairs, constraints, work, wp.float64(-1.0), q)

    kernels: dict[str, Any] = {
        "list_rows": list_rows,
        "impose": impose,
        "finish_residual": finish_residual,
        "project_pairs": project_pairs,
        "finish_product": finish_product,
    }
    functions = {
        "wide": wide,
        "narrow": narrow,
        "relative": relative,
        "multipliers": multipliers,
        "remove": remove,
        "stiffen": stiffen,
    }
    return SimpleNamespace(**kernels, **functions)
