"""Products of rows of 3 x 3 blocks with a vector.

The stiffness in M~ annihilates translations: its rows of blocks sum to zero. So a row of K times x
is the sum of its blocks beside the diagonal times the differences of x across the edges, and in
this form a common velocity of the nodes costs no rounding at all, however stiff the body. Where x
is ``before + change``, differences are taken of the two apart: rounding of a fast node's velocity
would else be a strain.

On processors the same is done in native code, a row of a block to a vector register, in the same
order and to the same last bit.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.precision import real

# Sums of the products by their columns, then over a row, unfused like those of the plain functions;
# nothing is read beyond a block or a vector. DIFFERENCE is that of x across the edge.
ROW = """
#pragma clang fp contract(off)
    typedef SCALAR quad __attribute__((vector_size(4 * sizeof(SCALAR)), aligned(sizeof(SCALAR))));
    const auto at = [](const SCALAR* x, int i) {
        return quad{x[3 * i], x[3 * i + 1], x[3 * i + 2], 0};
    };
    OWN
    quad y0 = {}, y1 = {}, y2 = {};
    const int last = row_start.data[i + 1];
    for (int k = row_start.data[i]; k < last; ++k) {
        const int j = column.data[k];
        const quad p = DIFFERENCE;
        const SCALAR* A = (const SCALAR*)values.data + 9 * k;
        const quad tail = *(const quad*)(A + 5);
        y0 += *(const quad*)A * p;
        y1 += *(const quad*)(A + 3) * p;
        y2 += __builtin_shufflevector(tail, tail, 1, 2, 3, 3) * p;
    }
    SCALAR* y = (SCALAR*)result.data + 3 * i;
    y[0] = y0[0] + y0[1] + y0[2];
    y[1] = y1[0] + y1[1] + y1[2];
    y[2] = y2[0] + y2[1] + y2[2];
