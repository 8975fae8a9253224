"""Programs that take their turns at a work, each in a process of its own."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType

from benchmarks.speed.works import OURS, Work

ONE_THREAD = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS")
HERE = Path(__file__).resolve().parents[2]


class WorkerFailed(Exception):
    """A program did not do its work; the message is what it wrote last."""


class TimedProcess:
    """A process with a work in it."""

    def __init__(self, work: str, program: str, root: Path | None = None) -> None:
        """Start the process; ``root`` is another checkout of this program."""
        command = [sys.executable, "-m", "benchmarks.speed.worker", work, program]
        self._process = subprocess.Popen(
            command if root is None else [*command, str(root.resolve())],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            cwd=HERE,
            env=os.environ | dict.fromkeys(ONE_THREAD, "1"),
        )

    def __enter__(self) -> TimedProcess:
        """Give itself."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """End the process."""
        self._process.kill()
        self._process.communicate()

    def ready(self) -> None:
        """Wait until the work is made."""
        self._answer()

    def spent(self, steps: int) -> float:
        """CPU time, s, of so many steps more."""
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(f"{steps}\n")
            self._process.stdin.flush()
        except BrokenPipeError as error:
            raise WorkerFailed(self._last_words()) from error
        return float(self._answer())

    def _answer(self) -> str:
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            raise WorkerFailed(self._last_words())
        return line

    def _last_words(self) -> str:
        _, written = self._process.communicate()
        return written.strip().rpartition("\n")[2] or f"exit code {self._process.returncode}"


def time_in_turn(
    work: Work,
    programs: dict[str, Path | None],
    show: Callable[[str], None],
) -> dict[str, float]:
    """Times by program in the work's unit; those that failed are left out, with a line about each.

    Args:
        work: what is done.
        programs: names of programs, or of checkouts of this one, with the roots of the latter.
        show: tells how far it is.
    """
    with ExitStack() as stack:
        entered: dict[str, TimedProcess] = {}
        for name, root in programs.items():
            program = name if root is None else OURS
            show(f"{work.name}: {name} begins")
            entrant = stack.enter_context(TimedProcess(work.name, program, root))
            try:
                entrant.ready()
                entrant.spent(work.skipped)
            except WorkerFailed as error:
                show("")
                print(f"{work.name}: {name} failed: {error}", file=sys.stderr)
                continue
            entered[name] = entrant
        seconds = dict.fromkeys(entered, 0.0)
        for begun in range(0, work.steps, work.turn):
            show(f"{work.name}: step {begun} of {work.steps}")
            for name, entrant in entered.items():
                seconds[name] += entrant.spent(min(work.turn, work.steps - begun))
    return {name: work.scale * total / work.steps for name, total in seconds.items()}
