"""Whether settings of a motion hold on runs that they were not chosen by.

A chart is of one run. Settings that err little there may err more on another floor, where a coarser
mesh or a longer step answers otherwise, and later on, where small differences have added up. So a
candidate is run on a family of floors too, and to the end of the scene where the chart ends before.
There are no references there: what is other is taken from the settings that ship, on the usual mesh
where a coarser one ships, and the reference of the chart is changed by as much.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from warp_softbody import scenes
from warp_softbody.accuracy.analysis.motion import MeasuredMotion, motion_of, responding

if TYPE_CHECKING:
    from warp_softbody.accuracy.analysis.chart import Chart, Point
    from warp_softbody.accuracy.cases.case import ChartCase
    from warp_softbody.accuracy.cases.settings import Settings
    from warp_softbody.accuracy.runs.outcome import RunOutcome

FACTORS: Mapping[str, tuple[float, ...]] = {"friction": (0.8, 1.2)}
"""Factors on settings of the scene, one member of the family each."""

Run = Callable[["ChartCase", "Settings"], "RunOutcome"]


@dataclass(frozen=True, kw_only=True)
class Worst:
    """The largest error of some settings on a family.

    Attributes:
        error: relative, as in the chart; infinite where a run fails, shakes or loses its volume.
        where: what is other there.
    """

    error: float
    where: str


def members(case: ChartCase) -> dict[str, ChartCase]:
    """The case on other floors and to its end, by what is other; none where it is passive."""
    if not case.controlled:
        return {}
    plan = scenes.make(case.scene, case.given)
    family = {
        f"{name} {value:g}": replace(case, given={**case.given, name: value})
        for name, factors in FACTORS.items()
        if name in plan.settings
        for value in (plan.settings[name] * factor for factor in factors)
    }
    if plan.seconds > case.seconds:
        family[f"all of its {plan.seconds:g} s"] = replace(case, seconds=plan.seconds)
    return family


class Family:
    """Runs candidates of a chart on its family, when they are asked for."""

    def __init__(self, chart: Chart, run: Run) -> None:
        """``run`` makes a run, or finds it in a journal."""
        self._chart = chart
        self._run = run
        self._members = members(chart.case)
        self._references: dict[str, MeasuredMotion | None] = {}

    def worst(self, point: Point) -> Worst | None:
        """The largest error of a point; None where there is no family."""
        found = [
            Worst(error=self._error(where, case, point), where=where)
            for where, case in self._members.items()
        ]
        return max(found, key=lambda one: one.error, default=None)

    def _error(self, where: str, case: ChartCase, point: Point) -> float:
        reference = self._reference(where, case)
        if point.settings == self._chart.case.usual:
            # the reference there is made from this run, which tells nothing new
            return point.error if point.error is not None and reference else math.inf
        outcome = self._run(case, point.settings)
        motion = motion_of(outcome)
        sound = replace(point, outcome=outcome).eligible
        if reference is None or motion is None or not sound:
            return math.inf
        return self._chart.reference.ruler.distance(motion, reference)

    def _reference(self, where: str, case: ChartCase) -> MeasuredMotion | None:
        if where not in self._references:
            here = motion_of(self._chart.of(case.usual).outcome)
            there = motion_of(self._run(case, case.usual))
            self._references[where] = (
                None
                if here is None or there is None
                else responding(self._chart.reference.motion, there, here)
            )
        return self._references[where]
