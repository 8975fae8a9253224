"""Ctrl-C during a run."""

from __future__ import annotations

import signal
import threading
from types import FrameType, TracebackType


class Interruption:
    """Ctrl-C asks for a stop after the frame in hand; before the first frame it stops at once.

    A step that is broken off in the middle would leave half of its numbers behind, so the run loop
    looks at `asked` between frames. A second Ctrl-C does not wait.

    Attributes:
        asked: whether the user wants to stop.
        patient: whether to wait for the frame in hand; set when frames come quickly.
    """

    def __init__(self) -> None:
        """Listen only inside the `with` body."""
        self.asked = False
        self.patient = False
        self._before: object = None
        # Python lets only the main thread listen for signals.
        self._listens = threading.current_thread() is threading.main_thread()

    def __enter__(self) -> Interruption:
        """Listen."""
        if self._listens:
            self._before = signal.signal(signal.SIGINT, self._on_signal)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Give Ctrl-C back to whoever had it."""
        if self._listens:
            signal.signal(signal.SIGINT, self._before)  # type: ignore[arg-type]

    def _on_signal(self, number: int, frame: FrameType | None) -> None:
        if self.asked or not self.patient:
            raise KeyboardInterrupt
        self.asked = True
