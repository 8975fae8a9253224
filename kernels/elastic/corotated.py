"""Corotational linear elasticity of four-node tets (docs/method.md section 1).

Per tet: deformation gradient F = Ds Dm^-1, rotation R = closest_rotation(F), S = R^T F, strain
eps = sym(S) - I, first Piola-Kirchhoff stress P = R (2 mu eps + lambda tr(eps) I), nodal forces -V0
P g_a with g_a the rest gradients of the shape functions. What belongs to a corner of a tet stands
at slot 4 t + corner; corner 0 is minus the sum of the others, so the net force is zero by
construction. ``tet_lanes``, ``edge_lanes`` and ``node_lanes`` have the same in native code.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.elastic.polar_rotation import make_rotation
from warp_softbody.kernels.elastic.tet_geometry import make_tets
from warp_softbody.kernels.precision import real

SUBJECT = "elasticity"


@cache
def make_elasticity(precision: str) -> SimpleNamespace:
    """Function ``deform_tet``, and the kernels of a precision in the order of their launch."""
    types = real(precision)
    scalar, vec3, mat33 = types.scalar, types.vec3, types.mat33
    kernel, func = types.kernel(SUBJECT), types.func(SUBJECT)
    closest_rotation = make_rotation(precision, SUBJECT).closest_rotation

    tet = make_tets(precision, SUBJECT)
    deformation, cofactor, by_corner = tet.deformation, tet.cofactor, tet.by_corner
    isotropic_block = tet.isotropic_block

    @func
    def deform_tet(
        t: int,
        tets: wp.array(dtype=wp.vec4i),
        rest_inverse: wp.array(dtype=mat33),
        rest_volume: wp.array(dtype=scalar),
        lame: wp.array(dtype=scalar),
        muscular: int,
        positions: wp.array(dtype=vec3),
        rotations: wp.array(dtype=mat33),
        gradients: wp.array(dtype=vec3),
        area_rows: wp.array(dtype=mat33),
        forces: wp.array(dtype=vec3),
    ):
        B = rest_inverse[t]
        F = deformation(tets[t], B, positions)
        R = closest_rotation(F)
        Rt = wp.transpose(R)
        volume = rest_volume[t]
        rotations[t] = R
        by_corner(4 * t, wp.sqrt(volume) * (B * Rt), gradients)
        S = Rt * F
        identity = wp.identity(n=3, dtype=scalar)
        strain = scalar(0.5) * (S + wp.transpose(S)) - identity
        stress = scalar(2.0) * lame[0] * strain + (lame[1] * wp.trace(strain)) * identity
        by_corner(4 * t, (-volume) * (B * (stress * Rt)), forces)
        if muscular != 0:
            # rows: V0 cof(F) g_a, minus a third of the deformed, area-weighted outward normal
            # opposite to corner a
            area_rows[t] = volume * (B * wp.transpose(cofactor(F)))

    @kernel
    def deform_tets(
        # model
        tets: wp.array(dtype=wp.vec4i),
        rest_inverse: wp.array(dtype=mat33),
        rest_volume: wp.array(dtype=scalar),
        lame: wp.array(dtype=scalar),
        muscular: int,
        # in
        positions: wp.array(dtype=vec3),
        # out
        rotations: wp.array(dtype=mat33),
        gradients: wp.array(dtype=vec3),
        area_rows: wp.array(dtype=mat33),
        forces: wp.array(dtype=vec3),
    ):
        # area rows serve muscles alone
        # fmt: off
        deform_tet(
            wp.tid(), tets, rest_inverse, rest_volume, lame, muscular, positions, rotations,
            gradients, area_rows, forces,
        )
        # fmt: on

    @kernel
    def stiffness_edges(
        # model
        edge_start: wp.array(dtype=int),
        edge_corners: wp.array(dtype=wp.vec2i),
        edge_slots: wp.array(dtype=wp.vec2i),
        lame: wp.array(dtype=scalar),
        step_factors: wp.array(dtype=scalar),
        # in
        gradients: wp.array(dtype=vec3),
        # out
        values: wp.array(dtype=mat33),
    ):
        # K_ab = V0 (lambda Ga Gb^T + mu Gb Ga^T + mu Ga.Gb I), G = R g; G comes times sqrt(V0)
        edge = wp.tid()
        outer = mat33()
        for k in range(edge_start[edge], edge_start[edge + 1]):
            corners = edge_corners[k]
            outer += wp.outer(gradients[corners[0]], gradients[corners[1]])
        block = isotropic_block(outer, step_factors[1] * lame[0], step_factors[1] * lame[1])
        slots = edge_slots[edge]
        values[slots[0]] = block
        values[slots[1]] = wp.transpose(block)

    @kernel
    def rotate_nodes(
        # model
        node_start: wp.array(dtype=int),
        node_corners: wp.array(dtype=int),
        rest_volume: wp.array(dtype=scalar),
        # in
        rotations: wp.array(dtype=mat33),
        # out
        node_rotations: wp.array(dtype=mat33),
    ):
        # closest to the mean of the tets around a node
        i = wp.tid()
        turn = mat33()
        for k in range(node_start[i], node_start[i + 1]):
            t = node_corners[k] / 4
            turn += rest_volume[t] * rotations[t]
        node_rotations[i] = closest_rotation(turn)

    @kernel
    def finish_nodes(
        # model
        node_start: wp.array(dtype=int),
        node_corners: wp.array(dtype=int),
        row_start: wp.array(dtype=int),
        diagonal_slot: wp.array(dtype=int),
        mass: wp.array(dtype=scalar),
        gravity: wp.array(dtype=vec3),
        step_factors: wp.array(dtype=scalar),
        # in
        velocities: wp.array(dtype=vec3),
        forces: wp.array(dtype=vec3),
        # out
        values: wp.array(dtype=mat33),
        impulses: wp.array(dtype=vec3),
        momentum: wp.array(dtype=vec3),
    ):
        # diagonal block: rigid translations are in the null space of K, so its rows sum to the mass
        # term
        i = wp.tid()
        slot = diagonal_slot[i]
        others = mat33()
        for k in range(row_start[i], row_start[i + 1]):
            if k != slot:
                others += values[k]
        block = (mass[i] * step_factors[2]) * wp.identity(n=3, dtype=scalar) - others
        values[slot] = scalar(0.5) * (block + wp.transpose(block))
        force = mass[i] * gravity[0]
        for k in range(node_start[i], node_start[i + 1]):
            force += forces[node_corners[k]]
        # what the step would do without muscles, pushes and contact: M v + dt (f_x + f_e)
        impulse = step_factors[0] * force
        impulses[i] = impulse
        momentum[i] = mass[i] * velocities[i] + impulse

    return SimpleNamespace(
        deform_tet=deform_tet,
        deform_tets=deform_tets,
        stiffness_edges=stiffness_edges,
        rotate_nodes=rotate_nodes,
        finish_nodes=finish_nodes,
    )
