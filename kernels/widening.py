"""Vectors of a run's precision in double precision, and back."""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.precision import real


@cache
def make_widening(precision: str, subject: str) -> SimpleNamespace:
    """Functions ``wide`` and ``narrow`` for the kernels of a subject."""
    types = real(precision)
    scalar, vec3 = types.scalar, types.vec3
    func = types.func(subject)

    @func
    def wide(v: vec3):
        return wp.vec3d(wp.float64(v[0]), wp.float64(v[1]), wp.float64(v[2]))

    @func
    def narrow(v: wp.vec3d):
        return vec3(scalar(v[0]), scalar(v[1]), scalar(v[2]))

    return SimpleNamespace(wide=wide, narrow=narrow)
