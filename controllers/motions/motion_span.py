"""When a motion of a sequence took place, as it is told of a run."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class MotionSpan:
    """When a motion of a sequence took place.

    Attributes:
        name: its own.
        begun: s.
        ended: s; None for one that goes on.
    """

    name: str
    begun: float
    ended: float | None = None

    def __str__(self) -> str:
        """In a few words."""
        end = "" if self.ended is None else f" to {self.ended:.4g} s"
        return f"{self.name} from {self.begun:.4g} s{end}"
