"""Modes of a node or a pair in contact, and the thresholds at which its mode or friction changes.

All laws of friction take them from here. "Bound" is the largest friction that the cone allows, the
coefficient times the normal impulse of the pass before.
"""

from enum import IntEnum


class Mode(IntEnum):
    """What a node or a pair does; the first three are those that the rest of the package sees."""

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

BEYOND = 1e-2
"""Part of the bound by which friction may exceed it before sliding begins."""

LATE_EXCESS = 0.5
"""Part of the bound by which friction must exceed it to begin to slide late in a step."""

MISSED = 5e-2
"""Part of the bound by which friction may miss Coulomb's law while the sliding speed changes."""

SLOW = 1e-3
"""Part of the bound that a pair's own block answers with a speed that counts as none."""

SHRUNK = 0.7
"""Part of the bound below which friction that was linearised as a stiffness has stopped a pair."""

SETTLED = 0.7
"""Part of its speed with which a velocity has kept its direction, or size, since the last pass, so
that friction may be linearised there by Newton's method, or enter as a force."""
