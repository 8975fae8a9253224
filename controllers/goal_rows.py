"""Rows of J out of what is wanted of a step, and refusals of what no step can answer."""

from __future__ import annotations

import math

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.controller import Goals
from warp_softbody.engine.reduced_dynamics import Maps
from warp_softbody.errors import InputError
from warp_softbody.world.view import BodyView


def check_sizes(goals: Goals, view: BodyView) -> None:
    """Refuse rows, weights and segments that are not of this body."""
    count = view.node_count
    for objective in goals.objectives:
        if objective.rows.shape[1] != 3 * count:
            raise InputError(
                f"objective {objective.name!r}: rows must have {3 * count} columns, three a node, "
                f"not {objective.rows.shape[1]}"
            )
    for number, patch in enumerate(goals.patches):
        if len(patch.weights) != count:
            raise InputError(
                f"patch {number}: weights must be {count}, one a node, not {len(patch.weights)}"
            )
    if goals.resting and max(goals.resting) >= len(view.activations):
        raise InputError(
            f"Goals.resting holds segment {max(goals.resting)}, but there are "
            f"{len(view.activations)} segments"
        )


def rows_of(goals: Goals, view: BodyView) -> FloatArray:
    """All rows (r, 3n) of what is wanted."""
    count = view.node_count
    wanted = [objective.rows for objective in goals.objectives]
    begin = sum(map(len, wanted))
    every = np.empty((begin + 3 * len(goals.patches), 3 * count))
    if wanted:
        np.concatenate(wanted, out=every[:begin])
    by_node = every[begin:].reshape(-1, 3, count, 3)
    for patch, rows in zip(goals.patches, by_node, strict=True):
        np.multiply(patch.frame[:, None, :], patch.weights[:, None], out=rows)
    if not math.isfinite(np.add.reduce(every, axis=None)):
        _refuse_infinite(goals, every, "rows")
    return every


def check_maps(goals: Goals, maps: Maps) -> None:
    """Refuse what an objective's size has made infinite on the way through the engine."""
    answers = (maps.compliance, maps.free_velocity[:, None], maps.muscle_map)
    if not math.isfinite(sum(float(np.add.reduce(one, axis=None)) for one in answers)):
        _refuse_infinite(goals, np.concatenate(answers, axis=1), "responses of the body")


def _refuse_infinite(goals: Goals, by_row: FloatArray, what: str) -> None:
    wrong = np.flatnonzero(~np.isfinite(by_row).all(axis=1))
    if not wrong.size:
        return
    names = [f"objective {o.name!r}" for o in goals.objectives for _ in range(len(o.rows))]
    names += [f"patch {number}" for number in range(len(goals.patches)) for _ in range(3)]
    raise InputError(f"{names[wrong[0]]}: {what} are not finite")
