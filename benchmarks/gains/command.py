"""Search the gains of a scene by seeded random draws, the later ones around the best so far.

    python -m benchmarks.gains jump-i --draws 100 --seed 1 --out jump-i.csv

A run is measured at 60 frames a second. A draw's cost is the sum of what is missing to its goals,
each with a margin, as a share of the goal; a run in which the body falls costs one for every goal
and stops. How the found gains fare elsewhere: `benchmarks.robustness`.
"""

from __future__ import annotations

import argparse
import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from benchmarks.beam.arguments import count
from benchmarks.gains.cases import CASES, GainCase, MeasureBound
from benchmarks.gains.measures import Record
from warp_softbody import scenes
from warp_softbody.atomic_files import replacing
from warp_softbody.controllers.control_options import Method
from warp_softbody.errors import NotFiniteError
from warp_softbody.run.simulation import Simulation

FPS = 60.0
SPREAD = 0.12
"""Standard deviation, as a share of the range, of draws around one of the best."""

BEST = 3
"""So many of the best are drawn around."""


@dataclass(frozen=True, kw_only=True)
class Draw:
    """Gains and what came of them."""

    number: int
    cost: float
    gains: Mapping[str, float]
    measures: Mapping[str, float]


def run(
    case: GainCase,
    gains: Mapping[str, float],
    *,
    settings: Mapping[str, float] | None = None,
    seconds: float | None = None,
    time_step: float | None = None,
    method: Method = "qpcc",
) -> dict[str, float]:
    """Measures of one run; ``fallen`` is 1 where it was broken off."""
    plan = scenes.make(case.scene, {**case.settings, **(settings or {})})
    scene, controller = case.build(gains, settings or {})
    step = time_step or plan.time_step
    simulation = Simulation(scene, controller, time_step=step, fps=FPS, method=method)
    record = Record.of(simulation.model, FPS)
    fallen = False
    try:
        for frame in simulation.run(seconds or plan.seconds):
            record.add(frame)
            fallen = case.stands and record.fallen
            if fallen:
                break
    except NotFiniteError:
        fallen = True
    return {"fallen": float(fallen), **record.measures()}


def missing(goal: MeasureBound, measures: Mapping[str, float], margin: float) -> float:
    """What is missing to a goal with a margin, as a share of it, at most 1; 0 where it is met."""
    value = measures[goal.measure]
    wanted = goal.bound * (1.0 + margin if goal.at_least else 1.0 - margin)
    short = wanted - value if goal.at_least else value - wanted
    return float(np.clip(short / abs(wanted), 0.0, 1.0))


def cost(case: GainCase, measures: Mapping[str, float], margin: float) -> float:
    """Sum of what is missing, worst where the body fell; of equals, the smoothest is best."""
    smooth = 1e-3 * measures["sign_changes"]
    if measures["fallen"]:
        return len(case.goals) - 1e-3 * measures["seconds"] + smooth
    return sum(goal.weight * missing(goal, measures, margin) for goal in case.goals) + smooth


def search(
    case: GainCase,
    *,
    draws: int,
    seed: int,
    seconds: float | None = None,
    margin: float = 0.1,
    around: float = 0.5,
) -> list[Draw]:
    """All draws, best first; the first is the shipped gains."""
    random = np.random.default_rng(seed)
    done: list[Draw] = []
    for number in range(draws):
        shares = _shares(case, random, done if number >= (1.0 - around) * draws else [])
        gains = _gains(case, shares) if number else case.shipped()
        measures = run(case, gains, seconds=seconds)
        total = cost(case, measures, margin)
        done.append(Draw(number=number, cost=total, gains=gains, measures=measures))
        print(f"{number:4d}  {total:8.4f}  {_line(case, measures)}", flush=True)
    return sorted(done, key=lambda draw: draw.cost)


def _shares(case: GainCase, random: np.random.Generator, done: list[Draw]) -> dict[str, float]:
    """Where in its range each gain is, from 0 to 1."""
    drawn = random.random(len(case.ranges))
    if done:
        best = sorted(done, key=lambda draw: draw.cost)[:BEST]
        middle = _inverse(case, best[random.integers(len(best))].gains)
        drawn = np.clip(middle + SPREAD * random.standard_normal(len(middle)), 0.0, 1.0)
    return dict(zip(case.ranges, drawn.tolist(), strict=True))


def _gains(case: GainCase, shares: Mapping[str, float]) -> dict[str, float]:
    found = {}
    for name, share in shares.items():
        low, high = case.ranges[name].low, case.ranges[name].high
        if case.ranges[name].log:
            found[name] = low * (high / low) ** share
        else:
            found[name] = low + (high - low) * share
    return found


def _inverse(case: GainCase, gains: Mapping[str, float]) -> npt.NDArray[np.float64]:
    shares = []
    for name, bounds in case.ranges.items():
        value = np.array([gains[name], bounds.low, bounds.high])
        at, low, high = np.log(np.maximum(value, 1e-12)) if bounds.log else value
        shares.append((at - low) / (high - low))
    return np.asarray(np.clip(np.array(shares), 0.0, 1.0))


def _line(case: GainCase, measures: Mapping[str, float]) -> str:
    if measures["fallen"]:
        return f"fallen after {measures['seconds']:.2f} s"
    return "  ".join(f"{goal.measure} {measures[goal.measure]:.3g}" for goal in case.goals)


def write(path: Path, draws: Sequence[Draw]) -> None:
    """A line a draw: number, cost, gains, measures."""
    rows = [
        {"number": draw.number, "cost": draw.cost, **draw.gains, **draw.measures} for draw in draws
    ]
    with replacing(path) as new, new.open("w", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)


def main(arguments: Sequence[str] | None = None) -> int:
    """Search, print the best, write all."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.gains", description=__doc__.splitlines()[0]
    )
    parser.add_argument("scene", choices=sorted(CASES))
    parser.add_argument("--draws", type=count, default=50)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--seconds", type=float, help="length of a run; default the scene's")
    parser.add_argument("--margin", type=float, default=0.1, help="asked of every goal (0.1)")
    parser.add_argument("--around", type=float, default=0.5, help="share around the best (0.5)")
    parser.add_argument("--best", type=count, default=5, help="draws whose gains are printed")
    parser.add_argument("--out", type=Path, help="CSV file of all draws")
    args = parser.parse_args(arguments)
    case = CASES[args.scene]
    draws = search(
        case,
        draws=args.draws,
        seed=args.seed,
        seconds=args.seconds,
        margin=args.margin,
        around=args.around,
    )
    if args.out:
        write(args.out, draws)
    for draw in draws[: args.best]:
        print(f"\ndraw {draw.number}, cost {draw.cost:.4f}: {_line(case, draw.measures)}")
        print("  ".join(f"{name}={value:.4g}" for name, value in draw.gains.items()))
    return 0
