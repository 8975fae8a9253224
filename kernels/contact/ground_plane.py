"""Where surface nodes stand over a plane."""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.precision import real

SUBJECT = "ground_plane"


@cache
def make_ground_plane(precision: str) -> SimpleNamespace:
    """Struct ``GroundPlane``, kernel ``detect``."""
    types = real(precision)
    scalar, vec3 = types.scalar, types.vec3
    kernel = types.kernel(SUBJECT)

    @wp.struct
    class GroundPlane:
        normal: vec3
        offset: scalar
        recovery_speed: scalar

    @kernel
    def detect(
        # model
        surface_nodes: wp.array(dtype=int),
        plane: GroundPlane,
        step_factors: wp.array(dtype=scalar),
        # in
        positions: wp.array(dtype=vec3),
        # out
        normal_velocity: wp.array(dtype=scalar),
        normals: wp.array(dtype=vec3),
    ):
        c = wp.tid()
        i = surface_nodes[c]
        n = plane.normal
        gap = wp.dot(n, positions[i]) - plane.offset
        normals[i] = n
        normal_velocity[c] = wp.min(-gap / step_factors[0], plane.recovery_speed)

    return SimpleNamespace(GroundPlane=GroundPlane, detect=detect)
