"""A run ends in order on Ctrl-C, SIGTERM and SIGHUP, the signal of a closed terminal."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType, TracebackType

LISTENED = ("SIGINT", "SIGTERM", "SIGHUP")

Handler = Callable[[int, FrameType | None], None]


class Interrupted(KeyboardInterrupt):
    """A signal asked for the end; whatever deals with Ctrl-C deals with it.

    Attributes:
        number: of the signal.
        left: what is left to do, as the end of a sentence.
    """

    def __init__(self, number: int) -> None:
        """Keep the number."""
        super().__init__(number)
        self.number = number
        self.left = ""

    def __str__(self) -> str:
        """One sentence."""
        return f"interrupted{self.left}"


def exit_code(number: int) -> int:
    """What a shell tells of a program that a signal ended."""
    return 128 + number


@contextmanager
def interruptible() -> Iterator[None]:
    """Inside the body all these signals raise `Interrupted`, unless `nohup` ignores them."""
    with _handled_by(_interrupt):
        yield


def _interrupt(number: int, frame: FrameType | None) -> None:
    if _Held.depth:
        _Held.number = number
    else:
        raise Interrupted(number)


class _Held:
    """Signals that wait.

    Attributes:
        depth: of `held_back` bodies.
        number: of the signal that came meanwhile, or 0.
    """

    depth = 0
    number = 0


@contextmanager
def held_back() -> Iterator[None]:
    """Let signals wait for the end of the body: USD swallows exceptions while it is imported."""
    _Held.depth += 1
    try:
        yield
    finally:
        _Held.depth -= 1
    if not _Held.depth and _Held.number:
        number, _Held.number = _Held.number, 0
        raise Interrupted(number)


class Interruption:
    """A signal asks for a stop after the frame in hand; before the first frame it stops at once.

    A step that is broken off in the middle would leave half of its numbers behind, so the run loop
    looks at `asked` between frames. A second signal does not wait.

    Attributes:
        asked: whether the user wants to stop.
        number: of the signal that asked.
        patient: whether to wait for the frame in hand; set when frames come quickly.
    """

    def __init__(self) -> None:
        """Listen only inside the `with` body."""
        self.asked = False
        self.number = int(signal.SIGINT)
        self.patient = False
        self._listening = _handled_by(self._on_signal)

    def __enter__(self) -> Interruption:
        """Listen."""
        self._listening.__enter__()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Give the signals back to whoever had them."""
        self._listening.__exit__(kind, error, trace)

    def _on_signal(self, number: int, frame: FrameType | None) -> None:
        self.number = number
        if self.asked or not self.patient:
            raise Interrupted(number)
        self.asked = True


@contextmanager
def _handled_by(handler: Handler) -> Iterator[None]:
    before = {}
    # Python lets only the main thread listen for signals.
    if threading.current_thread() is threading.main_thread():
        numbers = [getattr(signal, name) for name in LISTENED if hasattr(signal, name)]
        before = {n: signal.signal(n, handler) for n in numbers if _is_open(n)}
    try:
        yield
    finally:
        for number, former in before.items():
            signal.signal(number, former)


def _is_open(number: int) -> bool:
    """Whether a signal may be listened for: not what `nohup` ignores or other code handles."""
    former = signal.getsignal(number)
    return former is not None and (former is not signal.SIG_IGN or number == signal.SIGINT)
