"""One run of a candidate in one member of its family, and what it costs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.gains.cases import CASES, Changes, GainCase
from benchmarks.motions.criteria import CRITERIA, SOUND
from benchmarks.motions.criterion import Criterion
from benchmarks.robustness.batch_runs import run_together
from benchmarks.robustness.outcomes import Cell
from benchmarks.robustness.variation import Variation
from warp_softbody import scenes
from warp_softbody.scenes import ScenePlan
from warp_softbody.world.frame import Frame

LYING = 0.62
"""Share of the first height of the mean node: a letter on its side has 0.59, one that crouches
before it jumps 0.65."""

NEARNESS = 0.02
"""What it costs to be near all bounds that a run holds, so that of two that hold all the one with
more room is better."""

MEAN = 0.1
"""How much the mean over a family counts beside its worst member."""


@dataclass(frozen=True, kw_only=True)
class Trial:
    """What came of a run: the number of every criterion, or until when it went well, s."""

    values: Mapping[str, float]
    lasted: float = 0.0


class Fall:
    """Tells the frame with which a body lies, and keeps the time of the last one it saw."""

    def __init__(self, *, stands: bool) -> None:
        """Look out for a fall only where the body is to stand."""
        self._stands = stands
        self._first: float | None = None
        self.time = 0.0

    def __call__(self, frame: Frame) -> bool:
        """Whether the body lies in this frame."""
        height = float(frame.positions[:, 2].mean())
        self._first = height if self._first is None else self._first
        self.time = frame.time
        return self._stands and height < LYING * self._first


def make_trials(
    scene: str,
    candidates: Sequence[Changes],
    member: Variation,
    seconds: float | None,
    meshes: Path,
) -> list[Trial]:
    """Run the scene of that name with the gains of each candidate in one member of a family."""
    case = CASES[scene]
    falls = [Fall(stands=case.stands) for _ in candidates]
    cell = Cell(scene=scene, variation=member, seconds=seconds)
    makes = [partial(_made, case, gains) for gains in candidates]
    outcomes = run_together(cell, meshes, makes, falls)
    return [
        Trial(values=outcome.values, lasted=fall.time)
        for outcome, fall in zip(outcomes, falls, strict=True)
    ]


def _made(case: GainCase, gains: Changes, scene: str, settings: Mapping[str, float]) -> ScenePlan:
    del scene
    return case.plan(gains, settings)


def missing(criterion: Criterion, bound: float, value: float, margin: float) -> float:
    """What is missing to a bound with a margin, as a share of it, at most 1; 0 where it is held."""
    wanted = bound * (1.0 + margin if criterion.at_least else 1.0 - margin)
    short = wanted - value if criterion.at_least else value - wanted
    return float(np.clip(short / abs(wanted), 0.0, 1.0)) if np.isfinite(value) else 1.0


def trial_cost(case: GainCase, trial: Trial, margin: float) -> float:
    """Sum of what is missing to the criteria; up to twice their number where the body fell.

    The sooner it fell the more. Where it did not, `NEARNESS` times the mean share of the bounds
    that are not to be reached is added.
    """
    criteria = (*CRITERIA[case.scene], *SOUND)
    if not trial.values:
        share = trial.lasted / scenes.recipe(case.scene).seconds
        return len(criteria) * (2.0 - min(1.0, share))
    bounds = {one.name: case.bounds.get(one.name, one.bound) for one in criteria}
    values = trial.values
    short = sum(missing(one, bounds[one.name], values[one.name], margin) for one in criteria)
    near = [_share(values[one.name], bounds[one.name]) for one in criteria if not one.at_least]
    return short + NEARNESS * float(np.mean(near))


def _share(value: float, bound: float) -> float:
    return float(np.clip(value / bound, 0.0, 1.0)) if np.isfinite(value) else 1.0


def family_cost(costs: Sequence[float], members: int) -> float:
    """The worst of some members, and a little of the mean over all; those not run cost nothing.

    So it never falls when another member is added, and a candidate may be given up as soon as it
    has passed the best so far.
    """
    if not costs:
        return 0.0
    return (max(costs) + MEAN * sum(costs) / members) / (1.0 + MEAN)
