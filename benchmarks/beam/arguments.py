"""What the beam's benchmarks read from the command line and show on a terminal."""

from __future__ import annotations

import argparse
import sys

from benchmarks.beam.cantilever import CELLS


def progress(text: str) -> None:
    """Overwrite a line, on a terminal only."""
    if sys.stderr.isatty():
        print(f"\r\x1b[K{text}", end="", file=sys.stderr, flush=True)


def sizes(text: str) -> list[int]:
    """A reader of mesh sizes, separated by commas."""
    known = ", ".join(map(str, CELLS))
    for size in text.split(","):
        if not size.strip().isdecimal() or int(size) not in CELLS:
            raise argparse.ArgumentTypeError(f"no mesh of {size!r} tets; known: {known}")
    return [int(size) for size in text.split(",")]


def count(text: str) -> int:
    """A reader of whole numbers above zero."""
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"must be a whole number above 0, got {text!r}")
    return int(text)
