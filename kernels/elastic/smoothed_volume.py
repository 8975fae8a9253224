"""Smoothed tets that resist their exact change of volume, by node (docs/method.md section 1).

The shear part is that of ``kernels/elastic/smoothed.py``. The volume part is ``lambda/2 (J - 1)^2``
with J the volume of the tets around a node over that at rest (average nodal pressure, Bonet and
Burton 1998), so a tet bears the mean pressure of its nodes on its deformed faces. By Jensen's
inequality the tets' own Gauss-Newton term, ``lambda c c^T`` with ``c = cof F g``, bounds the
nodes' from above in every shape, turned or not; the step takes it, as the nodes' own would couple
nodes that share no tet.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.elastic.polar_rotation import make_rotation
from warp_softbody.kernels.elastic.tet_geometry import make_tets
from warp_softbody.kernels.precision import real

SUBJECT = "smoothed_volume"


@cache
def make_smoothed_volume(precision: str) -> SimpleNamespace:
    """Struct ``SmoothedState``; kernels ``press_nodes`` and ``smoothed_tets``."""
    types = real(precision)
    scalar, vec3, mat33 = types.scalar, types.vec3, types.mat33
    kernel = types.kernel(SUBJECT)
    closest_rotation = make_rotation(precision, SUBJECT).closest_rotation
    tet = make_tets(precision, SUBJECT)
    cofactor, by_corner, nearly_rotation = tet.cofactor, tet.by_corner, tet.nearly_rotation

    @wp.struct
    class SmoothedState:
        """F (m,) of tets, stresses and rotations (e,) of edges, pressures (n,) of nodes."""

        deformations: wp.array(dtype=mat33)
        stresses: wp.array(dtype=mat33)
        rotations: wp.array(dtype=mat33)
        pressures: wp.array(dtype=scalar)

    @kernel
    def press_nodes(
        # model
        node_start: wp.array(dtype=int),
        node_corners: wp.array(dtype=int),
        rest_volume: wp.array(dtype=scalar),
        lame: wp.array(dtype=scalar),
        turned: int,
        # in
        deformations: wp.array(dtype=mat33),
        # out
        pressures: wp.array(dtype=scalar),
        rotations: wp.array(dtype=mat33),
    ):
        # lambda (J - 1) over four; det F - 1 is summed, so that at rest nothing is rounded;
        # ``turned``: ``rotation_lanes`` make rotations out of the mean F
        i = wp.tid()
        total = mat33()
        volume = scalar(0.0)
        swelling = scalar(0.0)
        for k in range(node_start[i], node_start[i + 1]):
            t = node_corners[k] / 4
            F = deformations[t]
            total += rest_volume[t] * F
            volume += rest_volume[t]
            swelling += rest_volume[t] * (wp.determinant(F) - scalar(1.0))
        R = total / volume
        if turned == 0:
            R = closest_rotation(R)
        rotations[i] = R
        pressures[i] = (scalar(0.25) * lame[1]) * (swelling / volume)

    @kernel
    def smoothed_tets(
        # model
        tets: wp.array(dtype=wp.vec4i),
        tet_edges: wp.array2d(dtype=int),
        rest_inverse: wp.array(dtype=mat33),
        rest_volume: wp.array(dtype=scalar),
        own_rotations: int,
        turned: int,
        first: int,
        # in
        now: SmoothedState,
        # in and out
        rotations: wp.array(dtype=mat33),
        # out
        gradients: wp.array(dtype=vec3),
        volume_gradients: wp.array(dtype=vec3),
        forces: wp.array(dtype=vec3),
    ):
        # ``own_rotations``: of the tet's F, which the conserving tangent needs; else their edges'.
        # ``turned``: ``rotations`` hold these already; ``first``: of these tets among all
        t = wp.tid()
        corners = tets[t]
        F = now.deformations[first + t]
        stress = mat33()
        turn = mat33()
        for k in range(6):
            edge = tet_edges[t, k]
            stress += now.stresses[edge]
            turn += now.rotations[edge]
        pressure = scalar(0.0)
        for k in range(4):
            pressure += now.pressures[corners[k]]
        R = rotations[t]
        if own_rotations == 0:
            R = nearly_rotation(turn * scalar(0.16666666666666666))
        elif turned == 0:
            R = closest_rotation(F)
        rotations[t] = R
        B = rest_inverse[t]
        volume = rest_volume[t]
        root = wp.sqrt(volume)
        by_corner(4 * t, root * (B * wp.transpose(R)), gradients)
        areas = B * wp.transpose(cofactor(F))
        by_corner(4 * t, root * areas, volume_gradients)
        by_corner(4 * t, (-volume) * (B * wp.transpose(stress) + pressure * areas), forces)

    return SimpleNamespace(
        SmoothedState=SmoothedState, press_nodes=press_nodes, smoothed_tets=smoothed_tets
    )
