"""What kernels over tets share."""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.precision import real


@cache
def make_tets(precision: str, subject: str) -> SimpleNamespace:
    """Functions for the kernels of a subject."""
    types = real(precision)
    scalar, vec3, mat33 = types.scalar, types.vec3, types.mat33
    func = types.func(subject)

    @func
    def deformation(corners: wp.vec4i, B: mat33, positions: wp.array(dtype=vec3)):
        # F = Ds Dm^-1
        x0 = positions[corners[0]]
        Ds = wp.matrix_from_cols(
            positions[corners[1]] - x0, positions[corners[2]] - x0, positions[corners[3]] - x0
        )
        return Ds * B

    @func
    def cofactor(F: mat33):
        c0 = vec3(F[0, 0], F[1, 0], F[2, 0])
        c1 = vec3(F[0, 1], F[1, 1], F[2, 1])
        c2 = vec3(F[0, 2], F[1, 2], F[2, 2])
        return wp.matrix_from_cols(wp.cross(c1, c2), wp.cross(c2, c0), wp.cross(c0, c1))

    @func
    def by_corner(slot: int, rows: mat33, out: wp.array(dtype=vec3)):
        # the shape functions sum to one, so corner 0 is minus the other three
        first = vec3(rows[0, 0], rows[0, 1], rows[0, 2])
        second = vec3(rows[1, 0], rows[1, 1], rows[1, 2])
        third = vec3(rows[2, 0], rows[2, 1], rows[2, 2])
        out[slot] = -(first + second + third)
        out[slot + 1] = first
        out[slot + 2] = second
        out[slot + 3] = third

    @func
    def isotropic_block(outer: mat33, mu: scalar, lam: scalar):
        # sum of lambda Ga Gb^T + mu Gb Ga^T + mu Ga.Gb I from that of Ga Gb^T
        along = (mu * wp.trace(outer)) * wp.identity(n=3, dtype=scalar)
        return lam * outer + wp.transpose(mu * outer) + along

    @func
    def nearly_rotation(R: mat33):
        # a mean of close rotations, made orthogonal by two Newton-Schulz steps
        three = scalar(3.0) * wp.identity(n=3, dtype=scalar)
        first = scalar(0.5) * R * (three - wp.transpose(R) * R)
        return scalar(0.5) * first * (three - wp.transpose(first) * first)

    return SimpleNamespace(
        deformation=deformation,
        cofactor=cofactor,
        nearly_rotation=nearly_rotation,
        by_corner=by_corner,
        isotropic_block=isotropic_block,
    )
