"""Coefficients of friction at the places where surface nodes are."""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.precision import real

SUBJECT = "ground_friction"


@cache
def make_ground_friction(precision: str) -> SimpleNamespace:
    """Struct ``FrictionGrid``, kernel ``place``."""
    types = real(precision)
    scalar, vec3 = types.scalar, types.vec3
    kernel = types.kernel(SUBJECT)

    @wp.struct
    class FrictionGrid:
        factors: wp.array2d(dtype=scalar)
        origin_x: scalar
        origin_y: scalar
        spacing_x: scalar
        spacing_y: scalar

    @kernel
    def place(
        # model
        surface_nodes: wp.array(dtype=int),
        usual: wp.array(dtype=scalar),
        grid: FrictionGrid,
        # in
        positions: wp.array(dtype=vec3),
        # out
        friction: wp.array(dtype=scalar),
    ):
        c = wp.tid()
        p = positions[surface_nodes[c]]
        last_u = scalar(grid.factors.shape[0] - 1)
        last_v = scalar(grid.factors.shape[1] - 1)
        # clamped as numbers: a place far away has no index
        u = wp.floor((p[0] - grid.origin_x) / grid.spacing_x)
        v = wp.floor((p[1] - grid.origin_y) / grid.spacing_y)
        i = int(wp.clamp(u, scalar(0.0), last_u))
        j = int(wp.clamp(v, scalar(0.0), last_v))
        friction[c] = usual[c] * grid.factors[i, j]

    return SimpleNamespace(FrictionGrid=FrictionGrid, place=place)
