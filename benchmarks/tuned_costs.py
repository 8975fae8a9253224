"""What the tuned settings of motions save, measured in turn with what ships.

    python -m benchmarks.tuned_costs --rounds 3 --write docs/frontier.md

Each round runs the first seconds of every motion as it ships and with its tuned settings, one after
the other, on one thread. Medians of the rounds are shown, in ms of CPU time per simulated second;
1000 of them are real time.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from statistics import median

from benchmarks.beam.arguments import count
from benchmarks.charts.command import percent, plain
from benchmarks.marked_page import put, rows
from benchmarks.tuned_motions import stored
from warp_softbody.accuracy.analysis.design import job
from warp_softbody.accuracy.analysis.tuning import Tuned
from warp_softbody.accuracy.cases.table import CASES
from warp_softbody.accuracy.runs.job import Job
from warp_softbody.accuracy.runs.outcome import RunOutcome
from warp_softbody.accuracy.runs.running import run_job

BEGIN = "<!-- tuned costs: written by python -m benchmarks.tuned_costs, from here -->"
END = "<!-- tuned costs: to here -->"
SECONDS = 2.5
"""Simulated at most: the crouch of a jump, a cycle of a crawl, eight swings of a walk."""

Run = Callable[[Job], RunOutcome]


def costs(tuned: Tuned, rounds: int, run: Run = run_job) -> tuple[float, float]:
    """Medians as it ships and tuned, ms of CPU time per simulated second."""
    case = replace(CASES[tuned.scene], seconds=min(SECONDS, CASES[tuned.scene].seconds))
    pairs = [
        tuple(run(job(case, settings)).cost for settings in (case.default, tuned.settings))
        for _ in range(rounds)
    ]
    shipped, other = (median(each) for each in zip(*pairs, strict=True))
    return shipped, other


def line(tuned: Tuned, shipped: float, other: float) -> list[str]:
    """A row of the table."""
    return [
        f"`{tuned.scene}`",
        tuned.settings.differences(CASES[tuned.scene].default),
        f"{percent(tuned.error)}, {percent(tuned.uncertainty)}",
        plain(shipped, 3),
        plain(other, 3),
        f"{plain(1000.0 / shipped, 2)}, {plain(1000.0 / other, 2)}",
        f"{shipped / other:.1f}",
    ]


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, print the table, write it into the page."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.tuned_costs",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--rounds", type=count, default=3, help="medians of so many (3)")
    parser.add_argument("--write", type=Path, help="page between whose marks the table goes")
    args = parser.parse_args(arguments)
    head = ["scene", "settings, as shipped but", "error, and reference", "shipped, ms", "tuned, ms"]
    table = [[*head, "faster than real time, shipped and tuned", "gain"]]
    for tuned in stored().values():
        table.append(line(tuned, *costs(tuned, args.rounds)))
        print("  ".join(table[-1]), flush=True)
    if args.write is not None:
        put(args.write, BEGIN, END, rows(table))


if __name__ == "__main__":
    main()
