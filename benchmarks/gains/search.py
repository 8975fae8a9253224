"""The search: candidates of CMA-ES, each judged by the worst run of its family."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Executor, Future, as_completed
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from benchmarks.gains.cases import GainCase
from benchmarks.gains.journal import TrialJournal, key
from benchmarks.gains.trials import Trial, family_cost, make_trials, trial_cost
from benchmarks.robustness.variation import Variation
from warp_softbody.arrays import FloatArray
from warp_softbody.teaching.evolution import minimise

Gains = Mapping[str, float]

MOST_TOGETHER = 8
"""Runs of a batch: they share what is built of a scene, and are lost together with Ctrl-C."""


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
        """Run the draws member by member, those that are to be run in the same one as a batch."""
        while waiting := self._waiting(drawn):
            running: dict[Future[list[Trial]], tuple[list[Draw], Variation]] = {}
            for member, draws in waiting:
                for part in self._batches(draws):
                    what = (self.case.scene, [d.gains for d in part], member, self.seconds)
                    future = self.executor.submit(make_trials, *what, self.meshes)
                    running[future] = (part, member)
            for future in as_completed(running):
                part, member = running[future]
                for draw, trial in zip(part, future.result(), strict=True):
                    self.journal.add(self._key(draw, member), member.name, draw.gains, trial)
                    self._note(draw, member, trial)

    def _waiting(self, drawn: Sequence[Draw]) -> list[tuple[Variation, list[Draw]]]:
        """The next run that nobody knows yet of each draw that is not given up, by member."""
        found: dict[str, tuple[Variation, list[Draw]]] = {}
        for draw in drawn:
            while not draw.whole and draw.cost <= self._best:
                member = self._order[len(draw.costs)]
                known = self.journal.of(self._key(draw, member))
                if known is None:
                    found.setdefault(member.name, (member, []))[1].append(draw)
                    break
                self._note(draw, member, known)
        return list(found.values())

    def _batches(self, draws: list[Draw]) -> list[list[Draw]]:
        """The draws, shared out to all workers, few enough to lose little when stopped."""
        size = min(MOST_TOGETHER, -(-len(draws) // self.count))
        return [draws[first : first + size] for first in range(0, len(draws), size)]

    def _note(self, draw: Draw, member: Variation, trial: Trial) -> None:
        draw.trials[member.name] = trial
        draw.costs[member.name] = trial_cost(self.case, trial, self.margin)
        draw.cost = family_cost(list(draw.costs.values()), len(self._order))
        draw.whole = len(draw.costs) == len(self._order)

    def _key(self, draw: Draw, member: Variation) -> str:
        return key(self.case.scene, draw.gains, member, self.seconds)


def gains_of(case: GainCase, point: FloatArray) -> dict[str, float]:
    """Gains by where in its range each is, from 0 to 1."""
    pairs = zip(case.ranges.items(), point.tolist(), strict=True)
    return {name: bounds.number(share) for (name, bounds), share in pairs}


def shares(case: GainCase, gains: Gains) -> FloatArray:
    """Where in its range each gain is, the inverse of `gains_of`."""
    return np.array([bounds.share(gains[name]) for name, bounds in case.ranges.items()])
