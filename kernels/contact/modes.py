"""Modes of a node or a pair in contact, and the passes that their rules change at."""

from enum import IntEnum


class Mode(IntEnum):
    """What a node or a pair does; `engine.snapshots` shows it as a `ContactMode`."""

    LIFT = 0
    """Free of contact."""
    STICK = 1
    """All components of the velocity are given."""
    SLIDE = 2
    """Slides on the smooth cone; on a polygon, without friction so far."""
    PLACE = 3
    """This mode and those above it slide on a polygon of friction: mode PLACE + p at its place p,
    corner p / 2 where p is even, the edge between two corners where it is odd."""


NEWTON_PASSES = 4
"""Active-set passes of a step in which nodes may begin to slide and Newton's linearisation is
used."""

LATE_PASSES = 6
"""Passes after which the smooth cone uses Newton's linearisation again: modes have settled."""

LAST_PASSES = 8
"""Passes after which, on a polygon, only what takes energy is tried: what sticks goes on sticking,
and friction that has not settled is a stiffness."""
