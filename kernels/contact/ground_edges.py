"""Edges of a body's surface across sharp convex edges of a grid of heights.

Nodes alone do not keep a body off the ground where that is sharper than the body's mesh: a convex
edge of the ground would poke through a face, or an edge, between its nodes. A body's surface is
linear between its edges, so that its distance from a straight edge of the ground is least where it
crosses an edge of the surface; every crossing is a contact of its own, as those of two bodies'
edges (``pair_edges.py``): two segments at their nearest points and their common normal, where that
leads out of the ground and into the body.

A contact is a row of the pairs (``pair_constraints.py``) whose other side is the ground, so that
its weights add up to one: two nodes with theirs, then the first once more and the second with
weight zero. That the third is the first tells it from all others.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.contact.ground_heights import make_ground_heights
from warp_softbody.kernels.contact.structs import make_pair_structs
from warp_softbody.kernels.precision import real

SUBJECT = "ground_edges"

PARALLEL = 0.1
"""Sine of the angle between two edges below which they do not cross."""

OUTER = 0.1
"""Sine of the angle by which a normal may leave the outer side of an edge."""

DEEPEST = 0.5
"""Part of an edge's length up to which an edge of the ground pushes it out."""

END = 0.01
"""Part of an edge of the body at either end that belongs to the node."""

CLOSE = 1e-3
"""Part of an edge's length that counts as near beside what a step may go."""

SIDES = 3
"""Edges of the grid that begin at a vertex: along x, along y and the diagonal of the cell."""


