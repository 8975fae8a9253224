"""Conserving and exact tangents of tets that resist their exact change of volume (method.md 1).

The volume's Gauss-Newton term, ``lambda c c^T`` with c the derivative of det F by the corners,
takes every turn to zero by itself: no turn changes det F, in any shape. So the conserving tangent
is that term and the shear's part of ``kernels/elastic/tangent.py``, whose additions are of mu
alone. The exact one has the pressure ``p = lambda (det F - 1)`` times the second derivative of
det F too: ``K_ab = -[p V (G_a x G_b)]``, [.] the cross product's matrix, V = F R^T and G the
spatial gradients times the root of the volume. In V's axes, with s the symmetric and a the axial
part of D = dF R^T, it is ``2 p sum_i v_i (s_jj s_kk - s_jk^2 + a_i^2)``, which leaves the two
apart. On a, the sum with the shear's ``4 (mu I - 2 mu N)`` is diagonal, and negative entries are
set to zero; on s the pressure is halved until ``2 mu |s|^2 + lambda (cof V : s)^2`` outweighs it.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.elastic.tangent import TangentKind
from warp_softbody.kernels.elastic.tet_geometry import make_tets
from warp_softbody.kernels.precision import real

SUBJECT = "volume_tangent"
HALVINGS = 6
"""Of a pressure that is too large for the symmetric part; after them it is left out."""


@cache
def make_volume_tangent(precision: str) -> SimpleNamespace:
    """Kernels ``couple_tets`` of the exact tangent and ``coupled_edges`` of both."""
    types = real(precision)
    scalar, vec3, mat33 = types.scalar, types.vec3, types.mat33
    kernel, func = types.kernel(SUBJECT), types.func(SUBJECT)
    tet = make_tets(precision, SUBJECT)
    deformation = tet.deformation
    tiny = wp.constant(scalar(types.tiny))

    @func
    def outweighed(v: vec3, cof: vec3, mu: scalar, lam: scalar, pressure: scalar):
        # whether 2 mu |s|^2 + lambda (cof . s)^2 and the pressure's part are positive on all s
        if wp.max(v) * pressure > scalar(2.0) * mu or wp.min(v) * pressure > scalar(2.0) * mu:
            return False
        A = lam * wp.outer(cof, cof) + scalar(2.0) * mu * wp.identity(n=3, dtype=scalar)
        A += pressure * mat33(
            scalar(0.0), v[2], v[1], v[2], scalar(0.0), v[0], v[1], v[0], scalar(0.0)
        )
        minor = A[0, 0] * A[1, 1] - A[0, 1] * A[0, 1]
        return A[0, 0] > scalar(0.0) and minor > scalar(0.0) and wp.determinant(A) > scalar(0.0)

    @func
    def bearable(v: vec3, mu: scalar, lam: scalar, pressure: scalar):
        # the pressure, or what the symmetric part bears of it
        cof = vec3(v[1] * v[2], v[2] * v[0], v[0] * v[1])
        borne = pressure
        for _ in range(wp.static(HALVINGS)):
            if outweighed(v, cof, mu, lam, borne):
                return borne
            borne = scalar(0.5) * borne
        return scalar(0.0)

    @func
    def axial_part(v: vec3, mu: scalar, pressure: scalar):
        # of 4 a^T H a in V's axes; R has no derivative where two singular values cancel, and what
        # it adds fades out there as in kernels/elastic/tangent.py
        size = v[0] + v[1] + v[2]
        sums = vec3(size - v[0], size - v[1], size - v[2])
        share = scalar(3.375) * sums[0] * sums[1] * sums[2] / wp.max(size * size * size, tiny)
        found = vec3()
        if share > scalar(1e-3):
            fade = wp.min(scalar(1.0), scalar(16.0) * share * share)
            for i in range(3):
                h = mu - scalar(2.0) * mu / sums[i] + scalar(0.5) * pressure * v[i]
                found[i] = fade * wp.max(h, scalar(0.0))
        return found

    @kernel
    def couple_tets(
        # model
        tets: wp.array(dtype=wp.vec4i),
        rest_inverse: wp.array(dtype=mat33),
        lame: wp.array(dtype=scalar),
        # in
        positions: wp.array(dtype=vec3),
        rotations: wp.array(dtype=mat33),
        gradients: wp.array(dtype=vec3),
        # out
        couplings: wp.array(dtype=mat33),
        twists: wp.array(dtype=vec3),
    ):
        # twists: k = p (tr V I / 2 - V) G, so that p V (G_a x G_b) = k_a x G_b + G_a x k_b
        t = wp.tid()
        corners = tets[t]
        F = deformation(corners, rest_inverse[t], positions)
        turned = F * wp.transpose(rotations[t])
        V = scalar(0.5) * (turned + wp.transpose(turned))
        axes, v = wp.eig3(V)
        mu = lame[0]
        pressure = lame[1] * (wp.determinant(F) - scalar(1.0))
        borne = bearable(v, mu, lame[1], pressure)
        # what the pressure's edges add to a is taken back, as it is in H already
        h = scalar(0.5) * (axial_part(v, mu, pressure) - scalar(0.5) * borne * v)
        Q = axes * wp.diag(h) * wp.transpose(axes)
        half = (scalar(0.5) * wp.trace(V)) * wp.identity(n=3, dtype=scalar)
        across = borne * (half - V)
        total = mat33()
        twist = vec3()
        for corner in range(1, 4):
            g = gradients[4 * t + corner]
            Y = wp.matrix_from_cols(wp.cross(g, Q[0]), wp.cross(g, Q[1]), wp.cross(g, Q[2]))
            k = across * g
            couplings[4 * t + corner] = Y
            twists[4 * t + corner] = k
            total += Y
            twist += k
        couplings[4 * t] = -total
        twists[4 * t] = -twist

    @func
    def rows_across(g: vec3, Y: mat33):
        # -Y [g]
        return wp.matrix_from_rows(wp.cross(g, Y[0]), wp.cross(g, Y[1]), wp.cross(g, Y[2]))

    @kernel
    def coupled_edges(
        # model
        edge_start: wp.array(dtype=int),
        edge_corners: wp.array(dtype=wp.vec2i),
        edge_slots: wp.array(dtype=wp.vec2i),
        lame: wp.array(dtype=scalar),
        step_factors: wp.array(dtype=scalar),
        tangent: int,
        # in
        gradients: wp.array(dtype=vec3),
        volume_gradients: wp.array(dtype=vec3),
        couplings: wp.array(dtype=mat33),
        twists: wp.array(dtype=vec3),
        # out
        values: wp.array(dtype=mat33),
    ):
        edge = wp.tid()
        outer = mat33()
        volume = mat33()
        from_a = mat33()
        from_b = mat33()
        twist = vec3()
        for k in range(edge_start[edge], edge_start[edge + 1]):
            corners = edge_corners[k]
            a = gradients[corners[0]]
            b = gradients[corners[1]]
            outer += wp.outer(a, b)
            volume += wp.outer(volume_gradients[corners[0]], volume_gradients[corners[1]])
            from_a += rows_across(b, couplings[corners[0]])
            from_b += rows_across(a, couplings[corners[1]])
            if tangent == TangentKind.EXACT:
                twist += wp.cross(twists[corners[0]], b) + wp.cross(a, twists[corners[1]])
        along = wp.trace(outer) * wp.identity(n=3, dtype=scalar)
        block = lame[0] * (wp.transpose(outer) + along) + lame[1] * volume
        block = step_factors[1] * (block + from_a + wp.transpose(from_b) - wp.skew(twist))
        slots = edge_slots[edge]
        values[slots[0]] = block
        values[slots[1]] = wp.transpose(block)

    return SimpleNamespace(couple_tets=couple_tets, coupled_edges=coupled_edges)
