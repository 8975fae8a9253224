"""Local minima of a contact QPCC from the modes of an earlier step, and from static contacts."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from warp_softbody.controllers.node import Node
from warp_softbody.controllers.pieces import LIFT, STICK
from warp_softbody.controllers.qpcc import FloatArray
from warp_softbody.controllers.search import LocalMinimum, Search
from warp_softbody.errors import InputError

BoolArray = npt.NDArray[np.bool_]

WORTH = 0.5
"""Static contacts up to this share of the value above a minimum are still descended from: on
``balance-i`` that halves the gap that descending from better ones alone leaves; 1 gains no more."""


def static_modes(search: Search, touching: BoolArray | None) -> tuple[int, ...]:
    """Touching contacts stick, by default all; the others lift."""
    count = search.reduced.problem.contact_count
    if touching is None:
        return (STICK,) * count
    if np.shape(touching) != (count,):
        raise InputError(f"touching must be {count} truth values, got {touching!r}")
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
    whole = all(mode == int(mode) and 0 <= mode < highest for mode in start)
    if len(start) != count or not whole:
        raise InputError(
            f"start must be {count} modes from 0 to {highest - 1}, got {tuple(start)!r}"
        )
    return tuple(int(mode) for mode in start)
