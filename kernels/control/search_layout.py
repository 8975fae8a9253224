"""The arrays of the native search: their names, shapes and order, shared with who calls it."""

from __future__ import annotations

from collections.abc import Callable
from enum import IntEnum
from typing import NamedTuple


class SearchSizes(NamedTuple):
    """What the shapes of all arrays follow from, named as in the native code."""

    nu: int
    """Controls."""
    K: int
    """Contacts."""
    m: int
    """Tangent directions."""
    q: int
    """Rows of the squares."""
    M: int
    """Modes of a contact."""
    r: int
    """Rows of a mode's inequalities."""
    s: int
    """Rays of a mode."""
    most_visits: int
    """Choices of modes that there is room for."""

    @property
    def c(self) -> int:
        """Numbers of all forces."""
        return 3 * self.K

    @property
    def w(self) -> int:
        """Columns of an affine map of the controls."""
        return 1 + self.nu

    @property
    def wide(self) -> int:
        """Most rows of the system of an active set."""
        return self.q + min(self.K * self.r, self.nu) + 1


class SearchSetting(IntEnum):
    """Whole numbers that are handed in, after those of ``SearchSizes``."""

    HAS_START = len(SearchSizes._fields)
    MOST_QPS = HAS_START + 1
    KICKS = HAS_START + 2
    PATIENCE = HAS_START + 3
    KICK_HELD = HAS_START + 4
    ASSEMBLES = HAS_START + 5
    """Whether the problem is made out of a step's maps first."""
    OTHERS = HAS_START + 6


class SearchFinding(IntEnum):
    """Whole numbers that come back."""

    STATUS = 0
    QPS = 1
    BEST = 2
    STATIONARY = 3
    COMPLETE = 4
    NEXT = 5
    """How many minima came next to the best one."""


class SearchOutcome(IntEnum):
    """Whether there is a result."""

    FOUND = 0
    LEFT = 1
    """To the NumPy form."""


MOST_OTHERS = 3
"""Minima beside the best one that a solve begins from, and that it hands on."""

Shape = Callable[[SearchSizes], tuple[int, ...]]

