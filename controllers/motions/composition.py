"""Goals of several controllers made one: weighed, put side by side, and faded into each other."""

from __future__ import annotations

from collections.abc import Sequence as Several

from warp_softbody.controllers.controller import ActivationCost, Goals
from warp_softbody.controllers.objectives import Objective
from warp_softbody.inputs.records import unchecked_copy


def weighed(objectives: Several[Objective], share: float) -> tuple[Objective, ...]:
    """Objectives that count ``share`` times as much; none at a share of 0."""
    if share == 1.0:
        return tuple(objectives)
    if share == 0.0:
        return ()
    return tuple(unchecked_copy(own, weight=share * own.weight) for own in objectives)


def faded(before: Goals | None, after: Goals | None, share: float) -> Goals | None:
    """Goals of a share from 0, those ``before``, to 1, those ``after``.

    Objectives count by their share, and so do effort and change. Contacts are those of ``after``,
    as one patch of the ground must not be there twice; who wants nothing fades in or out alone.
    """
    if share >= 1.0 or before is None:
        return after
    if after is None:
        return unchecked_copy(before, objectives=weighed(before.objectives, 1.0 - share))
    return unchecked_copy(
        after,
        objectives=(
            *weighed(before.objectives, 1.0 - share),
            *weighed(after.objectives, share),
        ),
        activation=_between(before.activation, after.activation, share),
    )


def _between(one: ActivationCost, other: ActivationCost, share: float) -> ActivationCost:
    return unchecked_copy(
        other,
        effort=one.effort + share * (other.effort - one.effort),
        change=one.change + share * (other.change - one.change),
    )
