"""Steps of shipped motions: how many end at the best modes that any search finds, and how soon."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.qpcc.sequences import problems_of
from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.compiled.contact_solver import CompiledSearch
from warp_softbody.controllers.control_options import ControlOptions
from warp_softbody.controllers.perturbation_schedule import PerturbationSchedule
from warp_softbody.controllers.qpcc import ContactQPCC, enumerate_qpcc
from warp_softbody.controllers.qpcc.contact.complementarity_form import to_general

MOTIONS = ("balance-i", "jump-i", "crawl-i", "walk-x")
SECONDS = 3.0

SHIPPED = ControlOptions()
CHEAP = ControlOptions(
    max_qps=16, kicks=2, kick_patience=1, kick_reach=1.0, carried=0, calm_objective=0.01
)
THOROUGH = ControlOptions(max_qps=60, kicks=40, kick_reach=1e6, kick_pause=0)
LONG = replace(THOROUGH, max_qps=127, kicks=200, kick_patience=60)
SETTINGS = {"cheap": CHEAP, "as shipped": SHIPPED, "thorough": THOROUGH, "long": LONG}

SAME = 1e-6
"""Relative difference up to which two objectives are the same."""

STICK = 1


@dataclass(frozen=True, kw_only=True)
class RecordedOutcome:
    """One setting on the steps of one motion.

    Attributes:
        values: (steps,), objectives.
        qps: mean of a step.
        milliseconds: mean CPU time of a solve.
    """

    values: FloatArray
    qps: float
    milliseconds: float

    def at_best(self, best: FloatArray) -> float:
        """Share of the steps that end at the best value."""
        return float(np.mean(self.excess(best) <= SAME))

    def excess(self, best: FloatArray) -> FloatArray:
        """(steps,), how far above the best value, as a share of it."""
        return np.asarray((self.values - best) / np.maximum(np.abs(best), 1e-9))


def follow(steps: list[ContactQPCC], options: ControlOptions) -> RecordedOutcome:
    """Solve the steps one after the other, each from what the one before it hands on."""
    search, rule = CompiledSearch(), PerturbationSchedule(options)
    minima: tuple[tuple[int, ...], ...] = ()
    values, qps, spent = [], 0, 0.0
    for problem in steps:
        count = problem.contact_count
        if not minima or len(minima[0]) != count:
            minima = ((STICK,) * count,)
        start, others = minima[0], minima[1:]
        begun = time.process_time()
        result = search.solve(
            problem,
            start=start,
            others=others,
            fallback_controls=np.zeros(problem.control_count),
            touching=np.ones(count, dtype=bool),
            options=rule.options(),
        )
        spent += time.process_time() - begun
        rule.note(start, result, usable=True)
        minima = (result.modes, *result.others[: options.carried])
        values.append(result.objective)
        qps += result.qp_count
    return RecordedOutcome(
        values=np.array(values),
        qps=qps / len(steps),
        milliseconds=1e3 * spent / len(steps),
    )


def certified(steps: list[ContactQPCC], seconds: float) -> FloatArray:
    """(steps,) objectives of branch and bound where it ends within a time, infinity elsewhere."""
    values = np.full(len(steps), math.inf)
    for number, problem in enumerate(steps):
        result = enumerate_qpcc(to_general(problem), time_limit=seconds)
        if result.gap < SAME:
            values[number] = result.objective
    return values


def print_recorded(every: int = 15, seconds: float = 5.0) -> None:
    """A table of all settings; branch and bound judges every so manieth step."""
    print(f"{'motion':12}{'setting':12}{'QPs':>7}{'ms':>7}{'at the best':>13}{'mean excess':>13}")
    for name in MOTIONS:
        steps = problems_of(name, SECONDS)
        follow(steps[:20], SHIPPED)
        found = {title: follow(steps, options) for title, options in SETTINGS.items()}
        best = np.min([outcome.values for outcome in found.values()], axis=0)
        judged = certified(steps[::every], seconds)
        ended = np.isfinite(judged)
        missed = best[::every][ended] - judged[ended] > SAME * np.abs(judged[ended])
        best[::every] = np.minimum(best[::every], judged)
        for title, outcome in found.items():
            print(
                f"{name:12}{title:12}{outcome.qps:7.1f}{outcome.milliseconds:7.2f}"
                f"{outcome.at_best(best):13.1%}{outcome.excess(best).mean():13.3%}",
                flush=True,
            )
        print(
            f"{name:12}of {len(judged)} steps branch and bound ended {ended.sum()} within "
            f"{seconds:g} s, {missed.sum()} of them below all searches"
        )
