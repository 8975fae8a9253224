"""Tangent stiffness beyond the warped one: what a change of the rotations adds (docs/method.md 1).

With D = dF R^T, its axial part ``a = (g x u) / 2`` summed over corners, V = F R^T and
``N = (tr V I - V)^-1``, the polar rotation changes by the turn ``2 N a``. Both additions can be
written ``K_ab = -Y_a [G_b] + [G_a] Y_b^T`` with [.] the cross product's matrix, G the spatial
gradients of a tet's corners times the root of its volume, and one 3 x 3 matrix Y a corner.

- conserving: ``V0 (d eps / d x)^T D (d eps / d x)`` with R's derivative in it, the Gauss-Newton
  matrix. Positive semidefinite, and it takes turns of the deformed body to zero, so that neither
  stiffness damping nor the implicit step changes the angular momentum of a free body.
- exact: the second derivative of the energy. On the symmetric part of D it is the warped matrix,
  on a it is ``4 (mu I - (2 mu - lambda tr eps) N)``, whose negative eigenvalues are set to zero.
"""

from enum import IntEnum
from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.elastic.tet_geometry import make_tets
from warp_softbody.kernels.precision import real

SUBJECT = "tangent"


class TangentKind(IntEnum):
    """Tangent stiffness of the step, in the order of the options' names."""

    WARPED = 0
    CONSERVING = 1
    EXACT = 2


@cache
def make_tangent(precision: str) -> SimpleNamespace:
    """Kernels ``couple_tets`` and ``coupled_edges`` of a precision."""
    types = real(precision)
    scalar, vec3, mat33 = types.scalar, types.vec3, types.mat33
    kernel, func = types.kernel(SUBJECT), types.func(SUBJECT)
    tet = make_tets(precision, SUBJECT)
    deformation, cofactor, isotropic_block = tet.deformation, tet.cofactor, tet.isotropic_block
    tiny = wp.constant(scalar(types.tiny))

    @func
    def symmetric(A: mat33):
        return scalar(0.5) * (A + wp.transpose(A))

    @func
    def without_negative(A: mat33):
        # the nearest positive semidefinite matrix
        Q, d = wp.eig3(A)
        clamped = vec3(
            wp.max(d[0], scalar(0.0)), wp.max(d[1], scalar(0.0)), wp.max(d[2], scalar(0.0))
        )
        return Q * wp.diag(clamped) * wp.transpose(Q)

    @func
    def rows_across(g: vec3, Y: mat33):
        # -Y [g]
        return wp.matrix_from_rows(wp.cross(g, Y[0]), wp.cross(g, Y[1]), wp.cross(g, Y[2]))

    @kernel
    def couple_tets(
        # model
        tets: wp.array(dtype=wp.vec4i),
        rest_inverse: wp.array(dtype=mat33),
        lame: wp.array(dtype=scalar),
        tangent: int,
        # in
        positions: wp.array(dtype=vec3),
        rotations: wp.array(dtype=mat33),
        gradients: wp.array(dtype=vec3),
        # out
        couplings: wp.array(dtype=mat33),
    ):
        t = wp.tid()
        corners = tets[t]
        identity = wp.identity(n=3, dtype=scalar)
        F = deformation(corners, rest_inverse[t], positions)
        V = symmetric(F * wp.transpose(rotations[t]))
        size = wp.trace(V)
        A = size * identity - V
        cof = cofactor(A)
        determinant = wp.determinant(A)
        mu = lame[0]
        # 1 for an unstrained tet, 0 where two singular values cancel and R has no derivative: there
        # the addition fades out, which leaves a mean of two positive semidefinite matrices
        share = scalar(3.375) * determinant / wp.max(size * size * size, tiny)
        fade = scalar(0.0)
        N = mat33()
        if share > scalar(1e-3):
            fade = wp.min(scalar(1.0), scalar(16.0) * share * share)
            N = symmetric(cof) / determinant
        # Y = [h] P + [g] Q, h = (tr V I - 2 V) g; P and Q are functions of V, so symmetric
        P = mat33()
        Q = mat33()
        if tangent == TangentKind.EXACT:
            pressure = lame[1] * (size - scalar(3.0))
            H = without_negative(mu * identity - (scalar(2.0) * mu - pressure) * N)
            Q = (scalar(0.5) * fade) * H
        else:
            P = (fade * mu) * N
            VN = V * N
            Q = (fade * mu) * (scalar(0.5) * identity - VN - scalar(2.0) * (N * cofactor(V) * N))
        across = A - V
        total = mat33()
        for corner in range(1, 4):
            g = gradients[4 * t + corner]
            h = across * g
            Y = wp.matrix_from_cols(
                wp.cross(h, P[0]) + wp.cross(g, Q[0]),
                wp.cross(h, P[1]) + wp.cross(g, Q[1]),
                wp.cross(h, P[2]) + wp.cross(g, Q[2]),
            )
            couplings[4 * t + corner] = Y
            total += Y
        couplings[4 * t] = -total

    @kernel
    def coupled_edges(
        # model
        edge_start: wp.array(dtype=int),
        edge_corners: wp.array(dtype=wp.vec2i),
        edge_slots: wp.array(dtype=wp.vec2i),
        lame: wp.array(dtype=scalar),
        step_factors: wp.array(dtype=scalar),
        # in
        gradients: wp.array(dtype=vec3),
        couplings: wp.array(dtype=mat33),
        # out
        values: wp.array(dtype=mat33),
    ):
        edge = wp.tid()
        outer = mat33()
        from_a = mat33()
        from_b = mat33()
        for k in range(edge_start[edge], edge_start[edge + 1]):
            corners = edge_corners[k]
            a = gradients[corners[0]]
            b = gradients[corners[1]]
            outer += wp.outer(a, b)
            from_a += rows_across(b, couplings[corners[0]])
            from_b += rows_across(a, couplings[corners[1]])
        block = isotropic_block(outer, step_factors[1] * lame[0], step_factors[1] * lame[1])
        block += step_factors[1] * (from_a + wp.transpose(from_b))
        slots = edge_slots[edge]
        values[slots[0]] = block
        values[slots[1]] = wp.transpose(block)

    return SimpleNamespace(couple_tets=couple_tets, coupled_edges=coupled_edges)
