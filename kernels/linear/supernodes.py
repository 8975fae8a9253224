"""Solves with the block factor L D L^T by panels: runs of columns that share their rows.

``warp_softbody.linear.supernodes`` lays the panels out: a register holds 16 rows of one column. A
solve walks the runs, first to last and back, in one logical thread and in native code for
processors. Both ways read the same panels, so that the way back finds small factors in the cache.
``warped_ldlt`` has the plain form, which runs on every other device and is the tests' reference.

Vectors have four numbers a node here, the last of them zero. Panels may be in half precision: of a
factor that no cache holds, a solve waits for them. L is the same both ways, so that L D L^T stays
symmetric and positive definite when it is rounded.
"""

from functools import cache
from types import SimpleNamespace
from typing import Any

import warp as wp

from warp_softbody.kernels.precision import BLOCK, real

SUBJECT = "supernodes"

MOST_OF_HALF = 65504.0
"""Largest number of half precision; more would be infinite."""

AHEAD = 8192
"""Bytes of panels that are asked for before they are needed.

They stand in one piece, but processors fetch ahead by themselves within a page of 4 kB alone."""

PACK = """
    const int s = owner.data[k], nodes = first.data[s + 1] - first.data[s];
    const int row = 3 * (k - below_start.data[s]);
    for (int a = 0; a < 3; ++a) {
        const int group = panel_start.data[s] + (row + a) / LANES * 3 * nodes;
        STORED* columns = (STORED*)panels.data + LANES * (size_t)group + (row + a) % LANES;
        for (int j = 0; j < nodes; ++j) {
            const int slot = below_slot.data[WIDEST * k + j];
            if (slot < 0) continue;
            const SCALAR* entry = (const SCALAR*)lower.data + 9 * (size_t)slot + 3 * a;
            for (int b = 0; b < 3; ++b) {
                SCALAR x = entry[b];
                if (sizeof(STORED) < sizeof(float)) x = x < -MOST ? -MOST : x > MOST ? MOST : x;
                columns[LANES * (3 * j + b)] = (STORED)x;
            }
        }
    }
""".replace("WIDEST", str(BLOCK // 3)).replace("MOST", f"(SCALAR){MOST_OF_HALF}")

# ``by_width`` calls work with the number of a run's columns, known when it is compiled; ``rows_of``
# has the rows of a 3 x 3 matrix with something behind them, ``times`` its product with a vector.
COMMON = """
#pragma clang fp contract(fast)
    typedef SCALAR lanes __attribute__((vector_size(LANES * sizeof(SCALAR)),
                                        aligned(sizeof(SCALAR))));
    typedef SCALAR quad __attribute__((vector_size(4 * sizeof(SCALAR)), aligned(sizeof(SCALAR))));
    typedef STORED stored __attribute__((vector_size(LANES * sizeof(STORED)),
                                         aligned(sizeof(STORED))));
    const auto wide = [](stored p) { return __builtin_convertvector(p, lanes); };
    struct Columns3 { enum { count = 3 }; };
    struct Columns6 { enum { count = 6 }; };
    struct Columns9 { enum { count = 9 }; };
    struct Columns12 { enum { count = 12 }; };
    struct Columns15 { enum { count = 15 }; };
    const auto by_width = [](int nodes, auto work) {
        if (nodes == 1) work(Columns3{});
        else if (nodes == 2) work(Columns6{});
        else if (nodes == 3) work(Columns9{});
        else if (nodes == 4) work(Columns12{});
        else work(Columns15{});
    };
    const auto rows_of = [](const SCALAR* from, quad* to) {
        const quad last = *(const quad*)(from + 5);
        to[0] = *(const quad*)from;
        to[1] = *(const quad*)(from + 3);
        to[2] = __builtin_shufflevector(last, last, 1, 2, 3, 0);
    };
    // the sums of a, b and c
    const auto sums = [](quad a, quad b, quad c) {
        const quad zero = {};
        const quad ab = __builtin_shufflevector(a, b, 0, 4, 1, 5)
            + __builtin_shufflevector(a, b, 2, 6, 3, 7);
        const quad cd = __builtin_shufflevector(c, zero, 0, 4, 1, 5)
            + __builtin_shufflevector(c, zero, 2, 6, 3, 7);
        return __builtin_shufflevector(ab, cd, 0, 1, 4, 5)
            + __builtin_shufflevector(ab, cd, 2, 3, 6, 7);
    };
    quad* y = (quad*)work.data;
    SCALAR* beside = work.data + 4 * count;
    const stored* panel = (const stored*)panels.data;
    const SCALAR* L = (const SCALAR*)inner.data;
"""

FORWARD = (
    COMMON
    + """
    for (int i = 0; i < count; ++i) {
        quad Q[3];
        rows_of((const SCALAR*)turns.data + 9 * order.data[i], Q);
        const SCALAR* r = (const SCALAR*)residual.data + 3 * order.data[i];
        quad turned = Q[0] * r[0] + Q[1] * r[1] + Q[2] * r[2];
        turned[3] = 0;
        y[i] = turned;
    }
    const char *line = (const char*)panel, *last = (const char*)(panel + panel_start.data[runs]);
    for (int s = 0; s < runs; ++s) {
        const int start = first.data[s], end = first.data[s + 1];
        const char* far = (const char*)(panel + panel_start.data[s + 1]) + AHEAD;
        for (; line < far && line < last; line += 64) __builtin_prefetch(line);
        for (int i = start + 1; i < end; ++i) {
            quad known0 = {}, known1 = {}, known2 = {};
            const int to = inner_start.data[i + 1];
            for (int t = inner_start.data[i], j = i - (to - t); t < to; ++t, ++j) {
                quad l[3];
                rows_of(L + 9 * t, l);
                known0 += l[0] * y[j];
                known1 += l[1] * y[j];
                known2 += l[2] * y[j];
            }
            y[i] -= sums(known0, known1, known2);
        }
        const int rows = below_start.data[s + 1] - below_start.data[s];
        by_width(end - start, [&](auto columns) {
            enum { width = decltype(columns)::count };
            lanes z[width];
            for (int c = 0; c < width; ++c) z[c] = lanes{} + y[start + c / 3][c % 3];
            const stored* p = panel + panel_start.data[s];
            for (int row = 0; row < 3 * rows; row += LANES, p += width) {
                lanes known = {};
                for (int c = 0; c < width; ++c) known += z[c] * wide(p[c]);
                *(lanes*)(beside + row) = known;
            }
        });
        for (int k = 0; k < rows; ++k) {
            quad known = *(const quad*)(beside + 3 * k);
            known[3] = 0;
            y[below.data[below_start.data[s] + k]] -= known;
        }
    }
""".replace("AHEAD", str(AHEAD))
)

BACKWARD = (
    COMMON
    + """
#if defined(__AVX512F__)
    enum { AT_ONCE = 15 };
#else
    enum { AT_ONCE = 3 };
#endif
    for (int s = runs - 1; s >= 0; --s) {
        const int start = first.data[s], end = first.data[s + 1];
        const int rows = below_start.data[s + 1] - below_start.data[s];
        for (int k = 0; k < rows; ++k)
            *(quad*)(beside + 3 * k) = y[below.data[below_start.data[s] + k]];
        *(lanes*)(beside + 3 * rows) = lanes{};
        for (int i = start; i < end; ++i) {
            // symmetric
            quad D[3];
            rows_of((const SCALAR*)pivot_inverse.data + 9 * i, D);
            quad z = D[0] * y[i][0] + D[1] * y[i][1] + D[2] * y[i][2];
            z[3] = 0;
            y[i] = z;
        }
        by_width(end - start, [&](auto columns) {
            enum { width = decltype(columns)::count };
            enum { at_once = width < AT_ONCE ? width : AT_ONCE };
            for (int from = 0; from < width; from += at_once) {
                lanes known[at_once] = {};
                const stored* p = panel + panel_start.data[s] + from;
                for (int row = 0; row < 3 * rows; row += LANES, p += width)
                    for (int c = 0; c < at_once; ++c)
                        known[c] += *(const lanes*)(beside + row) * wide(p[c]);
                for (int c = 0; c < at_once; c += 3) {
                    quad part[3];
                    for (int a = 0; a < 3; ++a) {
                        const lanes v = known[c + a];
                        part[a] = (__builtin_shufflevector(v, v, 0, 1, 2, 3)
                                   + __builtin_shufflevector(v, v, 4, 5, 6, 7))
                            + (__builtin_shufflevector(v, v, 8, 9, 10, 11)
                               + __builtin_shufflevector(v, v, 12, 13, 14, 15));
                    }
                    y[start + (from + c) / 3] -= sums(part[0], part[1], part[2]);
                }
            }
        });
        for (int i = end - 1; i > start; --i) {
            const quad z = y[i];
            const int to = inner_start.data[i + 1];
            for (int t = inner_start.data[i], j = i - (to - t); t < to; ++t, ++j) {
                quad l[3];
                rows_of(L + 9 * t, l);
                quad left = y[j] - (l[0] * z[0] + l[1] * z[1] + l[2] * z[2]);
                left[3] = 0;
                y[j] = left;
            }
        }
        for (int i = start; i < end; ++i) {
            quad Q[3];
            rows_of((const SCALAR*)turns.data + 9 * order.data[i], Q);
            const quad turned = sums(Q[0] * y[i], Q[1] * y[i], Q[2] * y[i]);
            SCALAR* z = (SCALAR*)result.data + 3 * order.data[i];
            for (int a = 0; a < 3; ++a) z[a] = turned[a];
        }
    }
"""
)


@wp.struct
class PanelStructure:
    """Where the blocks of a factor of n columns in s runs stand, as `linear.supernodes` has it.

    Attributes:
        count, runs: n and s.
        order: (n,) node of each column.
        first: (s + 1,) first column of each run, and the end.
        inner_start: (n + 1,) first of the blocks within runs by row, and the end.
        below_start, below: CSR of the rows below each run.
        panel_start: (s + 1,) first register of each run, and the end.
    """

    count: int
    runs: int
    order: wp.array(dtype=int)
    first: wp.array(dtype=int)
    inner_start: wp.array(dtype=int)
    below_start: wp.array(dtype=int)
    below: wp.array(dtype=int)
    panel_start: wp.array(dtype=int)


@cache
def make_supernodes(precision: str, *, half: bool = False) -> SimpleNamespace:
    """Kernels ``pack``, ``pack_inner`` and ``precondition``, of panels in half precision or not.

    ``block`` is the type of a panel's register.
    """
    types = real(precision)
    scalar, vec3, mat33, block = types.scalar, types.vec3, types.mat33, types.block
    if half:
        block = wp.types.vector(length=BLOCK, dtype=wp.float16)
    kernel = types.kernel(SUBJECT, "half" if half else "")
    stored = "_Float16" if half else "SCALAR"

    def native(snippet: str) -> Any:
        return types.native(snippet.replace("STORED", stored))

    @native(PACK)
    def pack_row(
        k: int,
        first: wp.array(dtype=int),
        below_start: wp.array(dtype=int),
        below_slot: wp.array2d(dtype=int),
        owner: wp.array(dtype=int),
        panel_start: wp.array(dtype=int),
        lower: wp.array(dtype=mat33),
        panels: wp.array(dtype=block),
    ): ...

    @kernel
    def pack(
        # model
        first: wp.array(dtype=int),
        below_start: wp.array(dtype=int),
        below_slot: wp.array2d(dtype=int),
        owner: wp.array(dtype=int),
        panel_start: wp.array(dtype=int),
        # in
        lower: wp.array(dtype=mat33),
        # out
        panels: wp.array(dtype=block),
    ):
        # the padding stays zero
        pack_row(wp.tid(), first, below_start, below_slot, owner, panel_start, lower, panels)

    @kernel
    def pack_inner(
        # model
        inner_slot: wp.array(dtype=int),
        # in
        lower: wp.array(dtype=mat33),
        # out
        inner: wp.array(dtype=mat33),
    ):
        k = wp.tid()
        inner[k] = lower[inner_slot[k]]

    @native(FORWARD)
    def forward(
        count: int,
        runs: int,
        order: wp.array(dtype=int),
        first: wp.array(dtype=int),
        inner_start: wp.array(dtype=int),
        below_start: wp.array(dtype=int),
        below: wp.array(dtype=int),
        panel_start: wp.array(dtype=int),
        inner: wp.array(dtype=mat33),
        panels: wp.array(dtype=block),
        turns: wp.array(dtype=mat33),
        residual: wp.array(dtype=vec3),
        work: wp.array(dtype=scalar),
    ): ...

    @native(BACKWARD)
    def backward(
        count: int,
        runs: int,
        order: wp.array(dtype=int),
        first: wp.array(dtype=int),
        inner_start: wp.array(dtype=int),
        below_start: wp.array(dtype=int),
        below: wp.array(dtype=int),
        panel_start: wp.array(dtype=int),
        inner: wp.array(dtype=mat33),
        panels: wp.array(dtype=block),
        pivot_inverse: wp.array(dtype=mat33),
        turns: wp.array(dtype=mat33),
        work: wp.array(dtype=scalar),
        result: wp.array(dtype=vec3),
    ): ...

    @kernel
    def precondition(
        # model
        at: PanelStructure,
        # in
        inner: wp.array(dtype=mat33),
        panels: wp.array(dtype=block),
        pivot_inverse: wp.array(dtype=mat33),
        turns: wp.array(dtype=mat33),
        residual: wp.array(dtype=vec3),
        # out
        work: wp.array(dtype=scalar),
        result: wp.array(dtype=vec3),
    ):
        # fmt: off
        forward(
            at.count, at.runs, at.order, at.first, at.inner_start, at.below_start, at.below,
            at.panel_start, inner, panels, turns, residual, work,
        )
        backward(
            at.count, at.runs, at.order, at.first, at.inner_start, at.below_start, at.below,
            at.panel_start, inner, panels, pivot_inverse, turns, work, result,
        )
        # fmt: on

    return SimpleNamespace(pack=pack, pack_inner=pack_inner, precondition=precondition, block=block)
