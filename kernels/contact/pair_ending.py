"""How a step ends whose pairs did not settle: safe, though not exact.

Pairs that pressed keep their normal velocity given, and their friction, cut to its cone, becomes a
given force. Round by round, pairs with a tensile impulse are released, friction beyond its cone is
cut again, and friction that adds energy is dropped. Nothing is taken up again, so the rounds come
to an end, and no energy is gained but by what pushes bodies apart that are sunk in each other.

Should the rounds not suffice, or the solve lose itself among rows that contradict, the impulses as
they are, cut to the laws, act as given forces. Where they would add energy at the velocities that
follow, all of them are scaled down until they do not: with x0 the velocities without them and x1
with them, the power of a part a of them is ``a (1 - a) f . C x0 + a^2 f . C x1``. No velocities are
believed that have more energy than the step could give them.
"""

from enum import IntEnum
from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.contact.modes import Mode
from warp_softbody.kernels.contact.pair_active_set import LEAST_SHARE
from warp_softbody.kernels.contact.pair_constraints import SUBJECT, make_pair_constraints
from warp_softbody.kernels.contact.structs import make_pair_structs
from warp_softbody.kernels.precision import real


class Round(IntEnum):
    """Slots of what is noted of the rounds."""

    AGAIN = 0
    """Whether another round is due."""
    COUNT = 1
    """How many there were."""
    TOO_FEW = 2
    """Whether they did not suffice."""
    LOST = 3
    """Whether the solve lost itself."""


MOST_ROUNDS = 8
"""After which all impulses are scaled instead."""

BEYOND = 1.1
"""Times the energy that velocities can have, beyond which they are not believed."""

CUT = 1e-3
"""Part of the bound by which friction may exceed it before it is cut again."""