"""

OF_ROW = ROW.replace("DIFFERENCE", "at(X, j) - own").replace(
    "OWN", "const SCALAR* X = (const SCALAR*)x.data; const quad own = at(X, i);"
)

OF_SUM = ROW.replace("DIFFERENCE", "(at(X, j) - own) + (at(D, j) - own_change)").replace(
    "OWN",
    "const SCALAR *X = (const SCALAR*)before.data, *D = (const SCALAR*)change.data;"
    "const quad own = at(X, i), own_change = at(D, i);",
)


@cache
def make_native_rows(precision: str, subject: str) -> SimpleNamespace:
    """``stiffness_of_row`` and ``stiffness_of_sum`` in native code, which write to ``work``."""
    types = real(precision)
    vec3, mat33 = types.vec3, types.mat33
    func = types.func(subject)

    @types.native(OF_ROW)
    def write_row(
        i: int,
        row_start: wp.array(dtype=int),
        column: wp.array(dtype=int),
        values: wp.array(dtype=mat33),
        x: wp.array(dtype=vec3),
        result: wp.array(dtype=vec3),
    ): ...

    @types.native(OF_SUM)
    def write_sum(
        i: int,
        row_start: wp.array(dtype=int),
        column: wp.array(dtype=int),
        values: wp.array(dtype=mat33),
        before: wp.array(dtype=vec3),
        change: wp.array(dtype=vec3),
        result: wp.array(dtype=vec3),
    ): ...

    @func
    def stiffness_of_row(
        i: int,
        row_start: wp.array(dtype=int),
        column: wp.array(dtype=int),
        values: wp.array(dtype=mat33),
        x: wp.array(dtype=vec3),
        work: wp.array(dtype=vec3),
    ):
        write_row(i, row_start, column, values, x, work)
        return work[i]

    @func
    def stiffness_of_sum(
        i: int,
        row_start: wp.array(dtype=int),
        column: wp.array(dtype=int),
        values: wp.array(dtype=mat33),
        before: wp.array(dtype=vec3),
        change: wp.array(dtype=vec3),
        work: wp.array(dtype=vec3),
    ):
        write_sum(i, row_start, column, values, before, change, work)
        return work[i]

    return SimpleNamespace(stiffness_of_row=stiffness_of_row, stiffness_of_sum=stiffness_of_sum)


@cache
def make_rows(precision: str, subject: str) -> SimpleNamespace:
    """Functions ``part_of_row``, ``stiffness_of_row`` and ``stiffness_of_sum``."""
    types = real(precision)
    scalar, vec3, mat33 = types.scalar, types.vec3, types.mat33
    func = types.func(subject)

    @func
    def part_of_row(
        first: int,
        last: int,
        column: wp.array(dtype=int),
        values: wp.array(dtype=mat33),
        x: wp.array(dtype=vec3),
    ):
        # sum of values[k] x[column[k]]; summing the nine products apart keeps them in vector
        # registers until the end, which takes two thirds of the time of a matrix product a block
        products = mat33()
        k = first
        while k < last:
            p = x[column[k]]
            products += wp.cw_mul(
                values[k], mat33(p[0], p[1], p[2], p[0], p[1], p[2], p[0], p[1], p[2])
            )
            k += 1
        return products * vec3(scalar(1.0), scalar(1.0), scalar(1.0))

    @func
    def stiffness_of_row(
        i: int,
        row_start: wp.array(dtype=int),
        column: wp.array(dtype=int),
        values: wp.array(dtype=mat33),
        x: wp.array(dtype=vec3),
    ):
        # (M~ - (1 + dt mu) M) x at a node; the diagonal block meets a difference of zero
        own = x[i]
        products = mat33()
        k = row_start[i]
        last = row_start[i + 1]
        while k < last:
            p = x[column[k]] - own
            products += wp.cw_mul(
                values[k], mat33(p[0], p[1], p[2], p[0], p[1], p[2], p[0], p[1], p[2])
            )
            k += 1
        return products * vec3(scalar(1.0), scalar(1.0), scalar(1.0))

    @func
    def stiffness_of_sum(
        i: int,
        row_start: wp.array(dtype=int),
        column: wp.array(dtype=int),
        values: wp.array(dtype=mat33),
        before: wp.array(dtype=vec3),
        change: wp.array(dtype=vec3),
    ):
        # the same for x = before + change
        own_before = before[i]
        own_change = change[i]
        products = mat33()
        k = row_start[i]
        last = row_start[i + 1]
        while k < last:
            j = column[k]
            p = (before[j] - own_before) + (change[j] - own_change)
            products += wp.cw_mul(
                values[k], mat33(p[0], p[1], p[2], p[0], p[1], p[2], p[0], p[1], p[2])
            )
            k += 1
        return products * vec3(scalar(1.0), scalar(1.0), scalar(1.0))

    return SimpleNamespace(
        part_of_row=part_of_row,
        stiffness_of_row=stiffness_of_row,
        stiffness_of_sum=stiffness_of_sum,
    )


@cache
def make_plain_rows(precision: str, subject: str) -> SimpleNamespace:
    """The plain functions with the arguments of the native ones."""
    types = real(precision)
    vec3, mat33 = types.vec3, types.mat33
    func = types.func(subject)
    rows = make_rows(precision, subject)
    one_row, whole_row = rows.stiffness_of_row, rows.stiffness_of_sum

    @func
    def stiffness_of_row(
        i: int,
        row_start: wp.array(dtype=int),
        column: wp.array(dtype=int),
        values: wp.array(dtype=mat33),
        x: wp.array(dtype=vec3),
        work: wp.array(dtype=vec3),
    ):
        return one_row(i, row_start, column, values, x)

    @func
    def stiffness_of_sum(
        i: int,
        row_start: wp.array(dtype=int),
        column: wp.array(dtype=int),
        values: wp.array(dtype=mat33),
        before: wp.array(dtype=vec3),
        change: wp.array(dtype=vec3),
        work: wp.array(dtype=vec3),
    ):
        return whole_row(i, row_start, column, values, before, change)

    return SimpleNamespace(stiffness_of_row=stiffness_of_row, stiffness_of_sum=stiffness_of_sum)
