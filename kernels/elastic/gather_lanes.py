"""Sums over the tets around edges and nodes in native code, for processors.

They do what ``stiffness_edges``, ``mean_turns`` and ``finish_nodes`` of ``corotated`` and
``stiffness_edges`` of ``exact_volume`` do, to rounding, with three numbers in a register of four.
Gradients and forces therefore have one more vector than there are, which is read but never used.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.precision import real

SUBJECT = "gather_lanes"

COMMON = """
#pragma clang fp contract(fast)
    typedef SCALAR quad __attribute__((vector_size(4 * sizeof(SCALAR)), aligned(sizeof(SCALAR))));
    const auto at = [](const SCALAR* from) { return *(const quad*)from; };
    // columns of the 3 x 3 matrix whose rows are a, b and c
    const auto transpose = [](quad a, quad b, quad c, quad* to) {
        const quad first = __builtin_shufflevector(a, b, 0, 4, 1, 5);
        const quad last = __builtin_shufflevector(a, b, 2, 6, 3, 7);
        to[0] = __builtin_shufflevector(first, c, 0, 1, 4, 7);
        to[1] = __builtin_shufflevector(first, c, 2, 3, 5, 7);
        to[2] = __builtin_shufflevector(last, c, 0, 1, 6, 7);
    };
    const auto put = [](SCALAR* to, quad a, quad b, quad c) {
        *(quad*)to = a;
        *(quad*)(to + 3) = b;
        for (int j = 0; j < 3; ++j) to[6 + j] = c[j];
    };
"""

# Rows of K_ab over the tets around an edge; ``wise`` is the sum of Ga Gb^T.
EDGE = """
    const SCALAR* G = (const SCALAR*)gradients.data;
    const SCALAR mu = step_factors.data[1] * lame.data[0];
    const SCALAR lambda = step_factors.data[1] * lame.data[1];
    const int* pairs = (const int*)edge_corners.data;
    quad wise[3] = {}, swelling[3] = {};
    for (int k = edge_start.data[edge]; k < edge_start.data[edge + 1]; ++k) {
        const int a = 3 * pairs[2 * k], b = 3 * pairs[2 * k + 1];
        const quad other = at(G + b);
        for (int i = 0; i < 3; ++i) wise[i] += G[a + i] * other;
        VOLUME
    }
    quad turned[3], rows[3], columns[3];
    transpose(wise[0], wise[1], wise[2], turned);
    const SCALAR along = mu * (wise[0][0] + wise[1][1] + wise[2][2]);
    for (int i = 0; i < 3; ++i) {
        rows[i] = lambda * OUTER[i] + mu * turned[i];
        rows[i][i] += along;
    }
    transpose(rows[0], rows[1], rows[2], columns);
    const int* slots = (const int*)edge_slots.data + 2 * edge;
    put((SCALAR*)values.data + 9 * (size_t)slots[0], rows[0], rows[1], rows[2]);
    put((SCALAR*)values.data + 9 * (size_t)slots[1], columns[0], columns[1], columns[2]);
"""

LINEAR = COMMON + EDGE.replace("VOLUME", "").replace("OUTER", "wise")

EXACT = COMMON + EDGE.replace(
    "VOLUME",
    """const SCALAR* C = (const SCALAR*)volume_gradients.data;
        const quad face = at(C + b);
        for (int i = 0; i < 3; ++i) swelling[i] += C[a + i] * face;""",
).replace("OUTER", "swelling")

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
    COMMON
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


def gather_lanes_on(device: str, precision: str) -> SimpleNamespace | None:
    """The kernels of this module where a device is a processor; None elsewhere."""
    return make_gather_lanes(precision) if wp.get_device(device).is_cpu else None


@cache
def make_gather_lanes(precision: str) -> SimpleNamespace:
    """Kernels ``linear_edges``, ``exact_edges``, ``mean_turns`` and ``finish_nodes``."""
    types = real(precision)
    scalar, vec3, mat33 = types.scalar, types.vec3, types.mat33
    kernel = types.kernel(SUBJECT)

    @types.native(LINEAR)
    def linear_edge(
        edge: int,
        edge_start: wp.array(dtype=int),
        edge_corners: wp.array(dtype=wp.vec2i),
        edge_slots: wp.array(dtype=wp.vec2i),
        lame: wp.array(dtype=scalar),
        step_factors: wp.array(dtype=scalar),
        gradients: wp.array(dtype=vec3),
        values: wp.array(dtype=mat33),
    ): ...

    @types.native(EXACT)
    def exact_edge(
        edge: int,
        edge_start: wp.array(dtype=int),
        edge_corners: wp.array(dtype=wp.vec2i),
        edge_slots: wp.array(dtype=wp.vec2i),
        lame: wp.array(dtype=scalar),
        step_factors: wp.array(dtype=scalar),
        gradients: wp.array(dtype=vec3),
        volume_gradients: wp.array(dtype=vec3),
        values: wp.array(dtype=mat33),
    ): ...

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

    @kernel
    def linear_edges(
        # model
        edge_start: wp.array(dtype=int),
        edge_corners: wp.array(dtype=wp.vec2i),
        edge_slots: wp.array(dtype=wp.vec2i),
        lame: wp.array(dtype=scalar),
        step_factors: wp.array(dtype=scalar),
        # in
        gradients: wp.array(dtype=vec3),
        # out
        values: wp.array(dtype=mat33),
    ):
        # fmt: off
        linear_edge(
            wp.tid(), edge_start, edge_corners, edge_slots, lame, step_factors, gradients, values,
        )
        # fmt: on

    @kernel
    def exact_edges(
        # model
        edge_start: wp.array(dtype=int),
        edge_corners: wp.array(dtype=wp.vec2i),
        edge_slots: wp.array(dtype=wp.vec2i),
        lame: wp.array(dtype=scalar),
        step_factors: wp.array(dtype=scalar),
        # in
        gradients: wp.array(dtype=vec3),
        volume_gradients: wp.array(dtype=vec3),
        # out
        values: wp.array(dtype=mat33),
    ):
        # fmt: off
        exact_edge(
            wp.tid(), edge_start, edge_corners, edge_slots, lame, step_factors, gradients,
            volume_gradients, values,
        )
        # fmt: on

    @kernel
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

    return SimpleNamespace(
        linear_edges=linear_edges,
        exact_edges=exact_edges,
        mean_turns=mean_turns,
        finish_nodes=finish_nodes,
    )
