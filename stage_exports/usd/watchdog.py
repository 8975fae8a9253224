"""Ends this process when it makes no progress; where it was not started, nothing happens.

A stage may hold many frames in few bytes, so what counts is the time since the last value was read,
and not that of the whole file.
"""

from __future__ import annotations

import signal

ENDINGS = (signal.SIGPROF, signal.SIGALRM)
"""What ends the process: for CPU time without progress, or for waiting."""
WAIT = 4.0
"""Times the CPU time that is waited, on a machine with other work."""

_allowed = 0.0


def start(seconds: float) -> None:
    """End this process once it has made no progress for so many seconds of CPU time."""
    global _allowed
    for number in ENDINGS:
        signal.signal(number, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, ENDINGS)
    _allowed = seconds
    feed()


def feed() -> None:
    """Say that there was progress."""
    if _allowed:
        signal.setitimer(signal.ITIMER_PROF, _allowed)
        signal.setitimer(signal.ITIMER_REAL, WAIT * _allowed)
