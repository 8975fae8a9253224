"""Where surface nodes stand over a grid of heights, two triangles a cell."""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.precision import real

SUBJECT = "ground_heights"


@cache
def make_ground_heights(precision: str) -> SimpleNamespace:
    """Struct ``HeightGrid``, kernel ``detect``."""
    types = real(precision)
    scalar, vec3 = types.scalar, types.vec3
    kernel, func = types.kernel(SUBJECT), types.func(SUBJECT)

    @wp.struct
    class HeightGrid:
        heights: wp.array2d(dtype=scalar)
        origin_x: scalar
        origin_y: scalar
        spacing_x: scalar
        spacing_y: scalar
        recovery_speed: scalar

    @func
    def surface(grid: HeightGrid, p: vec3):
        # height and its slopes along x and y; beyond the grid the ground goes on level
        heights = grid.heights
        last_u, last_v = heights.shape[0] - 1, heights.shape[1] - 1
        u = (p[0] - grid.origin_x) / grid.spacing_x
        v = (p[1] - grid.origin_y) / grid.spacing_y
        inner_u = wp.clamp(u, scalar(0.0), scalar(last_u))
        inner_v = wp.clamp(v, scalar(0.0), scalar(last_v))
        i, j = wp.min(int(inner_u), last_u - 1), wp.min(int(inner_v), last_v - 1)
        a, b = inner_u - scalar(i), inner_v - scalar(j)
        corner, far = heights[i, j], heights[i + 1, j + 1]
        along_u, along_v = heights[i + 1, j] - corner, far - heights[i + 1, j]
        if a < b:
            along_u, along_v = far - heights[i, j + 1], heights[i, j + 1] - corner
        height = corner + a * along_u + b * along_v
        slope_u, slope_v = along_u / grid.spacing_x, along_v / grid.spacing_y
        if inner_u != u:
            slope_u = scalar(0.0)
        if inner_v != v:
            slope_v = scalar(0.0)
        return vec3(height, slope_u, slope_v)

    @kernel
    def detect(
        # model
        surface_nodes: wp.array(dtype=int),
        grid: HeightGrid,
        step_factors: wp.array(dtype=scalar),
        # in
        positions: wp.array(dtype=vec3),
        velocities: wp.array(dtype=vec3),
        # out
        normal_velocity: wp.array(dtype=scalar),
        normals: wp.array(dtype=vec3),
    ):
        c = wp.tid()
        i = surface_nodes[c]
        dt, p = step_factors[0], positions[i]
        here = surface(grid, p)
        n = wp.normalize(vec3(-here[1], -here[2], scalar(1.0)))
        gap = (p[2] - here[0]) * n[2]
        # in a valley the triangle that the node is on its way to is what it will meet
        q = p + dt * velocities[i]
        there = surface(grid, q)
        other = wp.normalize(vec3(-there[1], -there[2], scalar(1.0)))
        distance = wp.dot(other, p - vec3(q[0], q[1], there[0]))
        if distance > gap:
            n = other
            gap = distance
        normals[i] = n
        normal_velocity[c] = wp.min(-gap / dt, grid.recovery_speed)

    return SimpleNamespace(HeightGrid=HeightGrid, detect=detect)
