"""Simulated time is kept to real time, or a share of it."""

from __future__ import annotations

import time

LATE = 0.1
"""Seconds behind beyond which no time is made up for."""


class Pace:
    """Says when the next step is due.

    Attributes:
        speed: simulated over real time.
    """

    def __init__(self) -> None:
        """Begin now, at real time."""
        self.speed = 1.0
        self._due = time.perf_counter()

    def begin(self) -> None:
        """Begin anew: the next step is due now."""
        self._due = time.perf_counter()

    def wait(self, step: float) -> float:
        """Seconds until the next step, of ``step`` simulated seconds, is due; none if it is."""
        now = time.perf_counter()
        if now - self._due > LATE:
            self._due = now
        return max(0.0, self._due - now)

    def note(self, step: float) -> None:
        """A step of so many simulated seconds was taken."""
        self._due += step / self.speed
