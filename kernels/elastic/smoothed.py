"""Smoothed four-node tets, which hardly lock: the shear part by edges, the volume part by nodes.

The deformation gradient is averaged by volume over the tets around an edge for the shear energy
``mu |F - R|^2`` and over those around a node for the volume energy ``lambda/2 (tr(R^T F) - 3)^2``
(edge-based smoothing, Nguyen-Thoi et al. 2009; volume over nodes after Bonet and Burton 1998), each
with its own rotation R. An edge holds a sixth of the volume of its tets, a node a quarter.
As averaging can only lower an energy that is convex in the strain, the stiffness of the tets is an
upper bound of the smoothed one, and the implicit step takes it: shear turned with each tet, volume
with each of its nodes, whose rotations the volume's forces follow. (With the tet's rotation alone a
relative turn theta leaves lambda theta^2 uncovered, and crumpled bodies explode.)
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.elastic.polar_rotation import make_rotation
from warp_softbody.kernels.elastic.tet_geometry import make_tets
from warp_softbody.kernels.precision import real

SUBJECT = "smoothing"


@cache
def make_smoothing(precision: str) -> SimpleNamespace:
    """Kernels of smoothed tets, in the order of their launch."""
    types = real(precision)
    scalar, vec3, mat33 = types.scalar, types.vec3, types.mat33
    kernel = types.kernel(SUBJECT)
    plain = types.kernel(SUBJECT, "plain")
    closest_rotation = make_rotation(precision, SUBJECT).closest_rotation

    tet = make_tets(precision, SUBJECT)
    deformation, cofactor, by_corner = tet.deformation, tet.cofactor, tet.by_corner
    nearly_rotation = tet.nearly_rotation

    @kernel
    def deformation_gradients(
        # model
        tets: wp.array(dtype=wp.vec4i),
        rest_inverse: wp.array(dtype=mat33),
        rest_volume: wp.array(dtype=scalar),
        muscular: int,
        # in
        positions: wp.array(dtype=vec3),
        # out
        deformations: wp.array(dtype=mat33),
        rotations: wp.array(dtype=mat33),
        area_rows: wp.array(dtype=mat33),
    ):
        # ``rotations``: F too, which ``rotation_lanes`` may turn into rotations
        t = wp.tid()
        corners = tets[t]
        B = rest_inverse[t]
        F = deformation(corners, B, positions)
        deformations[t] = F
        rotations[t] = F
        if muscular != 0:
            area_rows[t] = rest_volume[t] * (B * wp.transpose(cofactor(F)))

    @plain
    def mean_edges(
        # model
        edge_start: wp.array(dtype=int),
        edge_corners: wp.array(dtype=wp.vec2i),
        rest_volume: wp.array(dtype=scalar),
        # in
        deformations: wp.array(dtype=mat33),
        # out
        means: wp.array(dtype=mat33),
        rotations: wp.array(dtype=mat33),
    ):
        edge = wp.tid()
        total = mat33()
        volume = scalar(0.0)
        k = edge_start[edge]
        last = edge_start[edge + 1]
        while k < last:
            t = edge_corners[k][0] / 4
            total += rest_volume[t] * deformations[t]
            volume += rest_volume[t]
            k += 1
        means[edge] = total / volume
        rotations[edge] = total / volume

    @kernel
    def stress_edges(
        # model
        lame: wp.array(dtype=scalar),
        turned: int,
        # in and out
        stresses: wp.array(dtype=mat33),
        rotations: wp.array(dtype=mat33),
    ):
        # the mean F becomes the first Piola-Kirchhoff stress 2 mu (F - R), over six; ``turned``:
        # ``rotations`` hold R already, not F
        edge = wp.tid()
        F = stresses[edge]
        R = rotations[edge]
        if turned == 0:
            R = closest_rotation(F)
            rotations[edge] = R
        stresses[edge] = (lame[0] * scalar(0.3333333333333333)) * (F - R)

    @plain
    def stress_nodes(
        # model
        node_start: wp.array(dtype=int),
        node_corners: wp.array(dtype=int),
        rest_volume: wp.array(dtype=scalar),
        lame: wp.array(dtype=scalar),
        # in
        deformations: wp.array(dtype=mat33),
        # out
        stresses: wp.array(dtype=mat33),
        rotations: wp.array(dtype=mat33),
    ):
        # first Piola-Kirchhoff stress lambda tr(eps) R of the mean F, over four
        i = wp.tid()
        total = mat33()
        volume = scalar(0.0)
        k = node_start[i]
        last = node_start[i + 1]
        while k < last:
            t = node_corners[k] / 4
            total += rest_volume[t] * deformations[t]
            volume += rest_volume[t]
            k += 1
        F = total / volume
        R = closest_rotation(F)
        stretch = wp.ddot(R, F) - scalar(3.0)
        rotations[i] = R
        stresses[i] = (scalar(0.25) * lame[1] * stretch) * R

    @plain
    def smoothed_tets(
        # model
        tets: wp.array(dtype=wp.vec4i),
        tet_edges: wp.array2d(dtype=int),
        rest_inverse: wp.array(dtype=mat33),
        rest_volume: wp.array(dtype=scalar),
        # in
        edge_stresses: wp.array(dtype=mat33),
        edge_rotations: wp.array(dtype=mat33),
        node_stresses: wp.array(dtype=mat33),
        node_rotations: wp.array(dtype=mat33),
        # out
        rotations: wp.array(dtype=mat33),
        gradients: wp.array(dtype=vec3),
        volume_gradients: wp.array(dtype=vec3),
        forces: wp.array(dtype=vec3),
    ):
        # a tet's rotation, for its muscles and its share in the matrix, is the mean of its edges'
        t = wp.tid()
        stress = mat33()
        R = mat33()
        for k in range(6):
            edge = tet_edges[t, k]
            stress += edge_stresses[edge]
            R += edge_rotations[edge]
        corners = tets[t]
        for k in range(4):
            stress += node_stresses[corners[k]]
        R = nearly_rotation(R * scalar(0.16666666666666666))
        rotations[t] = R
        B = rest_inverse[t]
        volume = rest_volume[t]
        root = wp.sqrt(volume)
        by_corner(4 * t, root * (B * wp.transpose(R)), gradients)
        for k in range(4):
            turned = (scalar(0.5) * root) * (B * wp.transpose(node_rotations[corners[k]]))
            by_corner(16 * t + 4 * k, turned, volume_gradients)
        by_corner(4 * t, (-volume) * (B * wp.transpose(stress)), forces)

    @plain
    def smoothed_edges(
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
        # K_ab = V0 (lambda / 4 sum_n Gna Gnb^T + mu Gb Ga^T + mu Ga.Gb I), Gn = R_n g
        edge = wp.tid()
        outer = mat33()
        volume = mat33()
        k = edge_start[edge]
        last = edge_start[edge + 1]
        while k < last:
            corners = edge_corners[k]
            outer += wp.outer(gradients[corners[0]], gradients[corners[1]])
            t = corners[0] / 4
            first = 12 * t + corners[0]
            second = 12 * t + corners[1]
            for node in range(4):
                volume += wp.outer(
                    volume_gradients[first + 4 * node], volume_gradients[second + 4 * node]
                )
            k += 1
        along = wp.trace(outer) * wp.identity(n=3, dtype=scalar)
        shear = (step_factors[1] * lame[0]) * (wp.transpose(outer) + along)
        block = (step_factors[1] * lame[1]) * volume + shear
        slots = edge_slots[edge]
        values[slots[0]] = block
        values[slots[1]] = wp.transpose(block)

    return SimpleNamespace(
        deformation_gradients=deformation_gradients,
        mean_edges=mean_edges,
        stress_edges=stress_edges,
        stress_nodes=stress_nodes,
        smoothed_tets=smoothed_tets,
        smoothed_edges=smoothed_edges,
    )
