"""Sums over the tets and the blocks around nodes in native code, for processors.

They do what ``rotate_nodes``, but for the rotation itself, and ``finish_nodes`` of ``corotated``
do, to rounding, with three numbers in a register of four. Forces therefore have one more vector
than there are, which is read but never used.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.elastic.edge_lanes import VECTORS
from warp_softbody.kernels.precision import real

SUBJECT = "node_lanes"

TURN = """
#pragma clang fp contract(fast)
    typedef SCALAR quad __attribute__((vector_size(4 * sizeof(SCALAR)), aligned(sizeof(SCALAR))));
    quad first = {}, second = {};
    SCALAR last = 0;
    for (int k = node_start.data[i]; k < node_start.data[i + 1]; ++k) {
        const int t = node_corners.data[k] / 4;
        const SCALAR volume = rest_volume.data[t];
        const SCALAR* R = (const SCALAR*)rotations.data + 9 * (size_t)t;
        first += volume * *(const quad*)R;
        second += volume * *(const quad*)(R + 4);
        last += volume * R[8];
    }
    SCALAR* to = (SCALAR*)turns.data + 9 * (size_t)i;
    *(quad*)to = first;
    *(quad*)(to + 4) = second;
    to[8] = last;
"""

FINISH = (
    VECTORS
    + """
    const SCALAR* A = (const SCALAR*)values.data;
    const int slot = diagonal_slot.data[i], end = row_start.data[i + 1];
    quad others[3] = {}, turned[3], rows[3];
    for (int k = row_start.data[i]; k < slot; ++k)
        for (int a = 0; a < 3; ++a) others[a] += at(A + 9 * (size_t)k + 3 * a);
    // the last block of all is a diagonal one, so that behind these there is another number
    for (int k = slot + 1; k < end; ++k)
        for (int a = 0; a < 3; ++a) others[a] += at(A + 9 * (size_t)k + 3 * a);
    transpose(others[0], others[1], others[2], turned);
    const SCALAR own = mass.data[i] * step_factors.data[2];
    for (int a = 0; a < 3; ++a) {
        rows[a] = (SCALAR)-0.5 * (others[a] + turned[a]);
        rows[a][a] += own;
    }
    put((SCALAR*)values.data + 9 * (size_t)slot, rows[0], rows[1], rows[2]);
    const SCALAR *f = (const SCALAR*)forces.data, *g = (const SCALAR*)gravity.data;
    quad force = {};
    for (int k = node_start.data[i]; k < node_start.data[i + 1]; ++k)
        force += at(f + 3 * (size_t)node_corners.data[k]);
    for (int a = 0; a < 3; ++a) {
        const SCALAR impulse = step_factors.data[0] * (mass.data[i] * g[a] + force[a]);
        ((SCALAR*)impulses.data)[3 * i + a] = impulse;
        ((SCALAR*)momentum.data)[3 * i + a] =
            mass.data[i] * ((const SCALAR*)velocities.data)[3 * i + a] + impulse;
    }
"""
)


def node_lanes_on(device: str, precision: str) -> SimpleNamespace | None:
    """The kernels of this module where a device is a processor; None elsewhere."""
    return make_node_lanes(precision) if wp.get_device(device).is_cpu else None


@cache
def make_node_lanes(precision: str) -> SimpleNamespace:
    """Kernels ``mean_turns`` and ``finish_nodes``."""
    types = real(precision)
    scalar, vec3, mat33 = types.scalar, types.vec3, types.mat33
    kernel = types.kernel(SUBJECT)

    @types.native(TURN)
    def mean_turn(
        i: int,
        node_start: wp.array(dtype=int),
        node_corners: wp.array(dtype=int),
        rest_volume: wp.array(dtype=scalar),
        rotations: wp.array(dtype=mat33),
        turns: wp.array(dtype=mat33),
    ): ...

    @types.native(FINISH)
    def finish_node(
        i: int,
        node_start: wp.array(dtype=int),
        node_corners: wp.array(dtype=int),
        row_start: wp.array(dtype=int),
        diagonal_slot: wp.array(dtype=int),
        mass: wp.array(dtype=scalar),
        gravity: wp.array(dtype=vec3),
        step_factors: wp.array(dtype=scalar),
        velocities: wp.array(dtype=vec3),
        forces: wp.array(dtype=vec3),
        values: wp.array(dtype=mat33),
        impulses: wp.array(dtype=vec3),
        momentum: wp.array(dtype=vec3),
    ): ...

    @types.kernel(SUBJECT, "turns")
    def mean_turns(
        # model
        node_start: wp.array(dtype=int),
        node_corners: wp.array(dtype=int),
        rest_volume: wp.array(dtype=scalar),
        # in
        rotations: wp.array(dtype=mat33),
        # out
        turns: wp.array(dtype=mat33),
    ):
        mean_turn(wp.tid(), node_start, node_corners, rest_volume, rotations, turns)

    @kernel
    def finish_nodes(
        # model
        node_start: wp.array(dtype=int),
        node_corners: wp.array(dtype=int),
        row_start: wp.array(dtype=int),
        diagonal_slot: wp.array(dtype=int),
        mass: wp.array(dtype=scalar),
        gravity: wp.array(dtype=vec3),
        step_factors: wp.array(dtype=scalar),
        # in
        velocities: wp.array(dtype=vec3),
        forces: wp.array(dtype=vec3),
        # out
        values: wp.array(dtype=mat33),
        impulses: wp.array(dtype=vec3),
        momentum: wp.array(dtype=vec3),
    ):
        # fmt: off
        finish_node(
            wp.tid(), node_start, node_corners, row_start, diagonal_slot, mass, gravity,
            step_factors, velocities, forces, values, impulses, momentum,
        )
        # fmt: on

    return SimpleNamespace(mean_turns=mean_turns, finish_nodes=finish_nodes)
