"""Muscles with an energy, whose stiffness the step's matrix takes (docs/method.md section 2).

Segment j stores ``S_j V_j / 2 max(0, f_j - a_j)^2``, V_j the volume that feels it and f_j the mean
over that volume of the fibre's stretch ``|F d_j|``. So a pair of a tet and a segment bears the
first Piola-Kirchhoff stress ``w T_j n d^T`` with T_j = S_j max(0, f_j - a_j), n = F d / |F d|,
which has neither a net force nor a net torque. Stretches below ``SHORT`` are rounded off to
``(|F d|^2 / SHORT + SHORT) / 2``, so that a collapsed tet has a force too.

The second derivative of that energy couples all tets around a segment. By Jensen's inequality
``w V0 (S n n^T + T / |F d| (I - n n^T))``, summed over the pairs and acting on the changes of F d,
bounds it from above, in the mesh's own pattern. Where a controller is still to choose, T is not
known and left out.

The part with T brakes every turn, as a step's straight path lengthens a fibre that turns. With the
conserving tangent (``unturned``) it acts on what changes F d beside the turn omega of its tet, the
one nearest to the tet's change of shape:

    dF d - omega x F d        omega = (tr(C) I - C)^-1 sum_i F e_i x dF e_i,  C = F F^T
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.elastic.tet_geometry import make_tets
from warp_softbody.kernels.precision import real

SUBJECT = "implicit_muscles"
SHORT = 0.1
"""Stretch of a fibre within a tet below which its length is rounded off."""

SLOW = 0.1
"""rad, of a tet's turn in a step, up to which nothing of it is braked where `SLOW_ONES` are told
apart; from twice as much on all of it, as in between. The straight path of a faster turn lengthens
fibres by what would be gained in energy."""

SLOW_ONES = wp.constant(2)
"""Value of ``unturned`` for steps of one Newton iteration; 1 where further ones see what a turn has
done, 0 where every turn is braked."""


@cache
def make_implicit_muscles(precision: str) -> SimpleNamespace:
    """Structs ``Fibers`` and ``FiberState``; kernels from positions to stiffness and forces."""
    types = real(precision)
    scalar, vec3, mat33 = types.scalar, types.vec3, types.mat33
    kernel, func = types.kernel(SUBJECT), types.func(SUBJECT)
    plain = types.kernel(SUBJECT, "plain")
    tet = make_tets(precision, SUBJECT)
    deformation, by_corner = tet.deformation, tet.by_corner
    short = wp.constant(scalar(SHORT))
    slow = wp.constant(scalar(SLOW))
    rounding = wp.constant(scalar({"float32": 2.0**-20, "float64": 2.0**-49}[precision]))

    @wp.struct
    class Fibers:
        """Pairs of a tet and a segment, by tet (q,), and segments (s,); all of it constant.

        ``volume`` is w V0, ``share`` its part of the segment's; ``strength`` is S, Pa.
        """

        tets: wp.array(dtype=wp.vec4i)
        rest_inverse: wp.array(dtype=mat33)
        pair_start: wp.array(dtype=int)
        pair_segment: wp.array(dtype=int)
        volume: wp.array(dtype=scalar)
        share: wp.array(dtype=scalar)
        directions: wp.array(dtype=vec3)
        strength: wp.array(dtype=scalar)

    @wp.struct
    class FiberState:
        """F of tets; S and T of segments in K; of pairs n, stretch, 1 / |F d|, and F d's rate.

        ``speeds`` are what of that rate is along n. ``turns`` are the tets' omega.
        """

        deformations: wp.array(dtype=mat33)
        turns: wp.array(dtype=vec3)
        directions: wp.array(dtype=vec3)
        stretches: wp.array(dtype=scalar)
        rates: wp.array(dtype=vec3)
        speeds: wp.array(dtype=scalar)
        reciprocals: wp.array(dtype=scalar)
        moduli: wp.array(dtype=scalar)
        tensions: wp.array(dtype=scalar)

    @func
    def turning(F: mat33):
        # what takes sum F e_i x dF e_i to omega; bounded where a tet has become a line
        C = F * wp.transpose(F)
        size = wp.trace(C) * (scalar(1.0) + rounding) + rounding
        return wp.inverse(size * wp.identity(n=3, dtype=scalar) - C)

    @func
    def moment(A: mat33, B: mat33):
        # sum A e_i x B e_i, twice the axial vector of B A^T
        P = B * wp.transpose(A)
        return vec3(P[2, 1] - P[1, 2], P[0, 2] - P[2, 0], P[1, 0] - P[0, 1])

    @plain
    def stretch_fibers(
        # model
        first: int,
        fibers: Fibers,
        # in
        positions: wp.array(dtype=vec3),
        velocities: wp.array(dtype=vec3),
        # out
        state: FiberState,
    ):
        t = first + wp.tid()
        F = deformation(fibers.tets[t], fibers.rest_inverse[t], positions)
        rate = deformation(fibers.tets[t], fibers.rest_inverse[t], velocities)
        state.deformations[t] = F
        state.turns[t] = turning(F) * moment(F, rate)
        for k in range(fibers.pair_start[t], fibers.pair_start[t + 1]):
            d = fibers.directions[fibers.pair_segment[k]]
            along = F * d
            length = wp.length(along)
            bound = wp.max(length, short)
            stretch = length
            if length < short:
                stretch = scalar(0.5) * (length * length / short + short)
            state.directions[k] = along / bound
            state.stretches[k] = stretch
            state.rates[k] = rate * d
            state.speeds[k] = wp.dot(along / bound, rate * d)
            state.reciprocals[k] = scalar(1.0) / bound

    @kernel
    def mean_stretches(
        # model
        first: int,
        fibers: Fibers,
        segment_start: wp.array(dtype=int),
        segment_pair: wp.array(dtype=int),
        rest_lengths: wp.array(dtype=scalar),
        step_factors: wp.array(dtype=scalar),
        # in
        limits: wp.array(dtype=scalar),
        # out
        state: FiberState,
        lengths: wp.array(dtype=scalar),
        reaches: wp.array(dtype=scalar),
    ):
        # a slack segment is stiff too where it is about to pull, so that its step does not find it
        # without
        j = first + wp.tid()
        stretch = scalar(0.0)
        rate = scalar(0.0)
        for i in range(segment_start[j], segment_start[j + 1]):
            k = segment_pair[i]
            stretch += fibers.share[k] * state.stretches[k]
            rate += fibers.share[k] * state.speeds[k]
        lengths[j] = rest_lengths[j] * stretch
        soon = stretch + step_factors[0] * wp.max(rate, scalar(0.0))
        reaches[j] = rest_lengths[j] * soon
        modulus = scalar(0.0)
        if rest_lengths[j] * soon >= limits[j]:
            modulus = fibers.strength[j]
        state.moduli[j] = modulus
        pulled = scalar(0.0)
        if limits[j] > scalar(0.0):
            pulled = wp.max(stretch - limits[j] / rest_lengths[j], scalar(0.0))
        state.tensions[j] = modulus * pulled

    @func
    def beside_turns(wa: mat33, sa: mat33, wb: mat33, sb: mat33, M: mat33):
        # of corners a and b: w take their changes to omega, s to the moment sum c F d x dF d
        return wp.transpose(wa) * (M * wb - sb) + sa * wb

    @plain
    def stiffen_tets(
        # model
        first: int,
        unturned: int,
        fibers: Fibers,
        step_factors: wp.array(dtype=scalar),
        # in
        state: FiberState,
        # out
        blocks: wp.array(dtype=mat33),
    ):
        # dt^2 w V0 (S n n^T + T / |F d| (I - n n^T)) (d . g_a) (d . g_b), of the corners (0, 1),
        # (0, 2), (0, 3), (1, 2), (1, 3) and (2, 3); what T does to turns is taken out below
        t = first + wp.tid()
        B = fibers.rest_inverse[t]
        dt = step_factors[0]
        identity = wp.identity(n=3, dtype=scalar)
        b01 = mat33()
        b02 = mat33()
        b03 = mat33()
        b12 = mat33()
        b13 = mat33()
        b23 = mat33()
        spread = mat33()
        for k in range(fibers.pair_start[t], fibers.pair_start[t + 1]):
            j = fibers.pair_segment[k]
            if state.moduli[j] > scalar(0.0):
                d = fibers.directions[j]
                n = state.directions[k]
                p = B * d
                p0 = -(p[0] + p[1] + p[2])
                across = state.tensions[j] * state.reciprocals[k]
                outer = (state.moduli[j] - across) * wp.outer(n, n) + across * identity
                outer = (dt * dt * fibers.volume[k]) * outer
                spread += (dt * dt * fibers.volume[k] * across) * wp.outer(d, d)
                b01 += (p0 * p[0]) * outer
                b02 += (p0 * p[1]) * outer
                b03 += (p0 * p[2]) * outer
                b12 += (p[0] * p[1]) * outer
                b13 += (p[0] * p[2]) * outer
                b23 += (p[1] * p[2]) * outer
        if unturned == SLOW_ONES:
            turn = dt * wp.length(state.turns[t])
            spread = wp.clamp(scalar(2.0) - turn / slow, scalar(0.0), scalar(1.0)) * spread
        if unturned != 0 and wp.trace(spread) > scalar(0.0):
            F = state.deformations[t]
            own = turning(F)
            S = F * spread
            Y = S * wp.transpose(F)
            M = wp.trace(Y) * identity - Y
            s1 = wp.skew(S * B[0])
            s2 = wp.skew(S * B[1])
            s3 = wp.skew(S * B[2])
            w1 = own * wp.skew(F * B[0])
            w2 = own * wp.skew(F * B[1])
            w3 = own * wp.skew(F * B[2])
            s0 = -(s1 + s2 + s3)
            w0 = -(w1 + w2 + w3)
            b01 += beside_turns(w0, s0, w1, s1, M)
            b02 += beside_turns(w0, s0, w2, s2, M)
            b03 += beside_turns(w0, s0, w3, s3, M)
            b12 += beside_turns(w1, s1, w2, s2, M)
            b13 += beside_turns(w1, s1, w3, s3, M)
            b23 += beside_turns(w2, s2, w3, s3, M)
        blocks[6 * t] = b01
        blocks[6 * t + 1] = b02
        blocks[6 * t + 2] = b03
        blocks[6 * t + 3] = b12
        blocks[6 * t + 4] = b13
        blocks[6 * t + 5] = b23

    @func
    def place_of(a: int, b: int):
        # of two corners of a tet, given by their slots, in the order of ``stiffen_tets``
        t = a / 4
        low = wp.min(a, b) - 4 * t
        place = low + wp.max(a, b) - 4 * t
        if low == 0:
            place -= 1
        return 6 * t + place

    @plain
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
        edge = first + wp.tid()
        total = mat33()
        for k in range(edge_start[edge], edge_start[edge + 1]):
            corners = edge_corners[k]
            block = blocks[place_of(corners[0], corners[1])]
            if corners[0] > corners[1]:
                block = wp.transpose(block)
            total += block
        slots = edge_slots[edge]
        values[slots[0]] = values[slots[0]] + total
        values[slots[1]] = values[slots[1]] + wp.transpose(total)

    @kernel
    def first_tensions(
        # model
        rest_lengths: wp.array(dtype=scalar),
        # in
        limits: wp.array(dtype=scalar),
        lengths: wp.array(dtype=scalar),
        reaches: wp.array(dtype=scalar),
        state: FiberState,
        # out
        tensions: wp.array(dtype=scalar),
    ):
        # the matrix adds what the segment's lengthening in the step does; so one that gives way at
        # the rate of the step's beginning ends it without tension
        j = wp.tid()
        begin = lengths[j] - wp.min(limits[j], reaches[j])
        tensions[j] = state.moduli[j] * begin / rest_lengths[j]

    @kernel
    def pull_tets(
        # model
        unturned: int,
        fibers: Fibers,
        given_back: wp.array(dtype=scalar),
        again: int,
        # in
        tensions: wp.array(dtype=scalar),
        state: FiberState,
        # out
        forces: wp.array(dtype=vec3),
    ):
        # ``again``: of a further Newton iteration, whose right-hand side gives back only part of
        # what the matrix takes from the last iterate of the velocities; the rest is tension here
        t = wp.tid()
        stress = mat33()
        F = state.deformations[t]
        spread = mat33()
        moved = vec3()
        for k in range(fibers.pair_start[t], fibers.pair_start[t + 1]):
            j = fibers.pair_segment[k]
            n = state.directions[k]
            pull = tensions[j] * n
            if again != 0:
                across = state.tensions[j] * state.reciprocals[k]
                along = (state.moduli[j] - across) * wp.dot(n, state.rates[k])
                pull -= given_back[t] * (along * n + across * state.rates[k])
                d = fibers.directions[j]
                size = fibers.volume[k] * across
                spread += size * wp.outer(d, d)
                moved += size * wp.cross(F * d, state.rates[k])
            stress += fibers.volume[k] * wp.outer(fibers.directions[j], pull)
        if unturned != 0 and wp.trace(spread) > scalar(0.0):
            # the matrix's part that leaves turns alone
            S = F * spread
            Y = S * wp.transpose(F)
            omega = state.turns[t]
            z = turning(F) * (wp.trace(Y) * omega - Y * omega - moved)
            rest = wp.skew(z) * F - wp.skew(omega) * S
            stress -= given_back[t] * wp.transpose(rest)
        by_corner(4 * t, -(fibers.rest_inverse[t] * stress), forces)

    @plain
    def weigh_pairs(
        # model
        pair_weight: wp.array(dtype=scalar),
        # in
        reciprocals: wp.array(dtype=scalar),
        # out
        weights: wp.array(dtype=scalar),
    ):
        # w / |F d|, with which the response of d^T F^T (.) d is that of the stretch
        k = wp.tid()
        weights[k] = pair_weight[k] * reciprocals[k]

    @plain
    def by_segment(
        # model
        segment_pair: wp.array(dtype=int),
        # in
        weights: wp.array(dtype=scalar),
        # out
        sorted_weights: wp.array(dtype=scalar),
    ):
        i = wp.tid()
        sorted_weights[i] = weights[segment_pair[i]]

    @kernel
    def rest_rows(
        # model
        rest_inverse: wp.array(dtype=mat33),
        rest_volume: wp.array(dtype=scalar),
        # out
        rows: wp.array(dtype=mat33),
    ):
        # rows: V0 g_a, what a fibre stress of the rest frame acts on
        t = wp.tid()
        rows[t] = rest_volume[t] * rest_inverse[t]

    return SimpleNamespace(
        Fibers=Fibers,
        FiberState=FiberState,
        stretch_fibers=stretch_fibers,
        mean_stretches=mean_stretches,
        stiffen_tets=stiffen_tets,
        stiffen_edges=stiffen_edges,
        first_tensions=first_tensions,
        pull_tets=pull_tets,
        weigh_pairs=weigh_pairs,
        by_segment=by_segment,
        rest_rows=rest_rows,
    )
