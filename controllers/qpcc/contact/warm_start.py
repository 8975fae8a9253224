"""Local minima of a contact QPCC from the modes of an earlier step, and from static contacts."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from warp_softbody.arrays import BoolArray, FloatArray
from warp_softbody.controllers.qpcc.contact.local_search import LocalMinimum, Search
from warp_softbody.controllers.qpcc.contact.mode_qp import Node
from warp_softbody.controllers.qpcc.contact.mode_table import LIFT, STICK
from warp_softbody.errors import InputError
from warp_softbody.inputs import checks

WORTH = 0.5
"""Static contacts up to this share of the value above a minimum are still descended from: on
``balance-i`` that halves the gap that descending from better ones alone leaves; 1 gains no more."""


def static_modes(search: Search, touching: BoolArray | None) -> tuple[int, ...]:
    """Touching contacts stick, by default all; the others lift."""
    count = search.reduced.problem.contact_count
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
    search: Search, start: Sequence[int] | FloatArray | None, static: tuple[int, ...]
) -> list[LocalMinimum]:
    """Descents from the start and from static contacts; none if neither has a point.

    Static contacts are looked at in every step, so that the result is never worse than they are;
    where a bound shows that their QP ends far above the start's, it is not solved to the end.
    """
    root = None if start is None else search.visit(_checked(search, start))
    if root is None:
        root = search.visit(static)
        return [] if root is None else [search.descend(root)]
    still = search.visit(static, limit=_worth(root))
    minima = [search.descend(root)]
    if still is not None and still.value <= _worth(minima[0].node):
        minima.append(search.descend(still))
    return minima


def _worth(node: Node) -> float:
    return node.value + WORTH * abs(node.value)


def _checked(search: Search, start: Sequence[int] | FloatArray) -> tuple[int, ...]:
    count = search.reduced.problem.contact_count
    highest = search.reduced.table.valid.shape[1]
    wanted = f"{count} modes from 0 to {highest - 1}"
    given = checks.several("start", start, wanted)
    if len(given) != count:
        checks.refuse("start", wanted, given)
    try:
        return tuple(checks.whole("a mode of start", mode, high=highest - 1) for mode in given)
    except InputError:
        checks.refuse("start", wanted, given)
