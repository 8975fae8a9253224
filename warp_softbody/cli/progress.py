"""A progress bar is shown on stderr where stderr is a terminal."""

from __future__ import annotations

import sys
from contextlib import suppress
from types import TracebackType
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    import rich.progress

Bar = TypeVar("Bar", bound="ProgressBar")


class ProgressBar:
    """Simulated seconds against those wanted; silent where nobody looks."""

    form = "{task.completed:.1f} of {task.total:g} s"
    """How far it has come, as it is told."""

    def __init__(self, name: str, seconds: float, *, quiet: bool) -> None:
        """Prepare a bar of ``seconds`` simulated seconds."""
        self._name = name
        self._seconds = seconds
        self._bar: rich.progress.Progress | None = None
        self._task: rich.progress.TaskID | None = None
        self._compiled = 0
        if not quiet and sys.stderr.isatty():
            self._bar = _bar(self.form)

    def __enter__(self: Bar) -> Bar:
        """Show the bar."""
        if self._bar is not None:
            with suppress(OSError):
                self._bar.start()
            self._task = self._bar.add_task("loading", total=self._seconds)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Take the bar away."""
        if self._bar is not None:
            # the terminal may have been closed
            with suppress(OSError):
                self._bar.stop()

    def compiling(self) -> None:
        """Say why nothing moves yet; called for each part that is compiled."""
        self._compiled += 1
        self._update(description=f"compiling kernels (first run only), {self._compiled} done")

    def reached(self, time: float) -> None:
        """Show the simulated time, s; at 0 nothing has moved yet."""
        if time > 0.0:
            self._update(description=self._name, completed=time)

    def closing(self) -> None:
        """Say that files are being finished."""
        self._update(description="writing")

    def _update(self, *, description: str, completed: float | None = None) -> None:
        if self._bar is not None and self._task is not None:
            with suppress(OSError):
                self._bar.update(self._task, description=description, completed=completed)


class CountBar(ProgressBar):
    """Things done against those wanted."""

    form = "{task.completed:.0f} of {task.total:.0f}"

    def counted(self, count: int, told: str) -> None:
        """Show how many are done, and what there is to tell of them."""
        self._update(description=f"{self._name}, {told}", completed=count)


def _bar(form: str) -> rich.progress.Progress:
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    return Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn(form),
        TimeRemainingColumn(),
        console=Console(stderr=True),
        transient=True,
        redirect_stdout=False,
        redirect_stderr=False,
    )