@cache
def make_pair_ending(precision: str) -> SimpleNamespace:
    """Kernels ``begin_rounds``, ``prune``; ``clip``, ``add_impulses`` and ``end``."""
    types = real(precision)
    scalar, vec3 = types.scalar, types.vec3
    kernel, func = types.kernel(SUBJECT), types.func(SUBJECT)
    rows = make_pair_constraints(precision)
    relative, wide, narrow = rows.relative, rows.wide, rows.narrow
    Pairs = make_pair_structs(precision).Pairs
    zero, one = wp.constant(wp.float64(0.0)), wp.constant(wp.float64(1.0))
    least_share, cut = wp.constant(scalar(LEAST_SHARE)), wp.constant(scalar(CUT))
    beyond, largest = wp.constant(wp.float64(BEYOND)), wp.constant(scalar(1e15))
    most_rounds = wp.constant(MOST_ROUNDS)

    @wp.struct
    class NodeMasses:
        """Masses of the nodes, kg, which of them are held, and the speed of recovery, m/s."""

        mass: wp.array(dtype=scalar)
        fixed: wp.array(dtype=int)
        recovery_speed: scalar

    @func
    def split(pairs: Pairs, c: int, friction_coefficient: scalar, impulse: vec3):
        # what the laws allow of an impulse: its normal part, and friction within the cone
        n = pairs.normals[c]
        along = wp.dot(n, impulse)
        normal = wp.max(along, scalar(0.0))
        friction = impulse - along * n
        bound = pairs.friction_factor[c] * friction_coefficient * normal
        size = wp.length(friction)
        if size > bound:
            friction = (bound / size) * friction
        return normal, friction

    @kernel
    def begin_rounds(
        # in
        pairs: Pairs,
        friction_coefficient: scalar,
        impulses: wp.array(dtype=vec3),
        # out
        modes: wp.array(dtype=int),
        frictions: wp.array(dtype=vec3),
        rounds: wp.array(dtype=int),
    ):
        for number in range(pairs.found_count[0]):
            c = pairs.found[number]
            normal, friction = split(pairs, c, friction_coefficient, impulses[c])
            modes[c] = wp.where(normal > scalar(0.0), Mode.SLIDE, Mode.LIFT)
            frictions[c] = friction
        rounds[Round.AGAIN] = 1
        rounds[Round.COUNT] = 0
        rounds[Round.TOO_FEW] = 0
        rounds[Round.LOST] = 0

    @func
    def lost(
        nodes: NodeMasses,
        before: wp.array(dtype=vec3),
        right: wp.array(dtype=vec3),
        x: wp.array(dtype=vec3),
    ):
        # whether x has more energy than any contact could leave: as M~ >= M, x M x <= b M^-1 b
        # without contact, b the known momentum, and contact takes away, but for what pushes sunken
        # bodies apart. Then the solve has lost itself among rows that contradict. A handle at the
        # speed u gives energy; seen from it contact takes: |x| <= |known| + 2 u in the norm of the
        # masses, and so x M x <= 2 known M known + 8 M u^2
        bound, now = wp.float64(0.0), wp.float64(0.0)
        free, given = wp.float64(0.0), wp.float64(0.0)
        speed = wp.float64(nodes.recovery_speed)
        for i in range(x.shape[0]):
            m = wp.float64(nodes.mass[i])
            known = m * wide(before[i]) + wide(right[i])
            bound += wp.length_sq(known) / m + m * speed * speed
            if nodes.fixed[i] != 0:
                given = wp.max(given, wp.length_sq(wide(x[i])))
            else:
                free += m
                now += m * wp.length_sq(wide(x[i]))
        if given > wp.float64(0.0):
            bound = wp.float64(2.0) * bound + wp.float64(8.0) * free * given
        return not (now <= beyond * bound)

    @kernel
    def prune(
        # in
        pairs: Pairs,
        friction_coefficient: scalar,
        largest_impulse: wp.array(dtype=scalar),
        impulses: wp.array(dtype=vec3),
        nodes: NodeMasses,
        before: wp.array(dtype=vec3),
        right: wp.array(dtype=vec3),
        x: wp.array(dtype=vec3),
        # in and out
        modes: wp.array(dtype=int),
        frictions: wp.array(dtype=vec3),
        rounds: wp.array(dtype=int),
    ):
        changes = int(0)
        none = least_share * largest_impulse[0]
        for row in range(pairs.active_count[0]):
            c = pairs.active[row]
            n = pairs.normals[c]
            along = wp.dot(n, impulses[c])
            if along < -none:
                modes[c] = Mode.LIFT
                frictions[c] = vec3()
                changes += 1
            else:
                size = wp.length(frictions[c])
                bound = pairs.friction_factor[c] * friction_coefficient * wp.max(along, scalar(0.0))
                if size > (scalar(1.0) + cut) * bound + none:
                    frictions[c] = (bound / size) * frictions[c]
                    changes += 1
                u = narrow(relative(pairs, c, x))
                drives = wp.dot(frictions[c], u - wp.dot(n, u) * n)
                if drives > cut * wp.length(frictions[c]) * wp.length(u):
                    frictions[c] = vec3()
                    changes += 1
        rounds[Round.COUNT] = rounds[Round.COUNT] + 1
        rounds[Round.AGAIN] = 0
        if changes > 0:
            if rounds[Round.COUNT] < most_rounds:
                rounds[Round.AGAIN] = 1
            else:
                rounds[Round.TOO_FEW] = 1
        if lost(nodes, before, right, x):
            rounds[Round.AGAIN] = 0
            rounds[Round.TOO_FEW] = 1
            rounds[Round.LOST] = 1

    @kernel
    def clip(
        # in
        pairs: Pairs,
        friction_coefficient: scalar,
        # in and out
        impulses: wp.array(dtype=vec3),
    ):
        for number in range(pairs.found_count[0]):
            c = pairs.found[number]
            normal, friction = split(pairs, c, friction_coefficient, impulses[c])
            impulses[c] = normal * pairs.normals[c] + friction
            if not (wp.length(impulses[c]) < largest):
                impulses[c] = vec3()

    @kernel
    def add_impulses(
        # in
        pairs: Pairs,
        part: scalar,
        rounds: wp.array(dtype=int),
        impulses: wp.array(dtype=vec3),
        right: wp.array(dtype=vec3),
        ground_frictions: wp.array(dtype=vec3),
        # out
        right_with_slip: wp.array(dtype=vec3),
    ):
        # where the solve lost itself, so did the ground's frictions
        for i in range(right.shape[0]):
            known = right[i]
            if rounds[Round.LOST] == 0:
                known += ground_frictions[i]
            right_with_slip[i] = known
        for number in range(pairs.found_count[0]):
            c = pairs.found[number]
            k, w = pairs.nodes[c], pairs.weights[c]
            for a in range(4):
                right_with_slip[k[a]] = right_with_slip[k[a]] + (part * w[a]) * impulses[c]

    @func
    def power(pairs: Pairs, impulses: wp.array(dtype=vec3), x: wp.array(dtype=vec3)):
        # of the impulses at given velocities, beyond what pushes sunken bodies apart
        total = wp.float64(0.0)
        for number in range(pairs.found_count[0]):
            c = pairs.found[number]
            impulse = wide(impulses[c])
            pushed = wp.float64(wp.max(pairs.normal_velocity[c], scalar(0.0)))
            pushed *= wp.dot(wide(pairs.normals[c]), impulse)
            total += wp.dot(impulse, relative(pairs, c, x)) - pushed
        return total

    @kernel
    def end(
        # in
        pairs: Pairs,
        without: wp.array(dtype=vec3),
        nodes: NodeMasses,
        before: wp.array(dtype=vec3),
        right: wp.array(dtype=vec3),
        # in and out
        impulses: wp.array(dtype=vec3),
        x: wp.array(dtype=vec3),
    ):
        first, last = power(pairs, impulses, without), power(pairs, impulses, x)
        part = one
        if last > zero:
            part = wp.clamp(-first / (last - first), zero, one)
        if lost(nodes, before, right, x):
            part = zero
        for number in range(pairs.found_count[0]):
            c = pairs.found[number]
            impulses[c] = narrow(part * wide(impulses[c]))
        for i in range(x.shape[0]):
            kept = (one - part) * wide(without[i])
            if part > zero:
                kept += part * wide(x[i])
            x[i] = narrow(kept)

    return SimpleNamespace(
        NodeMasses=NodeMasses,
        begin_rounds=begin_rounds,
        prune=prune,
        clip=clip,
        add_impulses=add_impulses,
        end=end,
    )
