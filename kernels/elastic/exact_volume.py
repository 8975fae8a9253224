"""Corotational elasticity whose volumetric part sees the volume itself (docs/method.md section 1).

Per tet: energy density mu |F - R|^2 + lambda / 2 (det F - 1)^2 (Stomakhin et al. 2012), so
``P = 2 mu (F - R) + lambda (det F - 1) cof F``. The trace of the strain, which corotational linear
elasticity takes for it, is the change of volume to first order only: a body squashed to half its
height with no trace has lost a fifth of its volume. In the matrix the volumetric part is its
Gauss-Newton term, lambda cof F g (cof F g)^T.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.elastic.polar_rotation import make_rotation
from warp_softbody.kernels.elastic.tet_geometry import make_tets
from warp_softbody.kernels.precision import real

SUBJECT = "exact_volume"


@cache
def make_exact_volume(precision: str) -> SimpleNamespace:
    """``deform_tet``, ``deform_tets`` and ``stiffness_edges`` in place of linear elasticity's."""
    types = real(precision)
    scalar, vec3, mat33 = types.scalar, types.vec3, types.mat33
    kernel, func = types.kernel(SUBJECT), types.func(SUBJECT)
    closest_rotation = make_rotation(precision, SUBJECT).closest_rotation
    tet = make_tets(precision, SUBJECT)
    deformation, cofactor, by_corner = tet.deformation, tet.cofactor, tet.by_corner

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
        volume_gradients: wp.array(dtype=vec3),
    ):
        B = rest_inverse[t]
        F = deformation(tets[t], B, positions)
        R = closest_rotation(F)
        volume = rest_volume[t]
        root = wp.sqrt(volume)
        rotations[t] = R
        by_corner(4 * t, root * (B * wp.transpose(R)), gradients)
        areas = B * wp.transpose(cofactor(F))
        by_corner(4 * t, root * areas, volume_gradients)
        swelling = lame[1] * (wp.determinant(F) - scalar(1.0))
        shear = B * wp.transpose(F - R)
        by_corner(4 * t, (-volume) * (scalar(2.0) * lame[0] * shear + swelling * areas), forces)
        if muscular != 0:
            area_rows[t] = volume * areas

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
        volume_gradients: wp.array(dtype=vec3),
    ):
        # fmt: off
        deform_tet(
            wp.tid(), tets, rest_inverse, rest_volume, lame, muscular, positions, rotations,
            gradients, area_rows, forces, volume_gradients,
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
        volume_gradients: wp.array(dtype=vec3),
        # out
        values: wp.array(dtype=mat33),
    ):
        # K_ab = V0 (lambda Ca Cb^T + mu Gb Ga^T + mu Ga.Gb I), C = cof(F) g, G = R g
        edge = wp.tid()
        outer = mat33()
        volume = mat33()
        for k in range(edge_start[edge], edge_start[edge + 1]):
            c = edge_corners[k]
            outer += wp.outer(gradients[c[0]], gradients[c[1]])
            volume += wp.outer(volume_gradients[c[0]], volume_gradients[c[1]])
        along = wp.trace(outer) * wp.identity(n=3, dtype=scalar)
        shear = (step_factors[1] * lame[0]) * (wp.transpose(outer) + along)
        block = (step_factors[1] * lame[1]) * volume + shear
        slots = edge_slots[edge]
        values[slots[0]] = block
        values[slots[1]] = wp.transpose(block)

    return SimpleNamespace(
        deform_tet=deform_tet, deform_tets=deform_tets, stiffness_edges=stiffness_edges
    )
