"""Whether every motion holds where its gains were not searched.

    python -m benchmarks.robustness                          # all motions, all variations
    python -m benchmarks.robustness slide-f crawl-i --variations "as shipped" "half the step"
    python -m benchmarks.robustness --journal runs.jsonl --write docs/robustness.md

A run is printed as soon as it is done. With a journal, a command that was stopped goes on where it
was; runs of another state of the program are made anew.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from benchmarks.beam.arguments import count
from benchmarks.motions.criteria import CRITERIA
from benchmarks.robustness.outcomes import Cell, OutcomeJournal, VariationOutcome
from benchmarks.robustness.sweep import fill
from benchmarks.robustness.table import markdown, write
from benchmarks.robustness.variations import VARIATIONS


def show(outcome: VariationOutcome, _done: int, _total: int) -> None:
    """Print a run."""
    print(f"{outcome.scene:17} {outcome.variation:15} {outcome}", flush=True)


def main(arguments: Sequence[str] | None = None) -> None:
    """Make the runs, print the table, write it into the page."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.robustness", description=__doc__)
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help="names; default all")
    parser.add_argument("--variations", nargs="+", choices=VARIATIONS, default=list(VARIATIONS))
    parser.add_argument("--workers", type=count, default=1, help="processes (1)")
    parser.add_argument("--seconds", type=float, help="length of a run; default the scene's")
    parser.add_argument("--journal", type=Path, help="file of finished runs")
    parser.add_argument("--write", type=Path, help="page between whose marks the table goes")
    args = parser.parse_args(arguments)
    if unknown := [name for name in args.scenes if name not in CRITERIA]:
        parser.error(f"no motion {unknown[0]!r}; known: {', '.join(CRITERIA)}")
    chosen = args.scenes or list(CRITERIA)
    journal = OutcomeJournal(args.journal)
    cells = [
        Cell(scene=scene, variation=VARIATIONS[name], seconds=args.seconds)
        for scene in chosen
        for name in args.variations
    ]
    fill(journal, cells, args.workers, show)
    found = {cell.name: outcome for cell in cells if (outcome := journal.of(cell)) is not None}
    table = markdown(found, chosen, args.variations)
    print(table)
    if args.write is not None:
        write(args.write, table)
