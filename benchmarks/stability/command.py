"""Extreme cases: what other programs do and what ours does, as a table.

Every case runs the real thing: a body is put into an extreme state or given an extreme material or
time step, stepped, and measured by formulas of the suite's own. docs/stability.md says what the
columns mean.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from benchmarks.stability.mujoco_cases import missing
from benchmarks.stability.outcomes import StabilityOutcome, everything, examine_all
from benchmarks.stability.table import text, write
from warp_softbody.run.warp_session import warp_engine


def _names(argument: str) -> list[str]:
    names = [name.strip() for name in argument.split(",")]
    known = [row.name for row in everything()]
    for name in names:
        if name not in known:
            raise argparse.ArgumentTypeError(f"no case {name!r}; known: {', '.join(known)}")
    return names


def _progress(line: str) -> None:
    """Overwrite a line, on a terminal only."""
    if sys.stderr.isatty():
        print(f"\r\x1b[K{line}", end="", file=sys.stderr, flush=True)


def main(arguments: list[str] | None = None) -> None:
    """Print the outcomes, or write the tables into a page."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.stability", description=__doc__)
    parser.add_argument("--cases", type=_names, help="names, separated by commas; else all")
    parser.add_argument("--write", type=Path, help="page between whose marks the tables go")
    parser.add_argument("--peers", action="store_true", help="also run MuJoCo")
    parser.add_argument("--json", action="store_true", help="print a list of objects")
    options = parser.parse_args(arguments)
    if options.write is not None and options.cases is not None:
        parser.error("--write wants all cases, not --cases")
    if options.write is not None and not options.write.is_file():
        parser.error(f"--write: there is no page {str(options.write)!r}")
    if options.peers and (problem := missing()):
        parser.error(problem)
    outcomes: list[StabilityOutcome] = []
    with warp_engine("cpu", on_compile=lambda: None):
        outcomes += examine_all(options.cases, _progress, peers=options.peers)
    _progress("")
    if options.write is not None:
        write(options.write, outcomes)
    if options.json:
        print(json.dumps([outcome.to_dict() for outcome in outcomes]))
    else:
        print(text(outcomes))
