"""The cheapest settings of a scene that has no chart, from a few runs of the scene itself.

A small reference is made first: meshes are refined until one hardly errs, smoothed elements on each
against the next finer one; on that mesh time steps are halved until their limits agree. Where the
finest mesh still leaves much in doubt, two runs of a finer one yet correct it. Then points are run
by rising cost until one holds: its distance from the reference and the doubt about that, which is
on the safe side, are together within the bound.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from warp_softbody import __version__, scenes
from warp_softbody.accuracy.analysis.chart import SETTLED
from warp_softbody.accuracy.analysis.design import usable_meshes
from warp_softbody.accuracy.analysis.motion import (
    MeasuredMotion,
    Ruler,
    corrected,
    extrapolated,
    motion_of,
)
from warp_softbody.accuracy.analysis.tuning import Tuned
from warp_softbody.accuracy.cases.case import TIME_STEPS, ChartCase
from warp_softbody.accuracy.cases.settings import Settings
from warp_softbody.accuracy.cases.track import body_size
from warp_softbody.accuracy.runs.outcome import RunOutcome
from warp_softbody.engine.options import NamedElements
from warp_softbody.errors import InputError, SoftBodyError

Run = Callable[[Settings], RunOutcome]

SECOND_ORDER = 2.0
DOUBT = 0.1
"""Share of the bound that mesh and time step may each leave the small reference unsure of."""

HALVINGS = 4
"""Most of them, beyond the shipped time step."""

MOST_TETS = 20_000
"""Of the finer mesh, so that it takes seconds."""


@dataclass(frozen=True, kw_only=True)
class AcceptedSettings:
    """Settings that hold.

    Attributes:
        settings: the knobs.
        error: against the small reference.
        doubt: how far that may be off.
        cost: ms of CPU time per simulated second.
    """

    settings: Settings
    error: float
    doubt: float
    cost: float


def tuned_by_trials(case: ChartCase, run: Run, bound: float) -> Tuned:
    """The settings of a passive case for a bound, as `choose` takes them from a chart.

    Raises:
        InputError: none hold it, or the scene is controlled, so that its motions part.
    """
    if case.controlled:
        raise InputError(
            f"{case.scene!r} is controlled, and can be tuned with its own settings only"
        )
    size = body_size(scenes.make(case.scene, case.given).scene)
    trials = Trials(case, run, Ruler(size=size, by_functionals=False))
    trial = trials.settle(bound)
    default_error = trials.error(case.default)
    return Tuned(
        scene=case.scene,
        given=case.given,
        seconds=case.seconds,
        bound=bound,
        settings=trial.settings,
        error=trial.error,
        uncertainty=trial.doubt,
        cost=trial.cost,
        default_cost=trials.outcomes[case.default].cost,
        default_error=default_error,
        left_out=(f"{len(trials.outcomes) - 1} other runs of these settings of the scene",),
        version=__version__,
    )


class Trials:
    """Runs of one scene, each made once, and what they say of its errors.

    Attributes:
        outcomes: of the runs so far.
    """

    def __init__(
        self,
        case: ChartCase,
        run: Run,
        ruler: Ruler,
        *,
        doubt: float = DOUBT,
        most_tets: int = MOST_TETS,
    ) -> None:
        """Nothing is run yet.

        Args:
            case: the scene with its meshes and time steps.
            run: makes a run of some settings.
            ruler: measures distances between motions.
            doubt: share of the bound that mesh and time step may each leave unsure.
            most_tets: of the finer mesh that sharpens the reference.
        """
        self._doubt, self._most_tets = doubt, most_tets
        self._case = case
        self._run = run
        self._ruler = ruler
        self._meshes = usable_meshes(case)
        if len(self._meshes) == 1:
            cells, level = self._meshes[0]
            self._meshes.append((cells, level + 1))
        self._reference: MeasuredMotion | None = None
        self.outcomes: dict[Settings, RunOutcome] = {}

    def error(self, settings: Settings) -> float:
        """Distance from the small reference of the last `settle`."""
        found = motion_of(self._outcome(settings))
        if found is None or self._reference is None:
            return float("inf")
        return self._ruler.distance(found, self._reference)

    def settle(self, bound: float) -> AcceptedSettings:
        """The cheapest settings that are near enough to the small reference.

        Raises:
            InputError: none of the case's meshes and time steps is, or it cannot be told.
        """
        scene = self._case.scene
        spaces = self._spaces(self._doubt * bound)
        smoothed = [base for base in spaces if base.elements == "smoothed"]
        finest = min(smoothed, key=lambda base: spaces[base])
        motion, change = self._limit(finest, self._doubt * bound)
        doubt = spaces[finest] + change
        tets = 8 * self._outcome(finest).tets
        coarse = spaces[finest] > self._doubt * bound and change < bound
        if coarse and tets <= self._most_tets:
            motion, doubt = self._corrected(finest, motion, change)
        self._reference = motion
        if doubt >= bound:
            raise InputError(
                f"no bound of {100.0 * bound:.2g}% can be held in {scene!r}: its motion is only "
                f"known to {100.0 * doubt:.2g}%"
            )
        held: list[AcceptedSettings] = []
        for settings, guess in self._by_cost([base for base in spaces if spaces[base] <= bound]):
            if held and guess >= min(trial.cost for trial in held):
                break
            error, outcome = self.error(settings), self._outcome(settings)
            if error + doubt <= bound and outcome.unconverged <= SETTLED:
                held.append(
                    AcceptedSettings(settings=settings, error=error, doubt=doubt, cost=outcome.cost)
                )
        if not held:
            raise InputError(f"no mesh and time step tried holds {100.0 * bound:.2g}% in {scene!r}")
        return min(held, key=lambda trial: trial.cost)

    def _outcome(self, settings: Settings) -> RunOutcome:
        if settings not in self.outcomes:
            self.outcomes[settings] = self._run(settings)
        return self.outcomes[settings]

    def _motion(self, settings: Settings) -> MeasuredMotion:
        motion = motion_of(self._outcome(settings))
        if motion is None:
            raise SoftBodyError(
                f"a trial of {self._case.scene!r} did not end well: "
                f"{self.outcomes[settings].status}"
            )
        return motion

    def _apart(self, first: Settings, second: Settings) -> float:
        return self._ruler.distance(self._motion(first), self._motion(second))

    def _on(self, number: int, elements: NamedElements) -> Settings:
        cells, level = self._meshes[number]
        return replace(self._case.default, cells=cells, level=level, elements=elements)

    def _spaces(self, enough: float) -> dict[Settings, float]:
        """Errors of meshes and elements, from coarse on until one errs by no more than enough.

        What the finer mesh still errs by follows from the change at second order.
        """
        found: dict[Settings, float] = {}
        last = len(self._meshes) - 1
        for number in range(last):
            here, finer = (self._on(k, "smoothed") for k in (number, number + 1))
            ratio = self._outcome(finer).tets / max(1, self._outcome(here).tets)
            change = self._apart(here, finer)
            beyond = change / (ratio ** (SECOND_ORDER / 3.0) - 1.0)
            found[here] = change + beyond
            for base in (self._on(number, "linear"), self._on(number + 1, "linear")):
                if base.mesh == here.mesh or number + 1 == last:
                    found[base] = self._apart(base, finer) + beyond
            if found[here] <= enough:
                break
            if number + 1 == last:
                found[finer] = beyond
        return found

    def _limit(self, base: Settings, enough: float) -> tuple[MeasuredMotion, float]:
        """The motion at dt to 0, and the change of it by the last halving."""
        steps = [one for one in TIME_STEPS if one <= 1.01 * base.time_step][: HALVINGS + 1]
        motions = [self._motion(replace(base, time_step=one)) for one in steps[:2]]
        limit, change = extrapolated(motions[1], motions[0]), float("inf")
        for step in steps[2:]:
            motions.append(self._motion(replace(base, time_step=step)))
            last, limit = limit, extrapolated(motions[-1], motions[-2])
            change = self._ruler.distance(last, limit)
            if change <= enough:
                break
        return limit, change

    def _corrected(
        self, base: Settings, motion: MeasuredMotion, change: float
    ) -> tuple[MeasuredMotion, float]:
        """The limit with what a refinement of its mesh changes, and the doubt about that.

        The refined mesh is run at two time steps. It still errs by what follows at second order,
        and what these steps do there and on the base differs from mesh to mesh.
        """
        steps = [one for one in TIME_STEPS if one <= 1.01 * base.time_step][:2]
        finer = replace(base, level=base.level + 1)
        here, there = (
            [self._motion(replace(one, time_step=step)) for step in steps] for one in (base, finer)
        )
        coarse, fine = (extrapolated(pair[1], pair[0]) for pair in (here, there))
        distance = self._ruler.distance
        beyond = distance(fine, coarse) / (8.0 ** (SECOND_ORDER / 3.0) - 1.0)
        mixed = distance(corrected(there[1], here[0], here[1]), there[0])
        return corrected(motion, fine, coarse), beyond + change + mixed

    def _by_cost(self, bases: list[Settings]) -> list[tuple[Settings, float]]:
        """Meshes and elements at every time step with what they should cost, the cheapest first."""
        # between halvings a third less, where that fills a frame of 1/30 s
        steps = self._case.time_steps
        steps = (*steps, *(2.0 / 3.0 * step for step in steps if step < 0.75 * TIME_STEPS[0]))
        points = [replace(base, time_step=step) for base in bases for step in steps]
        own = {(base.mesh, base.elements): base for base in bases}

        def guess(point: Settings) -> float:
            base = own[point.mesh, point.elements]
            return self._outcome(base).cost * base.time_step / point.time_step

        return sorted(((point, guess(point)) for point in points), key=lambda one: one[1])