NUMBERS: dict[str, Shape] = {
    # of the problem, in its units
    "gradient": lambda a: (a.nu + a.c,),
    "lower": lambda a: (a.nu,),
    "upper": lambda a: (a.nu,),
    "offset": lambda a: (a.c,),
    "by_controls": lambda a: (a.c, a.nu),
    "by_forces": lambda a: (a.c, a.c),
    "squares": lambda a: (a.q, a.nu + a.c),
    "diagonal": lambda a: (a.nu,),
    "friction": lambda a: (a.K,),
    "factors": lambda a: (a.K, a.m),
    "directions": lambda a: (a.m, 2),
    "scalars": lambda a: (2,),
    # of the step that the problem is made for
    "muscle_map": lambda a: (a.q + a.c, a.nu),
    "compliance": lambda a: (a.q + a.c, a.q + a.c),
    "step_velocity": lambda a: (a.q + a.c,),
    "lengths": lambda a: (a.nu,),
    "reaches": lambda a: (a.nu,),
    "rest_lengths": lambda a: (a.nu,),
    "activations": lambda a: (a.nu,),
    "targets": lambda a: (a.q,),
    "goal_weights": lambda a: (a.q,),
    "gaps": lambda a: (a.K,),
    "costs": lambda a: (2,),
    # of the modes; kept while friction and directions stay as they are
    "radius": lambda a: (a.K, a.m),
    "known_directions": lambda a: (a.m, 2),
    "basis": lambda a: (a.K, a.M, 3, 3),
    "constraints": lambda a: (a.K, a.M, 3, 3),
    "inequalities": lambda a: (a.K, a.M, a.r, 6),
    "halfspaces": lambda a: (a.K, a.M, a.r + 6, 6),
    "rays": lambda a: (a.K, a.M, a.s, 6),
    # of the result
    "controls": lambda a: (a.nu,),
    "impulses": lambda a: (a.K, 3),
    "speeds": lambda a: (a.K, 3),
    "shares": lambda a: (a.K, a.m + 2),
    "weighed_contacts": lambda a: (a.K, 6),
    "rest": lambda a: (a.nu,),
    "results": lambda a: (7,),
    # the problem in units of its own
    "control_scale": lambda a: (a.nu,),
    "low": lambda a: (a.nu,),
    "high": lambda a: (a.nu,),
    "curve": lambda a: (a.nu,),
    "inverse": lambda a: (a.nu,),
    "slope": lambda a: (a.nu + a.c,),
    "factor": lambda a: (a.q, a.nu + a.c),
    "free_velocity": lambda a: (a.c, a.w),
    "delassus": lambda a: (a.c, a.c),
    # of a choice of modes
    "system": lambda a: (a.c, a.c),
    "amplitudes": lambda a: (a.c, a.w),
    "span": lambda a: (2 * a.c, a.c),
    "forces": lambda a: (a.c, a.w),
    "velocities": lambda a: (a.c, a.w),
    "outputs": lambda a: (a.q, a.w),
    "rows": lambda a: (a.K * a.r, a.w),
    "linear": lambda a: (a.nu,),
    # of its QP
    "x": lambda a: (a.nu,),
    "force": lambda a: (a.nu,),
    "way": lambda a: (a.nu,),
    "bound_weight": lambda a: (a.nu,),
    "bound_change": lambda a: (a.nu,),
    "weights": lambda a: (a.wide,),
    "change": lambda a: (a.wide,),
    "normal": lambda a: (a.wide, a.wide),
    "upper_factor": lambda a: (a.wide, a.wide),
    "line": lambda a: (max(a.nu + a.c, 2 * a.c, a.wide),),
    "spread": lambda a: (a.c,),
    "squared": lambda a: (a.q,),
    "own_force": lambda a: (a.c,),
    "tension": lambda a: (a.c,),
    # of every visit
    "visit_controls": lambda a: (a.most_visits, a.nu),
    "point": lambda a: (a.most_visits, a.K, 6),
    "multiplier": lambda a: (a.most_visits, a.K, 6),
    "violation": lambda a: (a.most_visits, a.K, a.M),
    "descent": lambda a: (a.most_visits, a.K, a.M),
    "value": lambda a: (a.most_visits,),
    "stationarity": lambda a: (a.most_visits,),
}
"""Arrays of double precision, one after the other."""

COUNTS: dict[str, Shape] = {
    "settings": lambda a: (len(SearchSizes._fields) + len(SearchSetting),),
    "findings": lambda a: (len(SearchFinding),),
    "resting": lambda a: (a.nu,),
    "start": lambda a: (a.K,),
    "still_modes": lambda a: (a.K,),
    "others": lambda a: (MOST_OTHERS, a.K),
    "next_modes": lambda a: (MOST_OTHERS, a.K),
    "dimensions": lambda a: (a.K, a.M),
    "used": lambda a: (a.K, a.M, a.r),
    "valid": lambda a: (a.K, a.M),
    "hull_nodes": lambda a: (a.m + 1,),
    "hull_edges": lambda a: (a.m, 2),
    "first": lambda a: (a.K + 1,),
    "pivots": lambda a: (a.c,),
    "row_place": lambda a: (a.K * a.r,),
    "active": lambda a: (a.wide,),
    # kept from solve to solve: where the next one begins
    "at_bound": lambda a: (a.nu,),
    "visit_bounds": lambda a: (a.most_visits, a.nu),
    "visit_rows": lambda a: (a.most_visits, a.wide),
    "row_count": lambda a: (a.most_visits,),
    "trial": lambda a: (a.K,),
    "minima": lambda a: (a.most_visits,),
    "visit_modes": lambda a: (a.most_visits, a.K),
    "solved": lambda a: (a.most_visits,),
    "weighed": lambda a: (a.most_visits,),
    "reached": lambda a: (a.most_visits,),
    "stationary": lambda a: (a.most_visits,),
    "complete": lambda a: (a.most_visits,),
    "kicked": lambda a: (a.most_visits,),
    "tried": lambda a: (a.most_visits,),
    "turn": lambda a: (a.most_visits,),
}
"""Arrays of whole numbers, one after the other."""
