"""Muscle segments: lengths, tensions, forces on the tets, and the transposed map A.

Segment j feels the tension stress T_j = (S / l_0) max(0, l - l_d); tet t carries the rest-frame
stress sum_j w_tj T_j d_j d_j^T, turned by its rotation, and its corners feel -sigma V0 cof(F) g_a:
stress times the area-weighted deformed normals, each face shared by its three nodes. sigma is
symmetric, so a tet feels no torque.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.precision import real

SUBJECT = "muscles"


@cache
def make_muscles(precision: str) -> SimpleNamespace:
    """Kernels from fibre points to forces, and back from responses to the activations."""
    types = real(precision)
    scalar, vec3, mat33, block = types.scalar, types.vec3, types.mat33, types.block
    kernel, func = types.kernel(SUBJECT), types.func(SUBJECT)

    @func
    def row(matrix: mat33, i: int):
        return vec3(matrix[i, 0], matrix[i, 1], matrix[i, 2])

    @types.kernel(SUBJECT, "fibers")
    def fiber_points(
        # model
        point_nodes: wp.array(dtype=wp.vec4i),
        point_weights: wp.array(dtype=types.vec4),
        # in
        positions: wp.array(dtype=vec3),
        # out
        points: wp.array(dtype=vec3),
    ):
        p = wp.tid()
        nodes = point_nodes[p]
        weights = point_weights[p]
        points[p] = (
            weights[0] * positions[nodes[0]]
            + weights[1] * positions[nodes[1]]
            + weights[2] * positions[nodes[2]]
            + weights[3] * positions[nodes[3]]
        )

    @kernel
    def segment_lengths(
        # model
        segment_points: wp.array(dtype=wp.vec2i),
        # in
        points: wp.array(dtype=vec3),
        # out
        lengths: wp.array(dtype=scalar),
    ):
        j = wp.tid()
        ends = segment_points[j]
        lengths[j] = wp.length(points[ends[1]] - points[ends[0]])

    @kernel
    def segment_tensions(
        # model
        stiffness: wp.array(dtype=scalar),
        # in
        rest_lengths: wp.array(dtype=scalar),
        lengths: wp.array(dtype=scalar),
        # out
        tensions: wp.array(dtype=scalar),
    ):
        j = wp.tid()
        tensions[j] = stiffness[j] * wp.max(lengths[j] - rest_lengths[j], scalar(0.0))

    @kernel
    def muscle_tets(
        # model
        pair_start: wp.array(dtype=int),
        pair_segment: wp.array(dtype=int),
        pair_weight: wp.array(dtype=scalar),
        directions: wp.array(dtype=vec3),
        # in
        tensions: wp.array(dtype=scalar),
        rotations: wp.array(dtype=mat33),
        area_rows: wp.array(dtype=mat33),
        # out
        forces: wp.array(dtype=vec3),
    ):
        t = wp.tid()
        stress = mat33()
        for k in range(pair_start[t], pair_start[t + 1]):
            j = pair_segment[k]
            d = directions[j]
            stress += (pair_weight[k] * tensions[j]) * wp.outer(d, d)
        R = rotations[t]
        rows = area_rows[t] * (R * stress * wp.transpose(R))
        first = row(rows, 0)
        second = row(rows, 1)
        third = row(rows, 2)
        forces[4 * t] = first + second + third
        forces[4 * t + 1] = -first
        forces[4 * t + 2] = -second
        forces[4 * t + 3] = -third

    @kernel
    def tet_response(
        # model
        tets: wp.array(dtype=wp.vec4i),
        turned: int,
        # in
        rotations: wp.array(dtype=mat33),
        area_rows: wp.array(dtype=mat33),
        responses: wp.array2d(dtype=block),
        # out
        stretch: wp.array2d(dtype=block),
    ):
        # sum_a (R^T (W_a - W_0)) (R^T V0 cof(F) g_a)^T, its symmetric part, for every right-hand
        # side: a fibre stress d d^T in the rest frame answers with d^T of it d. Areas that are
        # ``turned`` stand in the rest frame already; implicit muscles have F in place of R
        b, t = wp.tid()
        R = rotations[t]
        H = area_rows[t]
        if turned == 0:
            H = area_rows[t] * R
        corners = tets[t]
        n0 = 3 * corners[0]
        w0 = responses[b, n0]
        w1 = responses[b, n0 + 1]
        w2 = responses[b, n0 + 2]
        xx = block()
        yy = block()
        zz = block()
        xy = block()
        xz = block()
        yz = block()
        for a in range(3):
            n = 3 * corners[a + 1]
            d0 = responses[b, n] - w0
            d1 = responses[b, n + 1] - w1
            d2 = responses[b, n + 2] - w2
            u0 = R[0, 0] * d0 + R[1, 0] * d1 + R[2, 0] * d2
            u1 = R[0, 1] * d0 + R[1, 1] * d1 + R[2, 1] * d2
            u2 = R[0, 2] * d0 + R[1, 2] * d1 + R[2, 2] * d2
            xx += H[a, 0] * u0
            yy += H[a, 1] * u1
            zz += H[a, 2] * u2
            xy += H[a, 0] * u1 + H[a, 1] * u0
            xz += H[a, 0] * u2 + H[a, 2] * u0
            yz += H[a, 1] * u2 + H[a, 2] * u1
        stretch[b, 6 * t] = xx
        stretch[b, 6 * t + 1] = yy
        stretch[b, 6 * t + 2] = zz
        stretch[b, 6 * t + 3] = xy
        stretch[b, 6 * t + 4] = xz
        stretch[b, 6 * t + 5] = yz

    @kernel
    def muscle_response(
        # model
        segment_start: wp.array(dtype=int),
        segment_tet: wp.array(dtype=int),
        segment_weight: wp.array(dtype=scalar),
        directions: wp.array(dtype=vec3),
        stiffness: wp.array(dtype=scalar),
        step_factors: wp.array(dtype=scalar),
        # in
        stretch: wp.array2d(dtype=block),
        # out
        maps: wp.array2d(dtype=block),
    ):
        # (W^T dt A)_j: change of every right-hand side's response per metre of l_d of segment j
        b, j = wp.tid()
        d = directions[j]
        total = block()
        for k in range(segment_start[j], segment_start[j + 1]):
            t = 6 * segment_tet[k]
            w = segment_weight[k]
            diagonal = (w * d[0] * d[0]) * stretch[b, t] + (w * d[1] * d[1]) * stretch[b, t + 1]
            diagonal += (w * d[2] * d[2]) * stretch[b, t + 2]
            mixed = (w * d[0] * d[1]) * stretch[b, t + 3] + (w * d[0] * d[2]) * stretch[b, t + 4]
            mixed += (w * d[1] * d[2]) * stretch[b, t + 5]
            total += diagonal + mixed
        maps[b, j] = (step_factors[0] * stiffness[j]) * total

    return SimpleNamespace(
        fiber_points=fiber_points,
        segment_lengths=segment_lengths,
        segment_tensions=segment_tensions,
        muscle_tets=muscle_tets,
        tet_response=tet_response,
        muscle_response=muscle_response,
    )
