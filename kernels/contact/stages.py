"""Stages of the search for contact modes, and the ending of a step that does not settle.

1. ``ALL``: every node chooses its mode anew in every pass. Most steps settle here.
2. ``NORMALS`` and ``FRICTION`` in turn: while friction is a frozen stiffness, the problem in the
   normal directions is convex; once it has settled, friction is chosen anew for one pass. This is
   the fixed point of Tresca problems (Haslinger, Hlavacek and Necas 1996).
3. ``LET_GO``: nodes that would pull are let go, none begins to touch, and friction only grows less.
   It is a positive semi-definite stiffness, inside the cone at the velocity of the pass before. So
   the step ends without an impulse that pulls, leaves its cone or drives, whatever was left
   unsettled; a node may sink by the way of a step.
"""

from enum import IntEnum
from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.contact.modes import MISSED, NEWTON_PASSES, Mode
from warp_softbody.kernels.contact.structs import make_contact_structs
from warp_softbody.kernels.linear.codes import Counter
from warp_softbody.kernels.precision import real


class SearchStage(IntEnum):
    """What the passes of a step may change."""

    ALL = 0
    """Every mode."""
    NORMALS = 1
    """Who is pressed; friction is frozen."""
    FRICTION = 2
    """Friction, for one pass."""
    LET_GO = 3
    """Only less contact and less friction."""


class NodeChange(IntEnum):
    """What a pass changed of a node."""

    NONE = 0
    FRICTION = 1
    PRESSED = 2
    """It begins or ends to be pressed."""


ALL_PASSES = 12
"""Passes of the first stage."""

LET_GO_PASSES = 20
"""Passes of the last stage, beyond those that modes may be sought in."""

PICARD_PASSES = NEWTON_PASSES
"""What the laws of friction are told in the second stage: their rules of this pass."""


@cache
def make_stages(precision: str, subject: str) -> SimpleNamespace:
    """Functions ``stage_of``, ``braked``, ``next_stage`` and ``extend_for_pairs``."""
    types = real(precision)
    scalar, vec3, mat33 = types.scalar, types.vec3, types.mat33
    func = types.func(subject)
    Tolerances = make_contact_structs(precision).Tolerances
    missed = wp.constant(scalar(MISSED))
    all_passes, let_go_passes = wp.constant(ALL_PASSES), wp.constant(LET_GO_PASSES)

    @func
    def stage_at(passes: int, friction_next: int, max_passes: int):
        if passes >= max_passes:
            return SearchStage.LET_GO
        if passes < all_passes:
            return SearchStage.ALL
        if friction_next != 0:
            return SearchStage.FRICTION
        return SearchStage.NORMALS

    @func
    def stage_of(counters: wp.array(dtype=int), max_passes: int):
        return stage_at(counters[Counter.PASSES], counters[Counter.FRICTION_NEXT], max_passes)

    @func
    def braked(
        mode: int,
        n: vec3,
        friction: vec3,
        sliding: vec3,
        bound: scalar,
        weight: scalar,
        first: bool,
        known: mat33,
        tolerances: Tolerances,
    ):
        # next mode, whether the cone is left, and the stiffness of friction -bound v / |v|
        speed = wp.max(wp.length(sliding), tolerances.sliding_speed)
        size = bound / speed
        unsettled = int(0)
        if mode == Mode.STICK:
            if wp.length(friction) <= bound + tolerances.impulse:
                return Mode.STICK, unsettled, mat33()
            # the speed at which its own block answers what is beyond the cone
            size = bound * weight / (wp.length(friction) - bound)
        elif not first:
            last = scalar(0.5) * wp.trace(known)
            if size < (scalar(1.0) - missed) * last:
                unsettled = 1
            size = wp.min(size, last)
        across = wp.identity(n=3, dtype=scalar) - wp.outer(n, n)
        if first:
            unsettled = 1
        return Mode.SLIDE, unsettled, size * across

    @func
    def next_stage(
        total: int, normals_changed: int, max_passes: int, counters: wp.array(dtype=int)
    ):
        # in the first stage modes are sought with loose solves; once they settle, one solve to the
        # tolerance must confirm them
        stage = stage_of(counters, max_passes)
        passes = counters[Counter.PASSES] + 1
        counters[Counter.PASSES] = passes
        # what ends in the last stage is safe, but has not settled
        counters[Counter.CHANGED] = wp.where(stage == SearchStage.LET_GO, wp.max(total, 1), total)
        unsettled = total > 0 or counters[Counter.LOOSE] != 0
        friction_next = int(0)
        if stage == SearchStage.NORMALS and normals_changed == 0:
            friction_next = 1
            unsettled = True
        if stage == SearchStage.ALL and passes == all_passes:
            friction_next = 1
        counters[Counter.FRICTION_NEXT] = friction_next
        within = passes < max_passes + let_go_passes
        counters[Counter.AGAIN] = wp.where(unsettled and within, 1, 0)
        later = stage_at(passes, friction_next, max_passes)
        counters[Counter.LOOSE] = wp.where(total > 0 and later == SearchStage.ALL, 1, 0)

    @func
    def extend_for_pairs(unsettled: int, max_passes: int, counters: wp.array(dtype=int)):
        # another pass for pairs that have not settled, on top of ``next_stage``; what they have not
        # found in the first stage they do not find later
        if unsettled > 0:
            limit = wp.min(max_passes, all_passes)
            if counters[Counter.PASSES] < limit:
                counters[Counter.AGAIN] = 1
            counters[Counter.LOOSE] = wp.where(counters[Counter.PASSES] < limit - 1, 1, 0)

    return SimpleNamespace(
        stage_of=stage_of, braked=braked, next_stage=next_stage, extend_for_pairs=extend_for_pairs
    )
