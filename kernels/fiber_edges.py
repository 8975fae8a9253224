"""What implicit muscles add to the blocks of edges, in native code for processors.

It is ``stiffen_edges`` of ``implicit_muscles``, to the last bit: a block is a vector of eight
numbers and one more, and its place is found by less arithmetic.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.implicit_muscles import SUBJECT
from warp_softbody.kernels.precision import real

ADD = """
    typedef SCALAR eight __attribute__((vector_size(8 * sizeof(SCALAR)),
                                        aligned(sizeof(SCALAR))));
    eight total = {};
    SCALAR end = 0;
    const int last = edge_start.data[edge + 1];
    for (int k = edge_start.data[edge]; k < last; ++k) {
        const int *corners = (const int*)edge_corners.data + 2 * k, t = corners[0] / 4;
        const int a = corners[0] - 4 * t, b = corners[1] - 4 * t;
        // the corners in the order of ``stiffen_tets``
        const int place = 6 * t + a + b - (a == 0 || b == 0);
        const SCALAR* own = (const SCALAR*)blocks.data + 9 * (size_t)place;
        const eight block = *(const eight*)own;
        total += a < b ? block : __builtin_shufflevector(block, block, 0, 3, 6, 1, 4, 7, 2, 5);
        end += own[8];
    }
    const int* slots = (const int*)edge_slots.data + 2 * edge;
    for (int side = 0; side < 2; ++side) {
        SCALAR* to = (SCALAR*)values.data + 9 * (size_t)slots[side];
        *(eight*)to += total;
        to[8] += end;
        total = __builtin_shufflevector(total, total, 0, 3, 6, 1, 4, 7, 2, 5);
    }
"""


@cache
def make_fiber_edges(precision: str) -> SimpleNamespace:
    """The kernel, with the arguments of its plain namesake."""
    types = real(precision)
    mat33 = types.mat33
    kernel = types.kernel(SUBJECT)

    @types.native(ADD)
    def add_to_edge(
        edge: int,
        edge_start: wp.array(dtype=int),
        edge_corners: wp.array(dtype=wp.vec2i),
        edge_slots: wp.array(dtype=wp.vec2i),
        blocks: wp.array(dtype=mat33),
        values: wp.array(dtype=mat33),
    ): ...

    @kernel
    def stiffen_edges(
        # model
        first: int,
        edge_start: wp.array(dtype=int),
        edge_corners: wp.array(dtype=wp.vec2i),
        edge_slots: wp.array(dtype=wp.vec2i),
        # in
        blocks: wp.array(dtype=mat33),
        # in and out
        values: wp.array(dtype=mat33),
    ):
        add_to_edge(first + wp.tid(), edge_start, edge_corners, edge_slots, blocks, values)

    return SimpleNamespace(stiffen_edges=stiffen_edges)
