"""What was timed, and how it is printed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from benchmarks.marked_page import rows
from benchmarks.speed.works import OURS, OURS_FLOAT64, PEERS

BEGIN = "<!-- python -m benchmarks.speed: begin -->"
END = "<!-- python -m benchmarks.speed: end -->"
DASH = "-"


@dataclass(frozen=True, kw_only=True)
class Timing:
    """A row.

    Attributes:
        name: of the work.
        about: what was done.
        unit: of the times.
        times: by program, `OURS` among them unless it failed.
    """

    name: str
    about: str
    unit: str
    times: dict[str, float] = field(default_factory=dict)

    def ratio(self, program: str) -> float | None:
        """A program's time over that of this one; peers' over that in double precision."""
        basis = self.times.get(OURS_FLOAT64 if program in PEERS else OURS)
        own = self.times.get(program)
        return None if basis is None or own is None else own / basis


def markdown(timings: Sequence[Timing]) -> str:
    """The table: times of this program, ratios of all others."""
    seen = {program for timing in timings for program in timing.times}
    others = [OURS_FLOAT64, *PEERS, *sorted(seen - {OURS, OURS_FLOAT64, *PEERS})]
    shown = [program for program in others if program in seen]
    cells = [["work", "unit", "time", *shown]]
    for timing in timings:
        ratios = [timing.ratio(program) for program in shown]
        cells.append(
            [timing.about, timing.unit, _digits(timing.times.get(OURS)), *map(_digits, ratios)]
        )
    return rows(cells)


def _digits(value: float | None) -> str:
    """Three digits that count; a dash where there is no number."""
    if value is None:
        return DASH
    return f"{value:.0f}" if value >= 100.0 else f"{value:.3g}"
