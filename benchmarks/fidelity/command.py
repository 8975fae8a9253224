"""Whether every motion survives a better, a coarser or another computation of its physics.

    python -m benchmarks.fidelity                                    # all scenes, all variants
    python -m benchmarks.fidelity --scenes slide-f --variants "as shipped" "dt / 2"
    python -m benchmarks.fidelity --limit 300 --budget 3600 --write docs/robustness.md
    python -m benchmarks.fidelity --scenes balance-i --set push=0.65
    python -m benchmarks.fidelity --budget 0 --json                  # what the journal has

Cheap runs are made first. Each is in the journal when it ends, so that a command that was stopped,
by Ctrl-C too, goes on where it was; runs of another state of the program are made anew.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from benchmarks.beam.arguments import count, progress
from benchmarks.fidelity.table import BEGIN, END, markdown, moved
from benchmarks.fidelity.variants import VARIANTS
from benchmarks.marked_page import put
from benchmarks.motions.criteria import CRITERIA
from benchmarks.robustness.outcomes import Cell, OutcomeJournal, VariationOutcome
from benchmarks.robustness.sweep import fill
from benchmarks.robustness.variation import Variation
from warp_softbody.errors import SoftBodyError

Show = Callable[[VariationOutcome, int, int], None]
JOURNAL = Path("out/fidelity.jsonl")
STOPPED = 130
"""Exit status after Ctrl-C, as of a command that the signal ended."""


def main(arguments: Sequence[str] | None = None, show: Show | None = None) -> int:
    """Make the runs that the journal lacks; print the table, write it into the page.

    ``show`` is called after every run instead of the progress on a terminal.
    """
    args = _parser().parse_args(arguments)
    cells = [
        Cell(scene=scene, variation=_set(VARIANTS[name], args.set), seconds=args.seconds)
        for scene in args.scenes
        for name in args.variants
    ]
    args.journal.parent.mkdir(parents=True, exist_ok=True)
    journal = OutcomeJournal(args.journal)
    try:
        fill(journal, cells, args.workers, show or _show, limit=args.limit, budget=args.budget)
    except KeyboardInterrupt:
        print(f"\nstopped; the finished runs are in {args.journal}", file=sys.stderr)
        return STOPPED
    except SoftBodyError as error:
        print(f"\n{error}", file=sys.stderr)
        return 2
    progress("")
    found = {cell.name: outcome for cell in cells if (outcome := journal.of(cell)) is not None}
    table = markdown(found, args.scenes, args.variants)
    print(_json(found, args.scenes) if args.json else table)
    if args.write is not None:
        put(args.write, BEGIN, END, table)
    return 0


def _set(variant: Variation, given: Sequence[tuple[str, float]]) -> Variation:
    """The variant with settings of the scene."""
    return replace(variant, settings={**variant.settings, **dict(given)})


def _setting(text: str) -> tuple[str, float]:
    """A setting and its number."""
    name, _, value = text.partition("=")
    try:
        return name, float(value)
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"expected NAME=VALUE with a number, got {text!r}"
        ) from None


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.fidelity",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    known, names = list(CRITERIA), list(VARIANTS)
    parser.add_argument("--scenes", nargs="+", choices=known, default=known, metavar="SCENE")
    parser.add_argument("--variants", nargs="+", choices=names, default=names, metavar="VARIANT")
    parser.add_argument(
        "--set",
        type=_setting,
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="a setting of the scenes",
    )
    parser.add_argument("--workers", type=count, default=1, help="processes (1)")
    parser.add_argument("--seconds", type=float, help="length of a run; default the scene's")
    parser.add_argument("--limit", type=float, help="s after which a run is broken off")
    parser.add_argument("--budget", type=float, help="s after which no more runs are begun")
    parser.add_argument("--journal", type=Path, default=JOURNAL, help=f"finished runs ({JOURNAL})")
    parser.add_argument("--write", type=Path, help="page between whose marks the table goes")
    parser.add_argument("--json", action="store_true", help="print the cells, not the table")
    return parser


def _show(outcome: VariationOutcome, done: int, total: int) -> None:
    """On a terminal, how far it is."""
    progress(f"{done} of {total}: {outcome.scene}, {outcome.variation}: {outcome}")


def _json(outcomes: Mapping[tuple[str, str], VariationOutcome], scenes: Sequence[str]) -> str:
    """All cells, and how far each scene's number moves; null for what is not finite."""
    cells: list[dict[str, Any]] = [
        {
            **asdict(outcome),
            "values": {name: _finite(value) for name, value in outcome.values.items()},
            "holds": outcome.holds,
        }
        for outcome in outcomes.values()
    ]
    known = {scene: moved(outcomes, scene) for scene in scenes}
    shares = {scene: _finite(found[0]) for scene, found in known.items() if found is not None}
    return json.dumps({"cells": cells, "moves_by": shares}, indent=1)


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
