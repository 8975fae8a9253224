"""Whether every motion holds where its gains were not searched.

    python -m benchmarks.robustness                          # all motions, all variations
    python -m benchmarks.robustness slide-f crawl-i --variations "as shipped" "half the step"
    python -m benchmarks.robustness --journal runs.jsonl --write docs/robustness.md

A run is printed as soon as it is done. With a journal, a command that was stopped goes on where it
was; delete the file after a change of the motions.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Sequence
from concurrent.futures import as_completed
from pathlib import Path

from benchmarks.beam.arguments import count
from benchmarks.motions.criteria import CRITERIA
from benchmarks.robustness.runs import VariationJournal, run
from benchmarks.robustness.table import markdown, write
from benchmarks.robustness.variations import VARIATIONS, make_meshes
from warp_softbody.accuracy.runs.workers import workers


def fill(
    journal: VariationJournal,
    scenes: Sequence[str],
    variations: Sequence[str],
    count: int,
    seconds: float | None = None,
) -> None:
    """Make the runs that a journal lacks, and print each."""
    wanted = [(scene, variation) for scene in scenes for variation in variations]
    missing = [pair for pair in wanted if pair not in journal.outcomes]
    with tempfile.TemporaryDirectory() as folder, workers(count) as executor:
        meshes = Path(folder)
        if any(VARIATIONS[variation].other_mesh for _, variation in missing):
            make_meshes(meshes)
        runs = [executor.submit(run, *pair, meshes, seconds) for pair in missing]
        for done in as_completed(runs):
            outcome = done.result()
            journal.add(outcome)
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
    journal = VariationJournal(args.journal)
    fill(journal, chosen, args.variations, args.workers, args.seconds)
    table = markdown(journal.outcomes, chosen, args.variations)
    print(table)
    if args.write is not None:
        write(args.write, table)
