"""Solves with the block factor L D L^T by panels: runs of columns that share their rows.

A panel is kept by columns, so that y -= L z runs over 16 rows at once, and by rows, so that
z -= L^T y runs over all its columns. ``warp_softbody.linear.supernodes`` lays the panels out. One
logical thread walks the runs. The walk is native code: on Warp's arrays, the reckoning of indices
would take three times as long as the arithmetic.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.precision import BLOCK, real

SUBJECT = "supernodes"

PACK = """
    const int s = owner.data[k], nodes = first.data[s + 1] - first.data[s];
    const int row = 3 * (k - below_start.data[s]);
    SCALAR* rows = (SCALAR*)by_row.data + 3 * LANES * k;
    for (int a = 0; a < 3; ++a) {
        const int group = panel_start.data[s] + (row + a) / LANES * 3 * nodes;
        SCALAR* columns = (SCALAR*)by_column.data + LANES * group + (row + a) % LANES;
        for (int j = 0; j < nodes; ++j) {
            const int slot = below_slot.data[WIDEST * k + j];
            if (slot < 0) continue;
            const SCALAR* entry = (const SCALAR*)lower.data + 9 * slot + 3 * a;
            for (int b = 0; b < 3; ++b) {
                columns[LANES * (3 * j + b)] = entry[b];
                rows[LANES * a + 3 * j + b] = entry[b];
            }
        }
    }
""".replace("WIDEST", str(BLOCK // 3))

FORWARD = """
    SCALAR* y = work.data;
    for (int i = 0; i < count; ++i) {
        const SCALAR* Q = (const SCALAR*)turns.data + 9 * order.data[i];
        const SCALAR* r = (const SCALAR*)residual.data + 3 * order.data[i];
        for (int a = 0; a < 3; ++a)
            y[3 * i + a] = Q[a] * r[0] + Q[3 + a] * r[1] + Q[6 + a] * r[2];
    }
    const SCALAR* panels = (const SCALAR*)by_column.data;
    const SCALAR* L = (const SCALAR*)lower.data;
    const int* target = targets.data;
    for (int s = 0; s < runs; ++s) {
        const int start = first.data[s], end = first.data[s + 1], width = 3 * (end - start);
        for (int i = start + 1; i < end; ++i) {
            SCALAR sum0 = 0, sum1 = 0, sum2 = 0;
            for (int t = inner_start.data[i]; t < row_start.data[i + 1]; ++t) {
                const SCALAR* l = L + 9 * t;
                const SCALAR* z = y + 3 * column.data[t];
                sum0 += l[0] * z[0] + l[1] * z[1] + l[2] * z[2];
                sum1 += l[3] * z[0] + l[4] * z[1] + l[5] * z[2];
                sum2 += l[6] * z[0] + l[7] * z[1] + l[8] * z[2];
            }
            y[3 * i] -= sum0;
            y[3 * i + 1] -= sum1;
            y[3 * i + 2] -= sum2;
        }
        for (int panel = panel_start.data[s]; panel < panel_start.data[s + 1]; panel += width) {
            SCALAR known[LANES] = {};
            for (int c = 0; c < width; ++c) {
                const SCALAR z = y[3 * start + c];
                const SCALAR* p = panels + LANES * (panel + c);
                for (int l = 0; l < LANES; ++l) known[l] += z * p[l];
            }
            for (int l = 0; l < LANES; ++l) y[target[l]] -= known[l];
            target += LANES;
        }
    }
"""

BACKWARD = """
    SCALAR* y = work.data;
    for (int i = 0; i < count; ++i) {
        const SCALAR* D = (const SCALAR*)pivot_inverse.data + 9 * i;
        const SCALAR z0 = y[3 * i], z1 = y[3 * i + 1], z2 = y[3 * i + 2];
        for (int a = 0; a < 3; ++a)
            y[3 * i + a] = D[3 * a] * z0 + D[3 * a + 1] * z1 + D[3 * a + 2] * z2;
    }
    const SCALAR* panels = (const SCALAR*)by_row.data;
    const SCALAR* L = (const SCALAR*)lower.data;
    for (int s = runs - 1; s >= 0; --s) {
        const int start = first.data[s], end = first.data[s + 1], width = 3 * (end - start);
        SCALAR known[LANES] = {};
        for (int k = below_start.data[s]; k < below_start.data[s + 1]; ++k) {
            const SCALAR* z = y + 3 * below.data[k];
            const SCALAR* p = panels + 3 * LANES * k;
            const SCALAR z0 = z[0], z1 = z[1], z2 = z[2];
            for (int l = 0; l < LANES; ++l)
                known[l] += z0 * p[l] + z1 * p[LANES + l] + z2 * p[2 * LANES + l];
        }
        for (int c = 0; c < width; ++c) y[3 * start + c] -= known[c];
        for (int i = end - 1; i > start; --i) {
            const SCALAR z0 = y[3 * i], z1 = y[3 * i + 1], z2 = y[3 * i + 2];
            for (int t = inner_start.data[i]; t < row_start.data[i + 1]; ++t) {
                const SCALAR* l = L + 9 * t;
                SCALAR* x = y + 3 * column.data[t];
                x[0] -= l[0] * z0 + l[3] * z1 + l[6] * z2;
                x[1] -= l[1] * z0 + l[4] * z1 + l[7] * z2;
                x[2] -= l[2] * z0 + l[5] * z1 + l[8] * z2;
            }
        }
    }
    for (int i = 0; i < count; ++i) {
        const SCALAR* Q = (const SCALAR*)turns.data + 9 * order.data[i];
        SCALAR* z = (SCALAR*)result.data + 3 * order.data[i];
        for (int a = 0; a < 3; ++a)
            z[a] = Q[3 * a] * y[3 * i] + Q[3 * a + 1] * y[3 * i + 1] + Q[3 * a + 2] * y[3 * i + 2];
    }
