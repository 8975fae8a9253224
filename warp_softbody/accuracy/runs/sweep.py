"""Many runs: those that the journal lacks are made, and written down as they finish."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor, as_completed
from concurrent.futures.process import BrokenProcessPool

from warp_softbody.accuracy.runs.job import Job
from warp_softbody.accuracy.runs.journal import RunJournal
from warp_softbody.accuracy.runs.outcome import RunOutcome
from warp_softbody.accuracy.runs.running import run_job
from warp_softbody.errors import SoftBodyError

Progress = Callable[[int, int], None]


def sweep(
    jobs: Sequence[Job],
    journal: RunJournal,
    executor: Executor,
    progress: Progress = lambda done, all_of_them: None,
) -> dict[str, RunOutcome]:
    """Outcomes of all jobs by key; ``progress`` is told how many are done, of how many."""
    missing = {job.key: job for job in jobs if job.key not in journal.outcomes}
    total = len({job.key for job in jobs})
    progress(total - len(missing), total)
    running = {executor.submit(run_job, job): job for job in missing.values()}
    try:
        for count, future in enumerate(as_completed(running), start=1):
            journal.add(running[future], future.result())
            progress(total - len(missing) + count, total)
    except BrokenProcessPool as error:
        raise SoftBodyError("a process that made runs was ended from outside") from error
    finally:
        for future in running:
            future.cancel()
    return {job.key: journal.outcomes[job.key] for job in jobs}
