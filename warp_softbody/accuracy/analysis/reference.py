"""What the errors of a chart are measured against, and how well it is known itself.

The finest mesh F is run down to a time step c, the next coarser one B down to a smaller step s. The
reference is F(c) + B(s) - B(c): the finest mesh, with the rest of the way to dt = 0 as the coarser
one goes it; every term is the limit of steps dt and 2 dt at first order. A controlled body takes
other decisions on another mesh or at another step, and has no limit: its reference is the run F(c)
itself, and s = c / 2.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from warp_softbody.accuracy.analysis.design import reference_settings
from warp_softbody.accuracy.analysis.motion import (
    MeasuredMotion,
    Ruler,
    corrected,
    extrapolated,
    motion_of,
)
from warp_softbody.accuracy.cases.case import TIME_STEPS, ChartCase
from warp_softbody.accuracy.cases.settings import Settings
from warp_softbody.accuracy.runs.outcome import RunOutcome
from warp_softbody.errors import SoftBodyError

Outcomes = Mapping[Settings, RunOutcome]


@dataclass(frozen=True, kw_only=True)
class Reference:
    """The best motion there is, and the evidence for it; all distances are relative.

    Attributes:
        finest: settings of F(c).
        beside: settings of B(s).
        motion: the reference.
        mesh_change: distance of B(c) to F(c).
        time_change: distance of B(2 s) to B(s).
        mixed_change: of the way from 2 c to c on F to the same on B; none of a controlled body.
        ruler: that all distances of the chart are measured with.
        doubts: of each functional of a controlled body, its own two changes together.
    """

    finest: Settings
    beside: Settings
    motion: MeasuredMotion
    mesh_change: float
    time_change: float
    mixed_change: float
    ruler: Ruler
    doubts: Mapping[str, float] = field(default_factory=dict)

    @property
    def uncertainty(self) -> float:
        """The three changes together; errors below it cannot be told apart.

        Of a controlled body those of the functional that is known least. The changes that are told
        may be of two functionals, neither of which is in doubt by both.
        """
        if self.doubts:
            return max(self.doubts.values())
        return self.mesh_change + self.time_change + self.mixed_change

    def error(self, outcome: RunOutcome | None) -> float | None:
        """Distance of a run; None where it did not end well."""
        motion = motion_of(outcome)
        return None if motion is None else self.ruler.distance(motion, self.motion)

    def to_dict(self) -> dict[str, Any]:
        """Plain values."""
        return {
            "finest": self.finest.to_dict(),
            "beside": self.beside.to_dict(),
            "functionals": dict(self.motion.functionals),
            "mesh_change": self.mesh_change,
            "time_change": self.time_change,
            "mixed_change": self.mixed_change,
            "uncertainty": self.uncertainty,
            "doubts": dict(self.doubts),
        }


def reference_of(case: ChartCase, outcomes: Outcomes, ruler: Ruler) -> Reference:
    """Take it from the runs of its family.

    Raises:
        SoftBodyError: one of the runs that it needs did not end well, or it does nothing at all.
    """
    reference = _reference_of(case, outcomes, ruler)
    if not math.isfinite(reference.uncertainty):
        raise SoftBodyError(f"the reference of {case.scene!r} has a functional that is 0")
    return reference


def _reference_of(case: ChartCase, outcomes: Outcomes, ruler: Ruler) -> Reference:
    finest, beside = (reference_settings(case, *pair) for pair in (case.finest, case.beside))

    def limit(family: Settings, step: float) -> MeasuredMotion:
        return _limit(case, outcomes, replace(family, time_step=step))

    c, s = finest.time_step, beside.time_step
    fine, coarse = limit(finest, c), limit(beside, c)
    if case.controlled:
        by_mesh = ruler.differences(coarse, fine)
        by_time = ruler.differences(limit(beside, twice(s)), limit(beside, s))
        return Reference(
            finest=finest,
            beside=beside,
            motion=fine,
            mesh_change=max(by_mesh.values()),
            time_change=max(by_time.values()),
            mixed_change=0.0,
            ruler=ruler,
            doubts={name: share + by_time[name] for name, share in by_mesh.items()},
        )
    return Reference(
        finest=finest,
        beside=beside,
        motion=corrected(fine, limit(beside, s), coarse),
        mesh_change=ruler.distance(coarse, fine),
        time_change=ruler.distance(limit(beside, twice(s)), limit(beside, s)),
        mixed_change=ruler.distance(
            corrected(limit(finest, twice(c)), coarse, limit(beside, twice(c))), fine
        )
        if s < c
        else 0.0,
        ruler=ruler,
    )


def time_limit(case: ChartCase, outcomes: Outcomes, settings: Settings) -> MeasuredMotion | None:
    """The motion of these settings at dt to 0; None where no smaller time step was run."""
    steps = [step for step in TIME_STEPS if replace(settings, time_step=step) in outcomes]
    if len(steps) < 2 or min(steps) > settings.time_step:
        return None
    last = replace(settings, time_step=min(steps))
    if motion_of(outcomes[last]) is None or twice(last.time_step) not in steps:
        return None
    if not case.controlled and motion_of(outcomes[_doubled(last)]) is None:
        return None
    return _limit(case, outcomes, last)


def twice(step: float) -> float:
    """The next longer time step of the table."""
    return float(TIME_STEPS[TIME_STEPS.index(step) - 1])


def _doubled(settings: Settings) -> Settings:
    return replace(settings, time_step=twice(settings.time_step))


def _limit(case: ChartCase, outcomes: Outcomes, settings: Settings) -> MeasuredMotion:
    fine = _needed(case, outcomes, settings)
    # a controlled body takes other decisions at another time step
    if case.controlled:
        return fine
    return extrapolated(fine, _needed(case, outcomes, _doubled(settings)))


def _needed(case: ChartCase, outcomes: Outcomes, settings: Settings) -> MeasuredMotion:
    motion = motion_of(outcomes[settings])
    if motion is None:
        raise SoftBodyError(
            f"the reference of {case.scene!r} did not end well: {outcomes[settings].status}"
        )
    return motion
