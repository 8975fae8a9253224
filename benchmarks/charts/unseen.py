"""Whether tuned settings hold on other scenes: ``python -m benchmarks.charts.unseen``.

Variants of the passive scenes by their own settings. Each has a reference of its own, made as the
charts' are but shorter and coarser, and a small grid of meshes, elements and time steps. Two ways
of choosing settings for a bound are measured on it:

  stored  those that ship for the plain scene (``run SCENE --error``)
  tried   those that a few runs of the variant itself find (``tune SCENE --set ... --error``)

A choice holds if its error against the variant's reference is within the bound; its cost is over
that of the cheapest point of the variant's grid that holds. "-" where none is offered.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from warp_softbody import scenes
from warp_softbody.accuracy.analysis.design import job, reference_family, usable_meshes
from warp_softbody.accuracy.analysis.motion import Ruler
from warp_softbody.accuracy.analysis.reference import Reference, reference_of
from warp_softbody.accuracy.analysis.store import find
from warp_softbody.accuracy.analysis.trials import Trials
from warp_softbody.accuracy.cases.case import ChartCase
from warp_softbody.accuracy.cases.settings import Settings
from warp_softbody.accuracy.cases.table import CASES
from warp_softbody.accuracy.cases.track import body_size
from warp_softbody.accuracy.runs.journal import RunJournal
from warp_softbody.accuracy.runs.outcome import RunOutcome
from warp_softbody.accuracy.runs.running import run_job
from warp_softbody.errors import InputError

BOUNDS = (0.01, 0.02, 0.05, 0.1)
VARIANTS: Mapping[str, tuple[Mapping[str, float], ...]] = {
    "cantilever": (
        {"young_modulus": 5e5},
        {"young_modulus": 2e6},
        {"poisson_ratio": 0.3},
        {"poisson_ratio": 0.45},
    ),
    "twisted-bar": ({"torque": 5.0}, {"torque": 15.0}, {"hold": 0.2}),
    "drop-block": ({"speed": 0.5}, {"height": 0.1}, {"young_modulus": 2e5}, {"friction": 0.2}),
    "slope": ({"slope_degrees": 35.0}, {"friction": 0.3}, {"slope_degrees": 20.0}),
    "stack": ({"height": 0.02}, {"friction": 0.2}, {"young_modulus": 1.5e5}, {"count": 3.0}),
    "bounce-ball": ({"height": 0.15}, {"height": 0.5}),
}
WAYS = ("stored", "tried")


@dataclass(frozen=True, kw_only=True)
class UnseenChoice:
    """One way of choosing on one variant for one bound.

    Attributes:
        bound: asked for.
        error: against the variant's reference; None where no settings were offered.
        ratio: of its cost to the cheapest that holds; None where nothing does.
    """

    bound: float
    error: float | None
    ratio: float | None

    @property
    def held(self) -> bool:
        """Whether the error is within the bound."""
        return self.error is not None and self.error <= self.bound


class Variant:
    """A scene with settings of its own, its reference and its runs."""

    def __init__(self, scene: str, given: Mapping[str, float], folder: Path) -> None:
        """Run the reference and the grid, as far as the journal lacks them."""
        case = CASES[scene].quickly()
        self.case: ChartCase = replace(case, given={**case.given, **given})
        self._journal = RunJournal(folder, scene)
        grid = small_grid(self.case)
        family = {one: self.run(one) for one in reference_family(self.case)}
        size = body_size(scenes.make(scene, self.case.given).scene)
        self._ruler = Ruler(size=size, by_functionals=False)
        self.reference: Reference = reference_of(self.case, family, self._ruler)
        self.trials = Trials(self.case, self.run, self._ruler)
        self._points = {one: self.run(one) for one in grid}

    def run(self, settings: Settings) -> RunOutcome:
        """A run, made once."""
        made = job(self.case, settings)
        if made.key not in self._journal.outcomes:
            self._journal.add(made, run_job(made))
        return self._journal.outcomes[made.key]

    def choose(self, way: str, bound: float) -> Settings | None:
        """The settings that a way offers."""
        try:
            if way == "stored":
                return find(self.case.scene, bound).settings
            return self.trials.settle(bound).settings
        except InputError:
            return None

    def verdict(self, way: str, bound: float) -> UnseenChoice:
        """What became of them."""
        settings = self.choose(way, bound)
        if settings is None:
            return UnseenChoice(bound=bound, error=None, ratio=None)
        outcome = self.run(settings)
        self._points[settings] = outcome
        best = self.cheapest(bound)
        ratio = None if best is None else outcome.cost / best
        return UnseenChoice(bound=bound, error=self.reference.error(outcome), ratio=ratio)

    def cheapest(self, bound: float) -> float | None:
        """Cost of the cheapest known point that holds a bound, ms."""
        found = [(self.reference.error(one), one.cost) for one in self._points.values()]
        return min(
            (cost for error, cost in found if error is not None and error <= bound), default=None
        )


def small_grid(case: ChartCase) -> list[Settings]:
    """Meshes, time steps and both kinds of elements."""
    return [
        replace(case.default, cells=cells, level=level, time_step=step, elements=elements)
        for cells, level in usable_meshes(case)
        for step in case.time_steps
        for elements in ("linear", "smoothed")
    ]


def line(name: str, variant: Variant, way: str, verdicts: Sequence[UnseenChoice]) -> str:
    """A row of the table."""
    cells = []
    for one in verdicts:
        if one.error is None:
            cells.append(f"{'-':>14}")
            continue
        ratio = "" if one.ratio is None else f" x{one.ratio:.2f}"
        mark = " " if one.held else "!"
        cells.append(f"{100.0 * one.error:6.2f} %{mark}{ratio:>6}")
    known = 100.0 * variant.reference.uncertainty
    return f"{name:32} {known:5.2f} % {way:7}" + "".join(cells)


def totals(way: str, verdicts: Sequence[UnseenChoice]) -> str:
    """How many held, and at what cost."""
    offered = [one for one in verdicts if one.error is not None]
    held = sum(one.held for one in offered)
    ratios = sorted(one.ratio for one in offered if one.held and one.ratio is not None)
    dear = sum(ratio > 1.3 for ratio in ratios)
    middle = ratios[len(ratios) // 2] if ratios else float("nan")
    return (
        f"{way}: {held} of {len(offered)} offered hold, "
        f"{len(verdicts) - len(offered)} not offered; cost over the best: median {middle:.2f}, "
        f"above 1.3 in {dear} of {len(ratios)}"
    )


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.charts.unseen", description=__doc__)
    parser.add_argument("scenes", nargs="*", default=list(VARIANTS), metavar="SCENE")
    parser.add_argument("--journal", type=Path, default=Path("out/unseen"), metavar="FOLDER")
    args = parser.parse_args(arguments)
    bounds = "".join(f"{100.0 * bound:9.0f} %    " for bound in BOUNDS)
    print(f"{'variant':32} {'known':>7} {'way':7}{bounds}")
    every: dict[str, list[UnseenChoice]] = {way: [] for way in WAYS}
    for scene in args.scenes:
        for given in VARIANTS[scene]:
            variant = Variant(scene, given, args.journal)
            name = scene + "".join(f" {key}={value:g}" for key, value in given.items())
            for way in WAYS:
                verdicts = [variant.verdict(way, bound) for bound in BOUNDS]
                every[way] += verdicts
                print(line(name, variant, way, verdicts), flush=True)
    for way in WAYS:
        print(totals(way, every[way]))


if __name__ == "__main__":
    main()