@cache
def make_ground_edges(precision: str) -> SimpleNamespace:
    """Structs ``BodyEdges`` and ``Creases``, kernel ``cross_creases``."""
    types = real(precision)
    scalar, vec3, vec4 = types.scalar, types.vec3, types.vec4
    kernel, func = types.kernel(SUBJECT), types.func(SUBJECT)
    HeightGrid = make_ground_heights(precision).HeightGrid
    Pairs = make_pair_structs(precision).Pairs
    parallel, outer = wp.constant(scalar(PARALLEL)), wp.constant(scalar(OUTER))
    deepest, end, close = (wp.constant(scalar(x)) for x in (DEEPEST, END, CLOSE))
    farthest = wp.constant(scalar(1e30))
    sides = wp.constant(SIDES)

    @wp.struct
    class BodyEdges:
        """Edges of the surfaces: their two nodes, and the triangle at either side.

        ``opposite`` has the third nodes of those, ``slots`` the places of nodes among the contacts.
        """

        ends: wp.array(dtype=wp.vec2i)
        left: wp.array(dtype=wp.vec3i)
        right: wp.array(dtype=wp.vec3i)
        opposite: wp.array(dtype=wp.vec2i)
        slots: wp.array(dtype=int)

    @wp.struct
    class Creases:
        """The sharp convex edges of a grid.

        ``flags`` has a bit for each of the edges that begin at a vertex, ``rows`` whether a row of
        them has any.
        """

        grid: HeightGrid
        flags: wp.array2d(dtype=int)
        rows: wp.array(dtype=int)

    @func
    def vertex(grid: HeightGrid, i: int, j: int):
        x = grid.origin_x + scalar(i) * grid.spacing_x
        y = grid.origin_y + scalar(j) * grid.spacing_y
        return vec3(x, y, grid.heights[i, j])

    @func
    def away_from(p: vec3, along: vec3, other: vec3):
        # unit, from a line through p to another point, across the line
        way = other - p
        return wp.normalize(way - wp.dot(way, along) * along)

    @func
    def face_normal(k: wp.vec3i, positions: wp.array(dtype=vec3)):
        a = positions[k[0]]
        return wp.normalize(wp.cross(positions[k[1]] - a, positions[k[2]] - a))

    @func
    def cell_of(place: scalar, origin: scalar, spacing: scalar, count: int):
        # where a body is far away the quotient has no whole number
        return int(wp.clamp(wp.floor((place - origin) / spacing), scalar(-2.0), scalar(count)))

    @func
    def sides_of(grid: HeightGrid, i: int, j: int, side: int):
        # the other end of an edge that begins at a vertex, and the third corners of its triangles
        if side == 0:
            return vertex(grid, i + 1, j), vertex(grid, i + 1, j + 1), vertex(grid, i, j - 1)
        if side == 1:
            return vertex(grid, i, j + 1), vertex(grid, i + 1, j + 1), vertex(grid, i - 1, j)
        return vertex(grid, i + 1, j + 1), vertex(grid, i + 1, j), vertex(grid, i, j + 1)

    @func
    def normal_between(a: vec3, start: vec3, stop: vec3, one: vec3, other: vec3):
        # the common normal of an edge along a and one of the ground, out of the ground; zero where
        # they are parallel or it leads into a face of the ground
        b = stop - start
        n = wp.cross(a, b)
        square = wp.length_sq(n)
        if square <= parallel * parallel * wp.length_sq(a) * wp.length_sq(b):
            return vec3()
        n = n / wp.sqrt(square)
        ridge = wp.normalize(b)
        to_one = away_from(start, ridge, one)
        to_other = away_from(start, ridge, other)
        if wp.dot(n, to_one + to_other) > scalar(0.0):
            n = -n
        if wp.dot(n, to_one) >= outer or wp.dot(n, to_other) >= outer:
            return vec3()
        return n

    @func
    def place_on_both(a: vec3, b: vec3, r: vec3):
        # where along p + u a and q + v b, with r = p - q, these are nearest to each other
        aa, bb, ab = wp.length_sq(a), wp.length_sq(b), wp.dot(a, b)
        ra, rb = wp.dot(r, a), wp.dot(r, b)
        square = aa * bb - ab * ab
        return (ab * rb - bb * ra) / square, (aa * rb - ab * ra) / square

    @func
    def friction_of(
        edges: BodyEdges,
        k: wp.vec2i,
        coefficients: wp.array(dtype=scalar),
        factors: wp.array(dtype=scalar),
    ):
        # the mean over both ends
        c, d = edges.slots[k[0]], edges.slots[k[1]]
        return scalar(0.5) * (coefficients[c] * factors[c] + coefficients[d] * factors[d])

    @kernel
    def cross_creases(
        # model
        edges: BodyEdges,
        creases: Creases,
        coefficients: wp.array(dtype=scalar),
        factors: wp.array(dtype=scalar),
        step_factors: wp.array(dtype=scalar),
        first: int,
        # in
        positions: wp.array(dtype=vec3),
        velocities: wp.array(dtype=vec3),
        # out
        pairs: Pairs,
    ):
        # slot first + 2 e + half: the deepest crossing on either half of an edge
        e = wp.tid()
        c = first + 2 * e
        pairs.nodes[c] = wp.vec4i(-1, -1, -1, -1)
        pairs.nodes[c + 1] = wp.vec4i(-1, -1, -1, -1)
        k = edges.ends[e]
        p, q = positions[k[0]], positions[k[1]]
        a = q - p
        size = wp.length(a)
        dt = step_factors[0]
        speed = wp.max(wp.length(velocities[k[0]]), wp.length(velocities[k[1]]))
        margin = dt * speed + close * size
        grid = creases.grid
        low, high = wp.min(p, q), wp.max(p, q)
        rows = creases.flags.shape[0]
        i_first = cell_of(low[0] - margin, grid.origin_x, grid.spacing_x, rows) - 1
        i_last = cell_of(high[0] + margin, grid.origin_x, grid.spacing_x, rows) + 1
        i_first, i_last = wp.max(i_first, 0), wp.min(i_last, rows - 1)
        columns = creases.flags.shape[1]
        j_first = cell_of(low[1] - margin, grid.origin_y, grid.spacing_y, columns) - 1
        j_last = cell_of(high[1] + margin, grid.origin_y, grid.spacing_y, columns) + 1
        j_first, j_last = wp.max(j_first, 0), wp.min(j_last, columns - 1)
        along = a / size
        left = away_from(p, along, positions[edges.opposite[e][0]])
        right = away_from(p, along, positions[edges.opposite[e][1]])
        outward = face_normal(edges.left[e], positions) + face_normal(edges.right[e], positions)
        best_first = scalar(farthest)
        best_second = scalar(farthest)
        for i in range(i_first, i_last + 1):
            if creases.rows[i] != 0:
                for cell in range(sides * (j_last - j_first + 1)):
                    j, side = j_first + cell / sides, cell % sides
                    if (creases.flags[i, j] >> side) & 1 != 0:
                        start = vertex(grid, i, j)
                        stop, one, other = sides_of(grid, i, j, side)
                        n = normal_between(a, start, stop, one, other)
                        # into the body, whose faces at the edge are on the far side
                        usable = wp.dot(n, outward) < scalar(0.0)
                        usable = usable and wp.dot(n, left) > -outer and wp.dot(n, right) > -outer
                        if usable:
                            u, v = place_on_both(a, stop - start, p - start)
                            gap = wp.dot(n, p - start)
                            usable = u > end and u < scalar(1.0) - end
                            usable = usable and v >= scalar(0.0) and v <= scalar(1.0)
                            usable = usable and gap < margin and gap > -deepest * size
                            half = wp.where(u > scalar(0.5), 1, 0)
                            best = wp.where(half == 1, best_second, best_first)
                            if usable and gap < best:
                                best_first = wp.where(half == 1, best_first, gap)
                                best_second = wp.where(half == 1, gap, best_second)
                                slot = c + half
                                pairs.nodes[slot] = wp.vec4i(k[0], k[1], k[0], k[1])
                                rest = scalar(1.0) - u
                                pairs.weights[slot] = vec4(rest, u, scalar(0.0), scalar(0.0))
                                pairs.normals[slot] = n
                                least = wp.min(-gap / dt, grid.recovery_speed)
                                pairs.normal_velocity[slot] = least
                                pairs.friction_factor[slot] = friction_of(
                                    edges, k, coefficients, factors
                                )

    return SimpleNamespace(BodyEdges=BodyEdges, Creases=Creases, cross_creases=cross_creases)
