"""The chart of a scene: its points with cost and error, the frontier, and the reference."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

from warp_softbody import __version__, scenes
from warp_softbody.accuracy.analysis.design import (
    Measured,
    first_points,
    frontier,
    grid,
    job,
    neighbours,
    products,
    reference_family,
)
from warp_softbody.accuracy.analysis.motion import Ruler, motion_of
from warp_softbody.accuracy.analysis.reference import Reference, reference_of, time_limit
from warp_softbody.accuracy.cases.case import ChartCase
from warp_softbody.accuracy.cases.functionals import FUNCTIONALS
from warp_softbody.accuracy.cases.settings import Settings
from warp_softbody.accuracy.cases.track import body_size
from warp_softbody.accuracy.runs.journal import RunJournal
from warp_softbody.accuracy.runs.outcome import RunOutcome
from warp_softbody.accuracy.runs.sweep import Progress, sweep

SETTLED = 0.1
"""Largest share of steps that may not settle in a point of the frontier."""

ROUNDS = 2
"""How often the neighbours of the frontier are run."""

Tell = Callable[[str], Progress]
"""Told what begins; returns what is told how far it is."""


@dataclass(frozen=True, kw_only=True)
class Point:
    """A point of a chart.

    Attributes:
        settings: its knobs; a peer's own time step.
        solver: "ours" or a peer's name.
        outcome: of its run.
        error: against the reference, relative; None where the run did not end well.
        time_error: against the same at dt to 0, where that was run.
        space_error: against the reference's mesh and elements at the same dt, where that was run.
        on_frontier: whether none of ours is both cheaper and better.
    """

    settings: Settings
    solver: str = "ours"
    outcome: RunOutcome
    error: float | None
    time_error: float | None = None
    space_error: float | None = None
    on_frontier: bool = False

    @property
    def eligible(self) -> bool:
        """Whether it may stand on the frontier."""
        good = self.solver == "ours" and self.error is not None
        return good and self.outcome.unconverged <= SETTLED and self.sound

    @property
    def sound(self) -> bool:
        """Whether all that has to stay small does."""
        return all(
            value <= (FUNCTIONALS[name].limit or math.inf)
            for name, value in self.outcome.functionals.items()
        )


@dataclass(frozen=True, kw_only=True)
class Chart:
    """All points of a scene."""

    case: ChartCase
    reference: Reference
    points: tuple[Point, ...]
    version: str = __version__

    @property
    def frontier(self) -> list[Point]:
        """By rising cost."""
        chosen = [point for point in self.points if point.on_frontier]
        return sorted(chosen, key=lambda point: point.outcome.cost)

    @property
    def default(self) -> Point:
        """As shipped."""
        return self.of(self.case.default)

    def of(self, settings: Settings) -> Point:
        """Our own point with these settings."""
        (point,) = (p for p in self.points if p.settings == settings and p.solver == "ours")
        return point


def make_chart(
    case: ChartCase, journal: RunJournal, executor: Executor, tell: Tell, *, peers: bool = False
) -> Chart:
    """Run what the journal lacks, and judge it all.

    Raises:
        SoftBodyError: the reference could not be made.
    """
    outcomes = _run(case, first_points(case), journal, executor, tell("first points"))
    scene = scenes.make(case.scene, case.given).scene
    ruler = Ruler(size=body_size(scene), by_functionals=case.controlled)
    reference = reference_of(case, outcomes, ruler)
    more = products(case, _measured(outcomes, reference))
    outcomes |= _run(case, more, journal, executor, tell("combinations"))
    for number in range(ROUNDS):
        more = neighbours(case, _measured(outcomes, reference), reference.uncertainty)
        outcomes |= _run(case, more, journal, executor, tell(f"neighbours, round {number + 1}"))
    points = [point_of(case, reference, outcomes, settings) for settings in outcomes]
    points = with_frontier(case, points, reference)
    if peers:
        points += _peer_points(case, reference, journal, executor, tell("peers"))
    return Chart(case=case, reference=reference, points=tuple(points))


def _run(
    case: ChartCase,
    settings: Sequence[Settings],
    journal: RunJournal,
    executor: Executor,
    progress: Progress,
) -> dict[Settings, RunOutcome]:
    jobs = {one: job(case, one) for one in settings}
    outcomes = sweep(list(jobs.values()), journal, executor, progress)
    return {one: outcomes[made.key] for one, made in jobs.items()}


def _peer_points(
    case: ChartCase,
    reference: Reference,
    journal: RunJournal,
    executor: Executor,
    progress: Progress,
) -> list[Point]:
    """Peers at every time step, on the scene's own mesh and, where that is charted, refined."""
    jobs = [
        job(case, replace(settings, precision="float64"), name)
        for name in case.peers
        for settings in grid(case)
        if settings.cells is None
    ]
    found = sweep(jobs, journal, executor, progress)
    return [
        Point(
            settings=one.settings,
            solver=one.solver,
            outcome=found[one.key],
            error=reference.error(found[one.key]),
        )
        for one in jobs
    ]


def _measured(outcomes: dict[Settings, RunOutcome], reference: Reference) -> list[Measured]:
    found = []
    for settings, outcome in outcomes.items():
        error = reference.error(outcome)
        if error is not None:
            found.append(Measured(settings=settings, cost=outcome.cost, error=error))
    return found


def point_of(
    case: ChartCase, reference: Reference, outcomes: dict[Settings, RunOutcome], settings: Settings
) -> Point:
    """A run on the chart, with the parts of its error that other runs tell apart."""
    outcome = outcomes[settings]
    motion = motion_of(outcome)
    limit = time_limit(case, outcomes, settings)
    fine = replace(reference.finest, time_step=settings.time_step)
    beside = motion_of(outcomes.get(fine))
    distance = reference.ruler.distance
    return Point(
        settings=settings,
        outcome=outcome,
        error=reference.error(outcome),
        time_error=distance(motion, limit) if motion and limit else None,
        space_error=distance(motion, beside) if motion and beside else None,
    )


def with_frontier(case: ChartCase, points: Sequence[Point], reference: Reference) -> list[Point]:
    """The points with those on the frontier marked.

    The runs of the reference itself, dearer than need be, are left out.
    """
    left_out = set(reference_family(case))
    eligible = [
        Measured(settings=p.settings, cost=p.outcome.cost, error=p.error)
        for p in points
        if p.eligible and p.error is not None and p.settings not in left_out
    ]
    chosen = {point.settings for point in frontier(eligible, reference.uncertainty)}
    return [replace(point, on_frontier=point.settings in chosen) for point in points]
