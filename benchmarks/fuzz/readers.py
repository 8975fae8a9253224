"""Mutated mesh and surface files, and what the readers make of them.

`python -m benchmarks.fuzz.readers --files 10000 --seed 1` writes one small body in every format,
mutates it and reads it back. A file is to be refused in a sentence, or taken with as many points
and cells as the body has, or taken with a warning, within five seconds. Whatever else happens is
counted and, with `--keep FOLDER`, kept.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.fuzz.formats import KINDS, Kind, write_body
from benchmarks.fuzz.mutations import mutated
from benchmarks.tables import as_text
from warp_softbody.body.mesh import TetMesh
from warp_softbody.body.meshing import load_surface
from warp_softbody.errors import SoftBodyError

Reader = Callable[[Kind, Path], tuple[int, int]]
"""Points and cells that are found in a file of a format."""

SLOW = 5.0
"""s, after which a read counts as hung."""

GOOD = ("refused", "whole", "told")
"""Outcomes that are right: a sentence, the whole body, or another one with a warning."""


@dataclass(frozen=True, kw_only=True)
class ReadingOutcome:
    """What became of one mutated file.

    Attributes:
        kind: name of the format.
        number: of the file, which with the seed makes it again.
        verdict: one of `GOOD`, or "traceback", "slow" or "changed".
        detail: the error or the sizes.
    """

    kind: str
    number: int
    verdict: str
    detail: str


def sizes_of(kind: Kind, path: Path) -> tuple[int, int]:
    """Points and cells that the readers find in a file of a format."""
    if kind.surface:
        surface = load_surface(path)
        return len(surface.points), len(surface.faces)
    mesh = TetMesh.read(path)
    return len(mesh.points), len(mesh.tets)


def fuzz(
    files: int, seed: int, folder: Path, keep: Path | None = None, read: Reader = sizes_of
) -> Iterator[ReadingOutcome]:
    """Outcomes of mutated files of every format in turn.

    Args:
        files: how many.
        seed: of the mutations; the same seed makes the same files.
        folder: where they are written, one after the other.
        keep: where those with a wrong outcome stay, each in a folder of its own.
        read: what is tried: points and cells that it finds in a file.
    """
    bodies = {}
    for kind in KINDS:
        bodies[kind.name] = write_body(kind, folder / kind.name)
    for number in range(files):
        kind = KINDS[number % len(KINDS)]
        rng = np.random.default_rng([seed, number])
        texts = dict(bodies[kind.name])
        chosen = sorted(texts)[int(rng.integers(len(texts)))]
        texts[chosen] = mutated(texts[chosen], rng)
        for name, text in texts.items():
            (folder / kind.name / name).write_bytes(text)
        verdict, detail = _judged(kind, folder / kind.name / kind.file, read)
        if keep is not None and verdict not in GOOD:
            place = keep / f"{kind.name}-{seed}-{number}-{verdict}"
            place.mkdir(parents=True, exist_ok=True)
            for name, text in texts.items():
                (place / name).write_bytes(text)
        yield ReadingOutcome(kind=kind.name, number=number, verdict=verdict, detail=detail)


def _judged(kind: Kind, path: Path, read: Reader) -> tuple[str, str]:
    """Verdict on the file as it stands, and its detail."""
    start = time.monotonic()
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        try:
            sizes = read(kind, path)
            verdict = "whole" if sizes == kind.sizes else "told" if told else "changed"
            detail = f"{sizes[0]} points, {sizes[1]} cells"
        except SoftBodyError as error:
            verdict, detail = "refused", str(error)
        # What is looked for: anything that is no sentence.
        except Exception as error:
            verdict, detail = "traceback", f"{type(error).__name__}: {error}"
    if verdict == "refused" and "\n" in detail:
        verdict = "traceback"
    return ("slow" if time.monotonic() - start > SLOW else verdict), detail


def main(arguments: Sequence[str] | None = None, read: Reader = sizes_of) -> int:
    """Print counts by format and every wrong outcome of a reader; return 1 where there is one."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.fuzz.readers")
    parser.add_argument("--files", type=int, default=1000, help="how many files")
    parser.add_argument("--seed", type=int, default=1, help="of the mutations")
    parser.add_argument("--keep", type=Path, help="folder for files with a wrong outcome")
    options = parser.parse_args(arguments)
    counts: Counter[tuple[str, str]] = Counter()
    with tempfile.TemporaryDirectory(prefix="fuzz_readers_") as name:
        for outcome in fuzz(options.files, options.seed, Path(name), options.keep, read):
            counts[outcome.kind, outcome.verdict] += 1
            if outcome.verdict not in GOOD:
                print(f"{outcome.kind} {outcome.number}: {outcome.verdict}: {outcome.detail}")
    verdicts = (*GOOD, "traceback", "slow", "changed")
    rows = [[kind.name, *(counts[kind.name, verdict] for verdict in verdicts)] for kind in KINDS]
    totals = [sum(counts[kind.name, verdict] for kind in KINDS) for verdict in verdicts]
    rows.append(["all", *totals])
    print(as_text(("format", *verdicts), rows, left="format"))
    return int(sum(totals[len(GOOD) :]) > 0)


if __name__ == "__main__":
    sys.exit(main())
