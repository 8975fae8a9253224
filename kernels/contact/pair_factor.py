"""A factor of the pairs' Delassus matrix, for rows that nearly repeat each other.

Where many nodes strike few triangles, as those of a round thing that moves fast, rows are dependent
but for what their normals differ by. Conjugate gradients then end far from the solution, what is
projected with it keeps part of the rows, and the solve around it diverges. A Cholesky factor with
pivots (Higham, Analysis of the Cholesky decomposition of a semi-definite matrix, 1990) leaves out
the rows that others hold already, and is exact for the rest.
"""

from types import SimpleNamespace
from typing import Any

import warp as wp

from warp_softbody.kernels.contact.modes import Mode
from warp_softbody.kernels.contact.structs import make_pair_structs
from warp_softbody.kernels.linear.structs import make_linear_structs
from warp_softbody.kernels.precision import real
from warp_softbody.kernels.widening import make_widening

MOST_ROWS = 384
"""Rows of the largest factor; three for a pair that sticks, one for one that slides."""

LEAST_PIVOT = 1e-9
"""Of the largest pivot, below which a row counts as held by others: of what it is given, the
others then leave it to the square root of this."""


def make_pair_factor(precision: str, subject: str, apply: Any) -> SimpleNamespace:
    """Functions ``factorise`` and ``solve_factor``; ``apply`` multiplies with the matrix."""
    func = real(precision).func(subject)
    wide = make_widening(precision, subject).wide
    structs = make_pair_structs(precision)
    Pairs, DelassusWork = structs.Pairs, structs.DelassusWork
    NodeConstraints = make_linear_structs(precision).NodeConstraints
    vec3d = wp.vec3d
    most = wp.constant(MOST_ROWS)
    least = wp.constant(wp.float64(LEAST_PIVOT))
    zero = wp.constant(wp.float64(0.0))

    @func
    def row_axis(pairs: Pairs, modes: wp.array(dtype=int), code: int):
        # the direction of a row, whose pair is code / 3 of the active ones
        c = pairs.active[code / 3]
        if modes[c] == Mode.STICK:
            axis = vec3d()
            axis[code % 3] = wp.float64(1.0)
            return axis
        return wp.normalize(wide(pairs.normals[c]))

    @func
    def list_codes(pairs: Pairs, modes: wp.array(dtype=int), work: DelassusWork):
        # how many rows there are; more than there is room for are not listed
        count = int(0)
        for number in range(pairs.active_count[0]):
            rows = int(1)
            if modes[pairs.active[number]] == Mode.STICK:
                rows = 3
            for a in range(rows):
                if count < most:
                    work.codes[count] = 3 * number + a
                count += 1
        return count

    @func
    def find_column(
        pairs: Pairs,
        modes: wp.array(dtype=int),
        constraints: NodeConstraints,
        work: DelassusWork,
        code: int,
    ):
        # q = the column of the matrix for a row; p is used up
        for number in range(pairs.active_count[0]):
            work.p[number] = vec3d()
        work.p[code / 3] = row_axis(pairs, modes, code)
        apply(pairs, modes, constraints, work.p, work.nodal, work.q)

    @func
    def factorise(
        pairs: Pairs, modes: wp.array(dtype=int), constraints: NodeConstraints, work: DelassusWork
    ):
        # rank becomes the number of independent rows, or -1 where there are too many
        work.rank[0] = -1
        count = list_codes(pairs, modes, work)
        if count > most:
            return
        for s in range(count):
            code = work.codes[s]
            find_column(pairs, modes, constraints, work, code)
            work.pivots[s] = wp.dot(row_axis(pairs, modes, code), work.q[code / 3])
        largest = zero
        k = int(0)
        going = bool(True)
        while going and k < count:
            best = int(0)
            for s in range(count):
                if work.pivots[s] > work.pivots[best]:
                    best = s
            pivot = work.pivots[best]
            if k == 0:
                largest = pivot
            going = pivot > least * largest and pivot > zero
            if going:
                find_column(pairs, modes, constraints, work, work.codes[best])
                root = wp.sqrt(pivot)
                for s in range(count):
                    code = work.codes[s]
                    left = wp.dot(row_axis(pairs, modes, code), work.q[code / 3])
                    for j in range(k):
                        left -= work.lower[s * most + j] * work.lower[best * most + j]
                    left = left / root
                    work.lower[s * most + k] = left
                    work.pivots[s] = work.pivots[s] - left * left
                work.pivots[best] = -largest
                work.chosen[k] = best
                k += 1
        work.rank[0] = k

    @func
    def solve_factor(pairs: Pairs, modes: wp.array(dtype=int), work: DelassusWork):
        # y of N C S C^T N y = r on the independent rows, none on the others
        rank = work.rank[0]
        for number in range(pairs.active_count[0]):
            work.y[number] = vec3d()
        for k in range(rank):
            p = work.chosen[k]
            code = work.codes[p]
            left = wp.dot(row_axis(pairs, modes, code), work.r[code / 3])
            for j in range(k):
                left -= work.lower[p * most + j] * work.pivots[j]
            work.pivots[k] = left / work.lower[p * most + k]
        for back in range(rank):
            k = rank - 1 - back
            left = work.pivots[k]
            for j in range(k + 1, rank):
                left -= work.lower[work.chosen[j] * most + k] * work.pivots[j]
            work.pivots[k] = left / work.lower[work.chosen[k] * most + k]
        for k in range(rank):
            code = work.codes[work.chosen[k]]
            part = work.pivots[k] * row_axis(pairs, modes, code)
            work.y[code / 3] = work.y[code / 3] + part

    return SimpleNamespace(factorise=factorise, solve_factor=solve_factor)
