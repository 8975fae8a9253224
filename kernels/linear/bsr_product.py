"""Products of rows of 3 x 3 blocks with a vector.

The stiffness in M~ annihilates translations: its rows of blocks sum to zero. So a row of K times x
is the sum of its blocks beside the diagonal times the differences of x across the edges, and in
this form a common velocity of the nodes costs no rounding at all, however stiff the body. Where x
is ``before + change``, differences are taken of the two apart: rounding of a fast node's velocity
would else be a strain.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.precision import real


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
