"""Search the gains of a scene by CMA-ES around the shipped ones.

    python -m benchmarks.gains jump-i --draws 100 --seed 1 --out jump-i.csv

A run is measured at 60 frames a second. A draw's cost is the sum of what is missing to its goals,
each with a margin, as a share of the goal; a run in which the body falls costs one for every goal
and stops. Draws that the file of ``--out`` holds already are not run again, so that a search that
was stopped goes on. How the found gains fare elsewhere: `benchmarks.robustness`.
"""

from __future__ import annotations

import argparse
import csv
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.beam.arguments import count
from benchmarks.gains.cases import CASES, GainCase, MeasureBound
from benchmarks.gains.evolution import minimise
from benchmarks.gains.measures import Record
from warp_softbody import scenes
from warp_softbody.arrays import FloatArray
from warp_softbody.atomic_files import replacing
from warp_softbody.controllers.control_options import Method
from warp_softbody.errors import InputError, NotFiniteError, SoftBodyError
from warp_softbody.run.simulation import Simulation

FPS = 60.0


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
    known: Sequence[Draw] = (),
) -> Iterator[Draw]:
    """The draws of a search in their order; the first is the shipped gains.

    Args:
        case: what is searched.
        draws: how many.
        seed: of the search.
        seconds: length of a run; None for the scene's.
        margin: asked of every goal.
        known: draws of an earlier search with the same seed, which are not run again.

    Raises:
        InputError: a known draw is not of this search.
    """
    done = {draw.number: draw for draw in known}

    def drawn(number: int, shares: FloatArray) -> float:
        gains = _gains(case, shares) if number else case.shipped()
        measures = run(case, gains, seconds=seconds)
        total = cost(case, measures, margin)
        done[number] = Draw(number=number, cost=total, gains=gains, measures=measures)
        return total

    costs = {draw.number: cost(case, draw.measures, margin) for draw in known}
    start = _shares(case, case.shipped())
    for number, shares, _ in minimise(drawn, start, draws=draws, seed=seed, known=costs):
        gains = _gains(case, shares) if number else case.shipped()
        if not np.allclose(list(done[number].gains.values()), list(gains.values()), rtol=1e-9):
            raise InputError(f"draw {number} of the file is of another search of {case.scene}")
        yield done[number]


def _gains(case: GainCase, shares: FloatArray) -> dict[str, float]:
    """Gains by where in its range each is, from 0 to 1."""
    found = {}
    for name, share in zip(case.ranges, shares.tolist(), strict=True):
        low, high = case.ranges[name].low, case.ranges[name].high
        if case.ranges[name].log:
            found[name] = low * (high / low) ** share
        else:
            found[name] = low + (high - low) * share
    return found


def _shares(case: GainCase, gains: Mapping[str, float]) -> FloatArray:
    """Where in its range each gain is, the inverse of `_gains`."""
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


def read(path: Path, case: GainCase) -> list[Draw]:
    """Draws of a file of `write`; [] where there is none.

    Raises:
        InputError: the file is not of this scene's gains.
    """
    if not path.exists():
        return []
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    try:
        return [_draw(case, {name: float(value) for name, value in row.items()}) for row in rows]
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"{path} does not hold draws of {case.scene}: {error}") from error


def _draw(case: GainCase, row: dict[str, float]) -> Draw:
    number, total = int(row.pop("number")), row.pop("cost")
    gains = {name: row.pop(name) for name in case.ranges}
    return Draw(number=number, cost=total, gains=gains, measures=row)


def main(arguments: Sequence[str] | None = None) -> int:
    """Search, keep all draws, print the best."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.gains", description=__doc__.splitlines()[0]
    )
    parser.add_argument("scene", choices=sorted(CASES))
    parser.add_argument("--draws", type=count, default=50)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--seconds", type=float, help="length of a run; default the scene's")
    parser.add_argument("--margin", type=float, default=0.1, help="asked of every goal (0.1)")
    parser.add_argument("--best", type=count, default=5, help="draws whose gains are printed")
    parser.add_argument("--out", type=Path, help="CSV file of all draws, by which a search goes on")
    args = parser.parse_args(arguments)
    case, draws = CASES[args.scene], []
    try:
        known = read(args.out, case) if args.out else []
        how = {"draws": args.draws, "seed": args.seed, "seconds": args.seconds}
        for draw in search(case, **how, margin=args.margin, known=known):
            draws.append(draw)
            print(f"{draw.number:4d}  {draw.cost:8.4f}  {_line(case, draw.measures)}", flush=True)
            if args.out and len(draws) > len(known):
                write(args.out, draws)
    except SoftBodyError as error:
        parser.error(str(error))
    for draw in sorted(draws, key=lambda draw: draw.cost)[: args.best]:
        print(f"\ndraw {draw.number}, cost {draw.cost:.4f}: {_line(case, draw.measures)}")
        print("  ".join(f"{name}={value:.4g}" for name, value in draw.gains.items()))
    return 0
