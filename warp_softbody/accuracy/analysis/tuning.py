"""The cheapest settings that hold a bound, chosen from a chart, with what was left out and why."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from warp_softbody.accuracy.analysis.design import reference_family
from warp_softbody.accuracy.cases.settings import Settings
from warp_softbody.errors import InputError

if TYPE_CHECKING:
    from warp_softbody.accuracy.analysis.chart import Chart, Point
    from warp_softbody.accuracy.analysis.family import Family, Worst
    from warp_softbody.accuracy.cases.case import ChartCase

MARGIN = 0.8
"""Share of the bound that the error and the reference's own uncertainty together may take, of a
passive body, and that the error of a controlled one may take on other floors. On its own floor that
may take it all: nothing is extrapolated there, so that what the last refinement changes, of which
the method leaves a third, counts whole."""
ALIKE = 0.1
"""Costs that differ by less than this share count as equal: then the fewest changes are best."""
SHOWN = 4


@dataclass(frozen=True, kw_only=True)
class Tuned:
    """Settings that hold a bound.

    Attributes:
        scene: its name.
        given: settings of the scene that the chart was made with, beside `Settings.cells`.
        seconds: simulated by the chart.
        bound: relative error asked for.
        settings: the knobs.
        error: found, with `uncertainty` that of the reference.
        elsewhere: largest error on the family of the scene; None where it has none.
        cost: ms of CPU time per simulated second, on the machine of the chart.
        default_cost, default_error: of what is shipped.
        left_out: sentences.
        version: of the program.
    """

    scene: str
    given: Mapping[str, float]
    seconds: float
    bound: float
    settings: Settings
    error: float
    uncertainty: float
    cost: float
    default_cost: float
    default_error: float
    left_out: tuple[str, ...]
    version: str
    elsewhere: float | None = None

    def to_dict(self) -> dict[str, Any]:
        """Plain values."""
        return {**asdict(self), "given": dict(self.given), "left_out": list(self.left_out)}

    def taken(self) -> dict[str, Any]:
        """What a run that takes the settings tells of them."""
        return {"bound": self.bound, "error": self.error, "settings": self.settings.to_dict()}

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> Tuned:
        """Back from `to_dict`."""
        return cls(
            **{
                **values,
                "settings": Settings.from_dict(values["settings"]),
                "left_out": tuple(values["left_out"]),
            }
        )


def margin(case: ChartCase) -> float:
    """Share of the bound that error and uncertainty may take."""
    return 1.0 if case.controlled else MARGIN


def choose(chart: Chart, bound: float, family: Family | None = None) -> Tuned:
    """The cheapest point that holds ``bound`` with the margin, of those alike the plainest.

    It holds it with `MARGIN` on the whole ``family`` too, where the doubt of the reference is not
    counted again. The reference's own runs are no settings to choose: nothing says
    what they err by.

    Raises:
        InputError: none does; the sentence says what the chart can promise.
    """
    floor, allowed = chart.reference.uncertainty, margin(chart.case)
    own = set(reference_family(chart.case))
    eligible = [point for point in chart.points if point.eligible and point.settings not in own]
    holding = [point for point in eligible if _error(point) + floor <= allowed * bound]
    if not holding:
        raise InputError(_nothing_holds(chart, eligible, bound))
    chosen, worst, passed = _choose(chart, holding, family, bound)
    default = chart.default
    return Tuned(
        scene=chart.case.scene,
        given=chart.case.given,
        seconds=chart.case.seconds,
        bound=bound,
        settings=chosen.settings,
        error=_error(chosen),
        uncertainty=floor,
        cost=chosen.outcome.cost,
        default_cost=default.outcome.cost,
        default_error=_error(default),
        left_out=tuple([*passed, *_left_out(chart, chosen)]),
        version=chart.version,
        elsewhere=None if worst is None else worst.error,
    )


def _nothing_holds(chart: Chart, eligible: list[Point], bound: float) -> str:
    """The sentence that says what a chart can promise instead."""
    floor, allowed = chart.reference.uncertainty, margin(chart.case)
    said = " with the margin" if allowed < 1.0 else ""
    best = min((_error(point) for point in eligible), default=math.inf)
    return (
        f"no settings of {chart.case.scene!r} hold {_percent(bound)}{said}: the best point is "
        f"off by {_percent(best)}, and the reference is only known to {_percent(floor)}; the "
        f"least bound that can be held is {_percent(_above((best + floor) / allowed))}"
    )


def _choose(
    chart: Chart, holding: list[Point], family: Family | None, bound: float
) -> tuple[Point, Worst | None, list[str]]:
    """The point, its largest error on the family, and sentences about cheaper ones that err there.

    Raises:
        InputError: every point errs by more somewhere.
    """
    left, passed, least = list(holding), list[str](), math.inf
    while left:
        chosen = _plainest(chart, left)
        worst = None if family is None else family.worst(chosen)
        if worst is None or worst.error <= MARGIN * bound:
            return chosen, worst, passed
        left.remove(chosen)
        least = min(least, worst.error)
        told = chosen.settings.differences(chart.case.default)
        passed.append(f"{told}: an error of {100.0 * worst.error:.2g} % with {worst.where}")
    raise InputError(
        f"settings of {chart.case.scene!r} hold {_percent(bound)} as it ships but not elsewhere: "
        f"{passed[-1]}; the least bound that can be held is {_percent(_above(least / MARGIN))}"
    )


def _plainest(chart: Chart, holding: list[Point]) -> Point:
    default = chart.case.default
    least = min(point.outcome.cost for point in holding)
    alike = [point for point in holding if point.outcome.cost <= (1.0 + ALIKE) * least]
    return min(alike, key=lambda p: (p.settings.changes(default), p.outcome.cost))


def _error(point: Point) -> float:
    return float("inf") if point.error is None else point.error


def _left_out(chart: Chart, chosen: Point) -> list[str]:
    """Cheaper points of the frontier, which err too much, then dearer ones, the nearest first."""
    default = chart.case.default
    cheaper = [p for p in chart.frontier if _error(p) > _error(chosen)][::-1][:SHOWN]
    dearer = [p for p in chart.frontier if _error(p) < _error(chosen)]
    dearer = [p for p in dearer if p.outcome.cost > chosen.outcome.cost][:SHOWN]
    told = [
        f"{p.settings.differences(default)}: {_ratio(p, chosen)} of the cost, "
        f"but an error of {100.0 * _error(p):.2g} %"
        for p in cheaper
    ]
    told += [
        f"{p.settings.differences(default)}: not needed; an error of {100.0 * _error(p):.2g} % "
        f"for {_ratio(p, chosen)} of the cost"
        for p in dearer
    ]
    unsettled = [
        p
        for p in chart.points
        if p.solver == "ours" and not p.eligible and p.outcome.cost < chosen.outcome.cost
    ]
    if unsettled:
        told.append(f"{len(unsettled)} cheaper points that did not settle, shake or failed")
    return told


def _above(share: float) -> float:
    """Rounded up to the two digits that are told, so that the bound told can be held."""
    if not math.isfinite(share):
        return share
    digit = 10.0 ** (math.floor(math.log10(share)) - 1)
    return math.ceil(share / digit) * digit


def _percent(share: float) -> str:
    return f"{100.0 * share:.2g}%"


def _ratio(point: Point, chosen: Point) -> str:
    return f"{point.outcome.cost / chosen.outcome.cost:.2g}"
