"""Gauss-Seidel sweeps in native code, for processors; each reads half of the symmetric matrix.

A sweep goes through the blocks before the diagonal alone. When a row of them is in the first-level
cache for its own sum, its transpose is added to the rows before it, which saves the second half of
the memory's traffic. So a forward sweep from zero leaves the residual behind it at no further
read, and a backward sweep knows of the nodes that it has passed without reading their blocks.
Blocks are read four numbers at a time; what stands beside a row of three is left as it is.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.linear.transfer_lanes import make_transfer_lanes
from warp_softbody.kernels.linear.two_level import SUBJECT as TWO_LEVEL
from warp_softbody.kernels.precision import real

SUBJECT = f"{TWO_LEVEL}_lanes"

ROWS_AHEAD = 12
"""Rows whose blocks a sweep fetches ahead: processors foresee no gaps and no falling addresses."""

# Four numbers stand for a node in ``x`` and ``sums``, so that no store overlaps the load of another
# node; the last of them is never read.
PARTS = """
#pragma clang fp contract(fast)
    typedef SCALAR quad __attribute__((vector_size(4 * sizeof(SCALAR)), aligned(sizeof(SCALAR))));
    const SCALAR *A = (const SCALAR*)values.data, *P = (const SCALAR*)pivot_inverse.data;
    const int *rows = row_start.data, *diagonal = diagonal_slot.data, *columns = column.data;
    const int count = (int)diagonal_slot.shape[0];
    const SCALAR* r = (const SCALAR*)residual.data;
    quad *x = (quad*)z.data, *sums = (quad*)behind.data;
    // P (right - sum of the blocks before the diagonal times x)
    const auto relaxed = [&](int i, quad right) {
        quad y0 = {}, y1 = {}, y2 = {};
        for (int k = rows[i]; k < diagonal[i]; ++k) {
            const SCALAR* a = A + 9 * (size_t)k;
            const quad other = x[columns[k]];
            y0 += *(const quad*)a * other;
            y1 += *(const quad*)(a + 3) * other;
            y2 += *(const quad*)(a + 6) * other;
        }
        const quad low = __builtin_shufflevector(y0, y1, 0, 4, 1, 5);
        const quad high = __builtin_shufflevector(y0, y1, 2, 6, 3, 7);
        const quad s = right - __builtin_shufflevector(low, y2, 0, 1, 4, 4)
            - __builtin_shufflevector(low, y2, 2, 3, 5, 5)
            - __builtin_shufflevector(high, y2, 0, 1, 6, 6);
        const SCALAR* p = P + 9 * (size_t)i;
        const quad tail = *(const quad*)(p + 5);
        return *(const quad*)p * s[0] + *(const quad*)(p + 3) * s[1]
            + __builtin_shufflevector(tail, tail, 1, 2, 3, 3) * s[2];
    };
    const auto spread = [&](int i, quad own) {
        const SCALAR x0 = own[0], x1 = own[1], x2 = own[2];
        for (int k = rows[i]; k < diagonal[i]; ++k) {
            const SCALAR* a = A + 9 * (size_t)k;
            sums[columns[k]] += *(const quad*)a * x0 + *(const quad*)(a + 3) * x1
                + *(const quad*)(a + 6) * x2;
        }
    };
    const auto fetch = [&](int i) {
        const int row = i < 0 ? 0 : i < count ? i : count - 1;
        const char* line = (const char*)(A + 9 * (size_t)rows[row]);
        const char* end = (const char*)(A + 9 * (size_t)diagonal[row]);
        for (; line < end; line += 64) __builtin_prefetch(line);
    };
    for (int i = 0; i < count; ++i) sums[i] = quad{};
"""

FORWARD = (
    PARTS
    + """
    for (int i = 0; i < count; ++i) {
        fetch(i + AHEAD);
        const quad own = relaxed(i, quad{r[3 * i], r[3 * i + 1], r[3 * i + 2], 0});
        x[i] = own;
        spread(i, own);
    }
""".replace("AHEAD", str(ROWS_AHEAD))
)

BACKWARD = (
    PARTS
    + """
    SCALAR* out = (SCALAR*)result.data;
    for (int i = count - 1; i >= 0; --i) {
        fetch(i - AHEAD);
        const quad own = relaxed(i, quad{r[3 * i], r[3 * i + 1], r[3 * i + 2], 0} - sums[i]);
        for (int a = 0; a < 3; ++a) out[3 * i + a] = own[a];
        spread(i, own);
    }
""".replace("AHEAD", str(ROWS_AHEAD))
)


def sweep_lanes_on(device: str, precision: str) -> SimpleNamespace | None:
    """The kernels of this module where a device is a processor; None elsewhere."""
    return make_sweep_lanes(precision) if wp.get_device(device).is_cpu else None


@cache
def make_sweep_lanes(precision: str) -> SimpleNamespace:
    """Kernels of one application, in the order of their launch."""
    types = real(precision)
    vec3, vec4, mat33 = types.vec3, types.vec4, types.mat33
    kernel = types.kernel(SUBJECT)

    @types.native(FORWARD)
    def forward(
        row_start: wp.array(dtype=int),
        column: wp.array(dtype=int),
        diagonal_slot: wp.array(dtype=int),
        values: wp.array(dtype=mat33),
        pivot_inverse: wp.array(dtype=mat33),
        residual: wp.array(dtype=vec3),
        z: wp.array(dtype=vec4),
        behind: wp.array(dtype=vec4),
    ): ...

    @types.native(BACKWARD)
    def backward(
        row_start: wp.array(dtype=int),
        column: wp.array(dtype=int),
        diagonal_slot: wp.array(dtype=int),
        values: wp.array(dtype=mat33),
        pivot_inverse: wp.array(dtype=mat33),
        residual: wp.array(dtype=vec3),
        z: wp.array(dtype=vec4),
        behind: wp.array(dtype=vec4),
        result: wp.array(dtype=vec3),
    ): ...

    @kernel
    def sweep_forward(
        # model
        row_start: wp.array(dtype=int),
        column: wp.array(dtype=int),
        diagonal_slot: wp.array(dtype=int),
        # in
        values: wp.array(dtype=mat33),
        pivot_inverse: wp.array(dtype=mat33),
        residual: wp.array(dtype=vec3),
        # out
        z: wp.array(dtype=vec4),
        behind: wp.array(dtype=vec4),
    ):
        # ``behind``: what stands behind the diagonal times z, minus the residual that is left
        # fmt: off
        forward(
            row_start, column, diagonal_slot, values, pivot_inverse, residual, z, behind,
        )
        # fmt: on

    @kernel
    def sweep_backward(
        # model
        row_start: wp.array(dtype=int),
        column: wp.array(dtype=int),
        diagonal_slot: wp.array(dtype=int),
        # in
        values: wp.array(dtype=mat33),
        pivot_inverse: wp.array(dtype=mat33),
        residual: wp.array(dtype=vec3),
        z: wp.array(dtype=vec4),
        # out
        behind: wp.array(dtype=vec4),
        result: wp.array(dtype=vec3),
    ):
        # ``z``: what the forward sweep left, corrected
        # fmt: off
        backward(
            row_start, column, diagonal_slot, values, pivot_inverse, residual, z, behind, result,
        )
        # fmt: on

    transfer = make_transfer_lanes(precision)
    return SimpleNamespace(
        sweep_forward=sweep_forward,
        restrict_residual=transfer.restrict_residual,
        prolong=transfer.prolong,
        sweep_backward=sweep_backward,
    )
