"""Blocks of edges in native code, for processors: sums over the tets around each.

They do what ``stiffness_edges`` of ``corotated`` and of ``exact_volume`` and ``coupled_edges`` of
``tangent`` and of ``volume_tangent`` with the conserving tangent do, to rounding, with three
numbers in a register of four. Gradients and couplings therefore have one more element than there
are, which is read but never used.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.precision import real

SUBJECT = "edge_lanes"

VECTORS = """
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
"""What sums by vectors of three share."""

# Rows of K_ab; ``wise`` is the sum of Ga Gb^T, ``from_a`` of -Y_a [G_b], ``from_b`` of -Y_b [G_a].
EDGE = """
    const auto cross = [](quad a, quad b) {
        const quad turned = a * __builtin_shufflevector(b, b, 1, 2, 0, 3)
            - b * __builtin_shufflevector(a, a, 1, 2, 0, 3);
        return __builtin_shufflevector(turned, turned, 1, 2, 0, 3);
    };
    const SCALAR *G = (const SCALAR*)gradients.data, factor = step_factors.data[1];
    const SCALAR mu = factor * lame.data[0], lambda = factor * lame.data[1];
    const int* pairs = (const int*)edge_corners.data;
    quad wise[3] = {}, swelling[3] = {}, from_a[3] = {}, from_b[3] = {};
    for (int k = edge_start.data[edge]; k < edge_start.data[edge + 1]; ++k) {
        const int a = pairs[2 * k], b = pairs[2 * k + 1];
        const SCALAR* first = G + 3 * (size_t)a;
        const quad second = at(G + 3 * (size_t)b);
        for (int i = 0; i < 3; ++i) wise[i] += first[i] * second;
        MORE
    }
    quad turned[3], rows[3], columns[3];
    transpose(wise[0], wise[1], wise[2], turned);
    const SCALAR along = mu * (wise[0][0] + wise[1][1] + wise[2][2]);
    for (int i = 0; i < 3; ++i) {
        rows[i] = lambda * OUTER[i] + mu * turned[i];
        rows[i][i] += along;
    }
    ENDING
    transpose(rows[0], rows[1], rows[2], columns);
    const int* slots = (const int*)edge_slots.data + 2 * edge;
    put((SCALAR*)values.data + 9 * (size_t)slots[0], rows[0], rows[1], rows[2]);
    put((SCALAR*)values.data + 9 * (size_t)slots[1], columns[0], columns[1], columns[2]);
"""

VOLUME = """
        const SCALAR* C = (const SCALAR*)volume_gradients.data;
        const quad face = at(C + 3 * (size_t)b);
        for (int i = 0; i < 3; ++i) swelling[i] += C[3 * (size_t)a + i] * face;
"""

COUPLING = """
        const SCALAR* Y = (const SCALAR*)couplings.data;
        for (int i = 0; i < 3; ++i) {
            from_a[i] += cross(second, at(Y + 9 * (size_t)a + 3 * i));
            from_b[i] += cross(at(first), at(Y + 9 * (size_t)b + 3 * i));
        }
"""

COUPLED = """
    transpose(from_b[0], from_b[1], from_b[2], turned);
    for (int i = 0; i < 3; ++i) rows[i] += factor * (from_a[i] + turned[i]);
"""


def _snippet(*, exact: bool, coupled: bool) -> str:
    more = (VOLUME if exact else "") + (COUPLING if coupled else "")
    text = EDGE.replace("MORE", more).replace("ENDING", COUPLED if coupled else "")
    return VECTORS + text.replace("OUTER", "swelling" if exact else "wise")


def edge_lanes_on(device: str, precision: str) -> SimpleNamespace | None:
    """The kernels of this module where a device is a processor; None elsewhere."""
    return make_edge_lanes(precision) if wp.get_device(device).is_cpu else None


@cache
def make_edge_lanes(precision: str) -> SimpleNamespace:
    """Kernels ``linear``, ``exact``, ``coupled_linear`` and ``coupled_exact``."""
    types = real(precision)
    scalar, vec3, mat33 = types.scalar, types.vec3, types.mat33
    kernel = types.kernel(SUBJECT)

    @types.native(_snippet(exact=False, coupled=False))
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

    @types.native(_snippet(exact=True, coupled=False))
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

    @types.native(_snippet(exact=False, coupled=True))
    def coupled_linear_edge(
        edge: int,
        edge_start: wp.array(dtype=int),
        edge_corners: wp.array(dtype=wp.vec2i),
        edge_slots: wp.array(dtype=wp.vec2i),
        lame: wp.array(dtype=scalar),
        step_factors: wp.array(dtype=scalar),
        gradients: wp.array(dtype=vec3),
        couplings: wp.array(dtype=mat33),
        values: wp.array(dtype=mat33),
    ): ...

    @types.native(_snippet(exact=True, coupled=True))
    def coupled_exact_edge(
        edge: int,
        edge_start: wp.array(dtype=int),
        edge_corners: wp.array(dtype=wp.vec2i),
        edge_slots: wp.array(dtype=wp.vec2i),
        lame: wp.array(dtype=scalar),
        step_factors: wp.array(dtype=scalar),
        gradients: wp.array(dtype=vec3),
        volume_gradients: wp.array(dtype=vec3),
        couplings: wp.array(dtype=mat33),
        values: wp.array(dtype=mat33),
    ): ...

    @kernel
    def linear(
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

    @types.kernel(SUBJECT, "exact")
    def exact(
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

    @types.kernel(SUBJECT, "coupled_linear")
    def coupled_linear(
        # model
        edge_start: wp.array(dtype=int),
        edge_corners: wp.array(dtype=wp.vec2i),
        edge_slots: wp.array(dtype=wp.vec2i),
        lame: wp.array(dtype=scalar),
        step_factors: wp.array(dtype=scalar),
        # in
        gradients: wp.array(dtype=vec3),
        couplings: wp.array(dtype=mat33),
        # out
        values: wp.array(dtype=mat33),
    ):
        # fmt: off
        coupled_linear_edge(
            wp.tid(), edge_start, edge_corners, edge_slots, lame, step_factors, gradients,
            couplings, values,
        )
        # fmt: on

    @types.kernel(SUBJECT, "coupled_exact")
    def coupled_exact(
        # model
        edge_start: wp.array(dtype=int),
        edge_corners: wp.array(dtype=wp.vec2i),
        edge_slots: wp.array(dtype=wp.vec2i),
        lame: wp.array(dtype=scalar),
        step_factors: wp.array(dtype=scalar),
        # in
        gradients: wp.array(dtype=vec3),
        volume_gradients: wp.array(dtype=vec3),
        couplings: wp.array(dtype=mat33),
        # out
        values: wp.array(dtype=mat33),
    ):
        # fmt: off
        coupled_exact_edge(
            wp.tid(), edge_start, edge_corners, edge_slots, lame, step_factors, gradients,
            volume_gradients, couplings, values,
        )
        # fmt: on

    return SimpleNamespace(
        linear=linear, exact=exact, coupled_linear=coupled_linear, coupled_exact=coupled_exact
    )
