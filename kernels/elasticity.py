"""Corotational linear elasticity of four-node tets (METHOD section 1).

Per tet: deformation gradient F = Ds Dm^-1, rotation R = closest_rotation(F), S = R^T F, strain
eps = sym(S) - I, first Piola-Kirchhoff stress P = R (2 mu eps + lambda tr(eps) I), nodal forces -V0
P g_a with g_a the rest gradients of the shape functions. Rows of the 3 x 3 matrices kept per tet
belong to corners 1..3; corner 0 is minus their sum, so the net force is zero by construction.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.precision import real
from warp_softbody.kernels.rotation import make_rotation

SUBJECT = "elasticity"


@cache
def make_elasticity(precision: str) -> SimpleNamespace:
    """Kernels ``deform_tets``, ``stiffness_edges``, ``finish_nodes`` of a precision."""
    types = real(precision)
    scalar, vec3, mat33 = types.scalar, types.vec3, types.mat33
    kernel, func = types.kernel(SUBJECT), types.func(SUBJECT)
    rotation = make_rotation(precision, SUBJECT)
    closest_rotation, cofactor = rotation.closest_rotation, rotation.cofactor

    @func
    def gradient_row(G: mat33, corner: int):
        if corner == 0:
            return vec3(
                -(G[0, 0] + G[1, 0] + G[2, 0]),
                -(G[0, 1] + G[1, 1] + G[2, 1]),
                -(G[0, 2] + G[1, 2] + G[2, 2]),
            )
        return vec3(G[corner - 1, 0], G[corner - 1, 1], G[corner - 1, 2])

    @kernel
    def deform_tets(
        # model
        tets: wp.array(dtype=wp.vec4i),
        rest_inverse: wp.array(dtype=mat33),
        rest_volume: wp.array(dtype=scalar),
        lame: wp.array(dtype=scalar),
        # in
        positions: wp.array(dtype=vec3),
        # out
        rotations: wp.array(dtype=mat33),
        gradients: wp.array(dtype=mat33),
        area_rows: wp.array(dtype=mat33),
        forces: wp.array(dtype=mat33),
    ):
        t = wp.tid()
        corners = tets[t]
        x0 = positions[corners[0]]
        Ds = wp.matrix_from_cols(
            positions[corners[1]] - x0, positions[corners[2]] - x0, positions[corners[3]] - x0
        )
        B = rest_inverse[t]
        F = Ds * B
        R = closest_rotation(F)
        Rt = wp.transpose(R)
        S = Rt * F
        identity = wp.identity(n=3, dtype=scalar)
        strain = scalar(0.5) * (S + wp.transpose(S)) - identity
        stress = scalar(2.0) * lame[0] * strain + (lame[1] * wp.trace(strain)) * identity
        volume = rest_volume[t]
        rotations[t] = R
        gradients[t] = B * Rt
        forces[t] = (-volume) * (B * (stress * Rt))
        # rows: V0 cof(F) g_a, minus a third of the deformed, area-weighted outward normal opposite
        # to corner a
        area_rows[t] = volume * (B * wp.transpose(cofactor(F)))

    @kernel
    def stiffness_edges(
        # model
        edge_start: wp.array(dtype=int),
        edge_tet: wp.array(dtype=int),
        edge_corners: wp.array(dtype=wp.vec2i),
        edge_slots: wp.array(dtype=wp.vec2i),
        rest_volume: wp.array(dtype=scalar),
        lame: wp.array(dtype=scalar),
        step_factors: wp.array(dtype=scalar),
        # in
        gradients: wp.array(dtype=mat33),
        # out
        values: wp.array(dtype=mat33),
    ):
        # K_ab = V0 (lambda Ga Gb^T + mu Gb Ga^T + mu Ga.Gb I) with rotated gradients G = R g
        edge = wp.tid()
        block = mat33()
        for k in range(edge_start[edge], edge_start[edge + 1]):
            t = edge_tet[k]
            corners = edge_corners[k]
            G = gradients[t]
            a = gradient_row(G, corners[0])
            b = gradient_row(G, corners[1])
            volume = rest_volume[t]
            shear = lame[0] * volume
            block += (lame[1] * volume) * wp.outer(a, b) + shear * wp.outer(b, a)
            along = shear * wp.dot(a, b)
            block[0, 0] = block[0, 0] + along
            block[1, 1] = block[1, 1] + along
            block[2, 2] = block[2, 2] + along
        block = step_factors[1] * block
        slots = edge_slots[edge]
        values[slots[0]] = block
        values[slots[1]] = wp.transpose(block)

    @kernel
    def finish_nodes(
        # model
        node_start: wp.array(dtype=int),
        node_tet: wp.array(dtype=int),
        node_corner: wp.array(dtype=int),
        row_start: wp.array(dtype=int),
        diagonal_slot: wp.array(dtype=int),
        mass: wp.array(dtype=scalar),
        rest_volume: wp.array(dtype=scalar),
        gravity: wp.array(dtype=vec3),
        step_factors: wp.array(dtype=scalar),
        # in
        velocities: wp.array(dtype=vec3),
        rotations: wp.array(dtype=mat33),
        forces: wp.array(dtype=mat33),
        # out
        values: wp.array(dtype=mat33),
        node_rotations: wp.array(dtype=mat33),
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
        turn = mat33()
        for k in range(node_start[i], node_start[i + 1]):
            t = node_tet[k]
            force += gradient_row(forces[t], node_corner[k])
            turn += rest_volume[t] * rotations[t]
        node_rotations[i] = closest_rotation(turn)
        # what the step would do without muscles, pushes and contact: M v + dt (f_x + f_e)
        momentum[i] = mass[i] * velocities[i] + step_factors[0] * force

    return SimpleNamespace(
        deform_tets=deform_tets, stiffness_edges=stiffness_edges, finish_nodes=finish_nodes
    )
