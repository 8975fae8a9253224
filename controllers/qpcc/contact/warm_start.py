"""Local minima of a contact QPCC from the modes of an earlier step, and from static contacts."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from warp_softbody.arrays import BoolArray, FloatArray
from warp_softbody.controllers.qpcc.contact.local_search import ContactSearch, LocalMinimum
from warp_softbody.controllers.qpcc.contact.mode_minimiser import ModeMinimiser
from warp_softbody.controllers.qpcc.contact.mode_table import LIFT, STICK
from warp_softbody.errors import InputError
from warp_softbody.inputs import checks

WORTH = 0.5
"""How far above a minimum, relative to its value, static contacts are still descended from: on
``balance-i`` that halves the gap left by descending from better ones alone; 1 gains no more."""


def static_modes(search: ContactSearch, touching: BoolArray | None) -> tuple[int, ...]:
    """Touching contacts stick, by default all; the others lift."""
    count = search.scaled.problem.contact_count
    if touching is None:
        return (STICK,) * count
    try:
        given = np.asarray(touching)
    except Exception:
        # rows of unequal length, or an object whose own conversion fails
        checks.refuse("touching", f"{count} truth values", touching)
    if given.shape != (count,) or (count and given.dtype != np.bool_):
        checks.refuse("touching", f"{count} truth values", touching)
    return tuple(STICK if holds else LIFT for holds in touching)


def warm_minima(
    search: ContactSearch,
    start: Sequence[int] | FloatArray | None,
    static: tuple[int, ...],
    others: Sequence[Sequence[int]] = (),
) -> list[LocalMinimum]:
    """Local minima below the start, static contacts and others; none if the former have no point.

    The QP of static contacts is solved in every step, so that the result is never worse; where a
    bound shows that it ends far above that of the start it is not solved to the end. From step to
    step minima overtake one another, so that those which came next are looked at again; they are
    given up like kicks (``reach``).
    """
    wanted = "choices of modes, one for every contact"
    given = [
        _checked_modes(search, "others", one) for one in checks.several("others", others, wanted)
    ]
    root = None if start is None else search.visit(_checked_modes(search, "start", start))
    if root is None:
        root = search.visit(static)
        minima = [] if root is None else [search.descend(root)]
    else:
        still = search.visit(static, limit=_worth(root))
        minima = [search.descend(root)]
        if still is not None and still.value <= _worth(minima[0].minimiser):
            search.add_minimum(minima, still)
    for modes in given if minima else []:
        found = search.visit(modes, limit=search.within_reach(search.lowest(minima).minimiser))
        if found is not None:
            search.add_minimum(minima, found)
    return minima


def _worth(minimiser: ModeMinimiser) -> float:
    return minimiser.value + WORTH * abs(minimiser.value)


def _checked_modes(
    search: ContactSearch, name: str, start: Sequence[int] | FloatArray
) -> tuple[int, ...]:
    count = search.scaled.problem.contact_count
    highest = search.scaled.table.valid.shape[1]
    wanted = f"{count} modes from 0 to {highest - 1}"
    given = checks.several(name, start, wanted)
    if len(given) != count:
        checks.refuse(name, wanted, given)
    try:
        return tuple(checks.whole(f"a mode of {name}", mode, high=highest - 1) for mode in given)
    except InputError:
        checks.refuse(name, wanted, given)
