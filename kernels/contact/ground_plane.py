"""Where surface nodes stand over a plane."""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.precision import real

SUBJECT = "ground_plane"


@cache
def make_ground_plane(precision: str) -> SimpleNamespace:
    """Kernel ``detect``."""
    types = real(precision)
    scalar, vec3 = types.scalar, types.vec3
    kernel = types.kernel(SUBJECT)

    @kernel
    def detect(
        # model
        surface_nodes: wp.array(dtype=int),
        plane_normal: wp.array(dtype=vec3),
        plane: wp.array(dtype=scalar),
        step_factors: wp.array(dtype=scalar),
        # in
        positions: wp.array(dtype=vec3),
        # out
        normal_velocity: wp.array(dtype=scalar),
        normals: wp.array(dtype=vec3),
    ):
        # plane: offset, recovery speed
        c = wp.tid()
        i = surface_nodes[c]
        n = plane_normal[0]
        gap = wp.dot(n, positions[i]) - plane[0]
        normals[i] = n
        normal_velocity[c] = wp.min(-gap / step_factors[0], plane[1])

    return SimpleNamespace(detect=detect)
