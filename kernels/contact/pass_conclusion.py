"""What ends a pass of the active set: its changes are counted, and another pass is due or not.

The same count serves the contacts with the ground and the pairs; they differ in what follows from
it, which ``stages.py`` decides.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.contact.modes import Mode
from warp_softbody.kernels.contact.stages import NodeChange, make_stages
from warp_softbody.kernels.contact.structs import make_contact_structs, make_pair_structs
from warp_softbody.kernels.linear.codes import Counter
from warp_softbody.kernels.precision import real

SUBJECT = "pass_conclusion"


@cache
def make_pass_conclusion(precision: str) -> SimpleNamespace:
    """Kernels ``conclude_ground`` and, on top of it, ``conclude_pairs``."""
    types = real(precision)
    scalar = types.scalar
    kernel, func = types.kernel(SUBJECT), types.func(SUBJECT)
    vec2 = wp.types.vector(length=2, dtype=scalar)
    PassRecord = make_contact_structs(precision).PassRecord
    Pairs = make_pair_structs(precision).Pairs
    stages = make_stages(precision, SUBJECT)
    next_stage, extend_for_pairs = stages.next_stage, stages.extend_for_pairs

    @wp.struct
    class Tally:
        """Counts over contacts, and the one that missed its laws most."""

        changed: int
        pressed: int
        touching: int
        largest: vec2
        worst: int
        most: scalar

    @func
    def counted(tally: Tally, c: int, mode: int, record: PassRecord):
        # the tally with a contact more
        violation = record.violations[c]
        if record.changed[c] != NodeChange.NONE:
            tally.changed += 1
        if record.changed[c] == NodeChange.PRESSED:
            tally.pressed += 1
        if mode != Mode.LIFT:
            tally.touching += 1
        tally.largest = wp.max(tally.largest, violation)
        size = wp.max(violation[0], violation[1])
        if size > tally.most:
            tally.most = size
            tally.worst = c
        return tally

    @kernel
    def conclude_ground(
        # model
        max_passes: int,
        # in
        modes: wp.array(dtype=int),
        record: PassRecord,
        # in and out
        counters: wp.array(dtype=int),
        # out
        largest_violations: wp.array(dtype=vec2),
        worst: wp.array(dtype=int),
    ):
        tally = Tally()
        tally.worst = -1
        tally.most = scalar(-1.0)
        for c in range(modes.shape[0]):
            tally = counted(tally, c, modes[c], record)
        counters[Counter.TOUCHING] = tally.touching
        largest_violations[0] = tally.largest
        worst[0] = tally.worst
        next_stage(tally.changed, tally.pressed, max_passes, counters)

    @types.kernel(SUBJECT, "pairs")
    def conclude_pairs(
        # model
        max_passes: int,
        # in
        pairs: Pairs,
        modes: wp.array(dtype=int),
        record: PassRecord,
        # in and out
        counters: wp.array(dtype=int),
        largest_violations: wp.array(dtype=vec2),
        # out
        worst: wp.array(dtype=int),
        unsettled: wp.array(dtype=int),
    ):
        # counters and largest violations hold what ``conclude_ground`` made of the ground's
        tally = Tally()
        tally.worst = -1
        tally.largest = largest_violations[0]
        for number in range(pairs.found_count[0]):
            c = pairs.found[number]
            tally = counted(tally, c, modes[c], record)
        counters[Counter.TOUCHING] = counters[Counter.TOUCHING] + tally.touching
        counters[Counter.CHANGED] = counters[Counter.CHANGED] + tally.changed
        largest_violations[0] = tally.largest
        worst[0] = tally.worst
        unsettled[0] = tally.changed
        extend_for_pairs(tally.changed, max_passes, counters)

    return SimpleNamespace(conclude_ground=conclude_ground, conclude_pairs=conclude_pairs)