"""


@wp.struct
class PanelStructure:
    """Where the blocks of a factor of n columns in s runs stand, as `linear.supernodes` has it.

    Attributes:
        count, runs: n and s.
        order: (n,) node of each column.
        row_start, column: CSR of the blocks of L.
        first: (s + 1,) first column of each run, and the end.
        inner_start: (n,) first block of each row that lies within its run.
        below_start, below: CSR of the rows below each run.
        panel_start: (s + 1,) first register by columns of each run, and the end.
        targets: component that each lane of a register by columns is of; 3 n for none.
    """

    count: int
    runs: int
    order: wp.array(dtype=int)
    row_start: wp.array(dtype=int)
    column: wp.array(dtype=int)
    first: wp.array(dtype=int)
    inner_start: wp.array(dtype=int)
    below_start: wp.array(dtype=int)
    below: wp.array(dtype=int)
    panel_start: wp.array(dtype=int)
    targets: wp.array(dtype=int)


@cache
def make_supernodes(precision: str) -> SimpleNamespace:
    """Kernels ``pack`` and ``precondition``."""
    types = real(precision)
    scalar, vec3, mat33, block = types.scalar, types.vec3, types.mat33, types.block
    kernel = types.kernel(SUBJECT)
    native = types.native

    @native(PACK)
    def pack_row(
        k: int,
        first: wp.array(dtype=int),
        below_start: wp.array(dtype=int),
        below_slot: wp.array2d(dtype=int),
        owner: wp.array(dtype=int),
        panel_start: wp.array(dtype=int),
        lower: wp.array(dtype=mat33),
        by_column: wp.array(dtype=block),
        by_row: wp.array(dtype=block),
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
        by_column: wp.array(dtype=block),
        by_row: wp.array(dtype=block),
    ):
        # the padding stays zero
        k = wp.tid()
        pack_row(k, first, below_start, below_slot, owner, panel_start, lower, by_column, by_row)

    @native(FORWARD)
    def forward(
        count: int,
        runs: int,
        order: wp.array(dtype=int),
        row_start: wp.array(dtype=int),
        column: wp.array(dtype=int),
        first: wp.array(dtype=int),
        inner_start: wp.array(dtype=int),
        panel_start: wp.array(dtype=int),
        targets: wp.array(dtype=int),
        lower: wp.array(dtype=mat33),
        by_column: wp.array(dtype=block),
        turns: wp.array(dtype=mat33),
        residual: wp.array(dtype=vec3),
        work: wp.array(dtype=scalar),
    ): ...

    @native(BACKWARD)
    def backward(
        count: int,
        runs: int,
        order: wp.array(dtype=int),
        row_start: wp.array(dtype=int),
        column: wp.array(dtype=int),
        first: wp.array(dtype=int),
        inner_start: wp.array(dtype=int),
        below_start: wp.array(dtype=int),
        below: wp.array(dtype=int),
        lower: wp.array(dtype=mat33),
        by_row: wp.array(dtype=block),
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
        lower: wp.array(dtype=mat33),
        by_column: wp.array(dtype=block),
        by_row: wp.array(dtype=block),
        pivot_inverse: wp.array(dtype=mat33),
        turns: wp.array(dtype=mat33),
        residual: wp.array(dtype=vec3),
        # out
        work: wp.array(dtype=scalar),
        result: wp.array(dtype=vec3),
    ):
        # fmt: off
        forward(
            at.count, at.runs, at.order, at.row_start, at.column, at.first, at.inner_start,
            at.panel_start, at.targets, lower, by_column, turns, residual, work,
        )
        backward(
            at.count, at.runs, at.order, at.row_start, at.column, at.first, at.inner_start,
            at.below_start, at.below, lower, by_row, pivot_inverse, turns, work, result,
        )
        # fmt: on

    return SimpleNamespace(pack=pack, precondition=precondition)
