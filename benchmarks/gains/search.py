"""The search: candidates of CMA-ES, each judged by the worst run of its family."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from benchmarks.gains.cases import GainCase
from benchmarks.gains.evolution import minimise
from benchmarks.gains.journal import TrialJournal, key
from benchmarks.gains.trials import Trial, family_cost, make_trial, trial_cost
from benchmarks.robustness.variation import Variation
from warp_softbody.arrays import FloatArray

Gains = Mapping[str, float]


@dataclass(kw_only=True)
class Draw:
    """Gains and what came of them.

    Attributes:
        number: in the search.
        gains: by name.
        trials: by the member's name, in the order in which they were run.
        costs: likewise.
        cost: of the family; where it was given up, of the members that were run.
        whole: whether all members were run.
    """

    number: int
    gains: Gains
    trials: dict[str, Trial] = field(default_factory=dict)
    costs: dict[str, float] = field(default_factory=dict)
    cost: float = 0.0
    whole: bool = False

    @property
    def worst(self) -> str:
        """Name of the member that costs most."""
        return max(self.costs, key=lambda name: self.costs[name])


@dataclass(kw_only=True)
class FamilySearch:
    """A search whose every step hangs on its seed and the costs alone.

    Attributes:
        case: what is searched.
        members: the family.
        journal: of runs, which are not made again.
        executor: where runs are made.
        count: how many at once.
        meshes: folder of the meshes of members that need others.
        seconds: length of a run; None for the scene's.
        margin: asked of every criterion.
    """

    case: GainCase
    members: Sequence[Variation]
    journal: TrialJournal
    executor: Executor
    count: int = 1
    meshes: Path = Path()
    seconds: float | None = None
    margin: float = 0.1
    _order: list[Variation] = field(init=False)
    _best: float = field(init=False, default=np.inf)
    _done: dict[int, Draw] = field(init=False, default_factory=dict)

    def __post_init__(self) -> None:
        """Begin with the members in the order given."""
        self._order = list(self.members)

    def run(self, draws: int, seed: int) -> Iterator[Draw]:
        """The draws in their order; the first is the shipped gains, in all members."""
        start = shares(self.case, self.case.shipped())
        for one in minimise(self._costs, start, draws=draws, seed=seed):
            yield self._done[one.number]

    def _costs(self, points: Mapping[int, FloatArray]) -> dict[int, float]:
        """Judge a generation; whoever is worse than the best before it is given up.

        Next time the members that were worst come first, the latest of them foremost.
        """
        drawn = [
            Draw(number=number, gains=self._gains(number, points[number])) for number in points
        ]
        self._judge(drawn)
        for draw in drawn:
            self._done[draw.number] = draw
            if draw.whole:
                self._best = min(self._best, draw.cost)
            self._order.sort(key=lambda member: member.name != draw.worst)
        return {draw.number: draw.cost for draw in drawn}

    def _gains(self, number: int, point: FloatArray) -> dict[str, float]:
        return gains_of(self.case, point) if number else self.case.shipped()

    def _judge(self, drawn: Sequence[Draw]) -> None:
        """Run the members of each draw one after the other, of several draws at once."""
        waiting, running = deque(drawn), dict[Future[Trial], tuple[Draw, Variation]]()
        while waiting or running:
            while waiting and len(running) < self.count:
                self._go_on(waiting.popleft(), running)
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                draw, member = running.pop(future)
                trial = future.result()
                self.journal.add(self._key(draw, member), member.name, draw.gains, trial)
                self._note(draw, member, trial)
                self._go_on(draw, running)

    def _go_on(self, draw: Draw, running: dict[Future[Trial], tuple[Draw, Variation]]) -> None:
        """Begin the next run of a draw that nobody knows yet, unless it is given up."""
        while not draw.whole and draw.cost <= self._best:
            member = self._order[len(draw.costs)]
            known = self.journal.of(self._key(draw, member))
            if known is None:
                what = (self.case.scene, draw.gains, member, self.seconds, self.meshes)
                running[self.executor.submit(make_trial, *what)] = (draw, member)
                return
            self._note(draw, member, known)

    def _note(self, draw: Draw, member: Variation, trial: Trial) -> None:
        draw.trials[member.name] = trial
        draw.costs[member.name] = trial_cost(self.case, trial, self.margin)
        draw.cost = family_cost(list(draw.costs.values()), len(self._order))
        draw.whole = len(draw.costs) == len(self._order)

    def _key(self, draw: Draw, member: Variation) -> str:
        return key(self.case.scene, draw.gains, member, self.seconds)


def gains_of(case: GainCase, point: FloatArray) -> dict[str, float]:
    """Gains by where in its range each is, from 0 to 1."""
    found = {}
    for name, share in zip(case.ranges, point.tolist(), strict=True):
        low, high = case.ranges[name].low, case.ranges[name].high
        if case.ranges[name].log:
            found[name] = low * (high / low) ** share
        else:
            found[name] = low + (high - low) * share
    return found


def shares(case: GainCase, gains: Gains) -> FloatArray:
    """Where in its range each gain is, the inverse of `gains_of`."""
    found = []
    for name, bounds in case.ranges.items():
        value = np.array([gains[name], bounds.low, bounds.high])
        at, low, high = np.log(np.maximum(value, 1e-12)) if bounds.log else value
        found.append((at - low) / (high - low))
    return np.asarray(np.clip(np.array(found), 0.0, 1.0))
