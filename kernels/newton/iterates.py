"""Iterates of Newton's method: what each leaves of the step's equations, and ways between two.

An iterate is a change of the velocities with the impulses of contact that go with it. It is judged
by r, the impulses that its velocities need beside all that acts on them, in the norm of the masses:
``sum |r_i|^2 / (2 m_i)``, J, the kinetic energy of what is not accounted for. Both parts of an
iterate move together, so that momentum stays in balance.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.contact.structs import make_contact_structs
from warp_softbody.kernels.linear.pcg import make_conjugate_gradients
from warp_softbody.kernels.linear.stopping import make_stopping
from warp_softbody.kernels.linear.structs import make_linear_structs
from warp_softbody.kernels.precision import EPSILON, real

SUBJECT = "newton_iterates"


@cache
def make_newton_iterates(precision: str) -> SimpleNamespace:
    """Kernels that measure an iterate, halve the way to it, and mend what a solve left behind."""
    types = real(precision)
    scalar, vec3, mat33 = types.scalar, types.vec3, types.mat33
    kernel = types.kernel(SUBJECT)
    MatrixRows = make_linear_structs(precision).MatrixRows
    VelocityUpdate = make_contact_structs(precision).VelocityUpdate
    momentum_change = make_conjugate_gradients(precision).momentum_change
    double_dot = make_stopping(precision).double_dot
    # the rounding of a position moves forces, by what it would cost to move the node alone
    rounding = wp.constant(scalar(4.0 * EPSILON[precision]))
    half = wp.constant(scalar(0.5))

    @kernel
    def add_impulses(
        # model
        surface_nodes: wp.array(dtype=int),
        # in
        impulses: wp.array(dtype=vec3),
        # in and out
        known: wp.array(dtype=vec3),
    ):
        c = wp.tid()
        i = surface_nodes[c]
        known[i] = known[i] + impulses[c]

    @kernel
    def add_pushes(
        # in
        pushes: wp.array(dtype=vec3),
        # in and out
        known: wp.array(dtype=vec3),
    ):
        i = wp.tid()
        known[i] = known[i] + pushes[i]

    @kernel
    def measure(
        # model
        chunk: int,
        rows: MatrixRows,
        step_factors: wp.array(dtype=scalar),
        # in
        held: wp.array(dtype=int),
        values: wp.array(dtype=mat33),
        known: wp.array(dtype=vec3),
        moved: VelocityUpdate,
        positions: wp.array(dtype=vec3),
        # out
        merits: wp.array(dtype=wp.float64),
        roundings: wp.array(dtype=wp.float64),
    ):
        c = wp.tid()
        merit = wp.float64(0.0)
        rounded = wp.float64(0.0)
        for i in range(c * chunk, wp.min((c + 1) * chunk, known.shape[0])):
            if held[i] == 0:
                share = wp.float64(0.5) / wp.float64(rows.masses[i])
                r = known[i] - momentum_change(
                    i,
                    rows.row_start,
                    rows.column,
                    rows.masses,
                    rows.damped_masses,
                    values,
                    moved.before,
                    moved.change,
                )
                merit += share * double_dot(r, r)
                weight = wp.trace(values[rows.diagonal_slot[i]]) / scalar(3.0)
                lost = (rounding * weight / step_factors[0]) * positions[i]
                rounded += share * double_dot(lost, lost)
        merits[c] = merit
        roundings[c] = rounded

    @kernel
    def mend(
        # in and out
        vectors: wp.array(dtype=vec3),
        matrices: wp.array(dtype=mat33),
    ):
        # of a solve that went astray nothing may be left that is no number
        i = wp.tid()
        if not wp.isfinite(wp.length_sq(vectors[i])):
            vectors[i] = vec3()
        if not wp.isfinite(wp.ddot(matrices[i], matrices[i])):
            matrices[i] = mat33()

    @kernel
    def mend_carry(
        # in and out
        carry: wp.array(dtype=wp.vec3d),
    ):
        i = wp.tid()
        if not wp.isfinite(wp.length_sq(carry[i])):
            carry[i] = wp.vec3d()

    @kernel
    def halve(
        # in
        base: wp.array(dtype=vec3),
        # in and out
        values: wp.array(dtype=vec3),
    ):
        i = wp.tid()
        values[i] = half * (base[i] + values[i])

    return SimpleNamespace(
        add_impulses=add_impulses,
        add_pushes=add_pushes,
        measure=measure,
        mend=mend,
        mend_carry=mend_carry,
        halve=halve,
    )
