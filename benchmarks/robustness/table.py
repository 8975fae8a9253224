"""The table of docs/robustness.md."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from benchmarks.marked_page import put
from benchmarks.motions.criteria import CRITERIA
from benchmarks.robustness.outcomes import VariationOutcome

BEGIN = "<!-- written by python -m benchmarks.robustness, from here -->"
END = "<!-- to here -->"

WORST = ("volume", "reversals")
"""Criteria whose largest number over the variations is shown, of those that have the same bound in
every scene."""

Outcomes = Mapping[tuple[str, str], VariationOutcome]


def markdown(outcomes: Outcomes, scenes: Sequence[str], variations: Sequence[str]) -> str:
    """A line a scene, a column a variation, and the largest changes of volume and reversals."""
    rows = [["scene", "number", *variations, *(f"largest {name}" for name in WORST)]]
    for scene in scenes:
        done = [outcomes.get((scene, variation)) for variation in variations]
        cells = ["" if outcome is None else str(outcome) for outcome in done]
        rows.append([f"`{scene}`", asked(scene), *cells, *_worst(done)])
    lines = ["| " + " | ".join(cells) + " |" for cells in rows]
    lines.insert(1, "|" + " --- |" * len(rows[0]))
    return "\n".join(lines)


def asked(scene: str) -> str:
    """The own number of a scene and its bound."""
    own, *_ = CRITERIA[scene]
    return f"{own.name} {'>=' if own.at_least else '<'} {own.text(own.bound)}"


def _worst(outcomes: Sequence[VariationOutcome | None]) -> list[str]:
    known = [outcome.values for outcome in outcomes if outcome is not None and outcome.values]
    if not known:
        return ["-"] * len(WORST)
    return [f"{max(values[name] for values in known):.1%}" for name in WORST]


def write(page: Path, table: str) -> None:
    """Put the table between the marks of a page.

    Raises:
        ValueError: the page has no such marks.
    """
    put(page, BEGIN, END, table)
