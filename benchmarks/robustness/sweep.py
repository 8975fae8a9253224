"""Many runs: those that a journal lacks are made, the cheap ones first."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Sequence
from concurrent.futures import as_completed
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

from benchmarks.robustness.other_meshes import make_meshes
from benchmarks.robustness.outcomes import Cell, OutcomeJournal, VariationOutcome
from benchmarks.robustness.runs import run
from warp_softbody.accuracy.runs.workers import workers
from warp_softbody.errors import SoftBodyError

Seen = Callable[[VariationOutcome, int, int], None]


def fill(
    journal: OutcomeJournal,
    cells: Sequence[Cell],
    count: int,
    seen: Seen,
    *,
    limit: float | None = None,
    budget: float | None = None,
) -> None:
    """Make the runs that a journal lacks in so many processes.

    Args:
        journal: is added to after each run, so that a stopped sweep loses the runs in hand alone.
        cells: the runs.
        count: of processes.
        seen: called with each outcome, how many are done, and of how many.
        limit: s for each run.
        budget: s after which no more runs are begun.

    Raises:
        SoftBodyError: a process was ended from outside.
    """
    begun = time.monotonic()
    missing = sorted(
        (cell for cell in cells if journal.of(cell, limit) is None), key=lambda cell: cell.cost
    )
    if not missing or budget == 0.0:
        return
    with tempfile.TemporaryDirectory() as folder, workers(count) as executor:
        meshes = Path(folder)
        for edges in sorted({cell.variation.edges for cell in missing} - {1.0}):
            make_meshes(meshes, edges)
        running = {executor.submit(run, cell, meshes, limit): cell for cell in missing}
        try:
            for done, future in enumerate(as_completed(running), start=1):
                if future.cancelled():
                    continue
                outcome = future.result()
                journal.add(running[future], outcome)
                seen(outcome, done, len(missing))
                if budget is not None and time.monotonic() - begun > budget:
                    executor.shutdown(wait=False, cancel_futures=True)
        except BrokenProcessPool as error:
            raise SoftBodyError("a process that made runs was ended from outside") from error
