"""Many runs: those that a journal lacks are made, the cheap ones first."""

from __future__ import annotations

import tempfile
import time
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
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
    clock: Callable[[], float] = time.monotonic,
) -> None:
    """Make the runs that a journal lacks in so many processes.

    Args:
        journal: is added to after each run, so that a stopped sweep loses the runs in hand alone.
        cells: the runs.
        count: of processes.
        seen: called with each outcome, how many are done, and of how many.
        limit: s for each run.
        budget: s after which no more runs are begun.
        clock: s, by which that is told.

    Raises:
        SoftBodyError: a process was ended from outside.
    """
    begun = clock()
    missing = sorted(
        (cell for cell in cells if journal.of(cell, limit) is None), key=lambda cell: cell.cost
    )
    if not missing or budget == 0.0:
        return
    with tempfile.TemporaryDirectory() as folder, workers(count) as executor:
        meshes = Path(folder)
        for edges in sorted({cell.variation.edges for cell in missing} - {1.0}):
            make_meshes(meshes, edges)
        queue, running, done = deque(missing), dict[Future[VariationOutcome], Cell](), 0
        while queue or running:
            late = budget is not None and clock() - begun > budget
            while queue and len(running) < count and not late:
                cell = queue.popleft()
                running[executor.submit(run, cell, meshes, limit)] = cell
            if not running:
                return
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                outcome, done = _result(future), done + 1
                journal.add(running.pop(future), outcome)
                seen(outcome, done, len(missing))


def _result(future: Future[VariationOutcome]) -> VariationOutcome:
    try:
        return future.result()
    except BrokenProcessPool as error:
        raise SoftBodyError("a process that made runs was ended from outside") from error
