"""The table of fidelity in docs/robustness.md, and what it comes to."""

from __future__ import annotations

import datetime
import math
import os
import platform
import textwrap
from collections.abc import Mapping, Sequence

from benchmarks.fidelity.variants import COMPARED
from benchmarks.motions.criteria import CRITERIA
from benchmarks.robustness.outcomes import VariationOutcome
from benchmarks.robustness.table import asked
from warp_softbody import scenes

BEGIN = "<!-- written by python -m benchmarks.fidelity, from here -->"
END = "<!-- to here -->"
WIDTH = 120

NOT_RUN = "not run"
STEADY = 0.15
"""Share by which the number of a motion that is known moves at most."""

Outcomes = Mapping[tuple[str, str], VariationOutcome]


def markdown(outcomes: Outcomes, rows: Sequence[str], variants: Sequence[str]) -> str:
    """A line a scene, a column a variant, how far the number moves, reasons, and a summary."""
    reasons = _reasons(outcomes, rows, variants)
    table = [["scene", "number", *variants, "moves by"]]
    for scene in rows:
        cells = [_cell(outcomes.get((scene, variant)), reasons) for variant in variants]
        table.append([f"`{scene}`", asked(scene), *cells, moves(outcomes, scene)])
    lines = ["| " + " | ".join(cells) + " |" for cells in table]
    lines.insert(1, "|" + " --- |" * len(table[0]))
    notes = [_folded(f"{number}. Refused: {reason}.", "   ") for reason, number in reasons.items()]
    texts = [_folded(summary(outcomes, rows, variants)), _folded(provenance())]
    return "\n\n".join(["\n".join(lines), *(["\n".join(notes)] if notes else []), *texts])


def moved(outcomes: Outcomes, scene: str) -> tuple[float, int] | None:
    """How far a scene's number moves between the compared variants, and how many of them ran.

    As a share of the shipped number; where a number is to be small, as an error is, of its bound.
    None where the shipped one or all others are missing. A run that broke off counts as infinitely
    far; those that are refused or were not made do not count.
    """
    own = CRITERIA[scene][0]
    found = [outcomes.get((scene, variant)) for variant in COMPARED]
    made = [one for one in found if one is not None and not (one.refused or one.limit)]
    shipped = found[0]
    if shipped is None or not shipped.values or len(made) < 2:
        return None
    if not all(one.values for one in made):
        return float("inf"), len(made)
    numbers = [one.values[own.name] for one in made]
    scale = abs(numbers[0]) if own.at_least else own.bound
    return (max(numbers) - min(numbers)) / scale, len(made)


def moves(outcomes: Outcomes, scene: str) -> str:
    """That as a cell."""
    found = moved(outcomes, scene)
    if found is None:
        return "-"
    share, count = found
    text = f"{share:.0%}" if math.isfinite(share) else "breaks off"
    return f"{text} ({count} of {len(COMPARED)})"


def summary(outcomes: Outcomes, rows: Sequence[str], variants: Sequence[str]) -> str:
    """How many cells hold all criteria, and what became of the others."""
    cells = [outcomes.get((scene, variant)) for scene in rows for variant in variants]
    made = [one for one in cells if one is not None and not one.limit]
    refused = sum(bool(one.refused) for one in made)
    held = sum(one.holds for one in made)
    known = [one for scene in rows if (one := moved(outcomes, scene)) is not None]
    steady = sum(share <= STEADY for share, _ in known)
    whole = sum(count == len(COMPARED) for _, count in known)
    return (
        f"{held} of {len(cells)} cells hold all criteria; {len(made) - held - refused} fail, "
        f"{refused} are refused, {len(cells) - len(made)} were not run or not to the end. "
        f"Between the compared variants that ran the number moves by at most {STEADY:.0%} in "
        f"{steady} of {len(known)} scenes; all {len(COMPARED)} ran in {whole}."
    )


def provenance() -> str:
    """When and where the table was written."""
    today = datetime.datetime.now(tz=datetime.timezone.utc).date()
    return f"Written on {today}, on {platform.machine()} with {os.cpu_count()} cores."


def _cell(outcome: VariationOutcome | None, reasons: Mapping[str, int]) -> str:
    if outcome is None:
        return NOT_RUN
    return f"refused ({reasons[_reason(outcome)]})" if outcome.refused else str(outcome)


def _reasons(outcomes: Outcomes, rows: Sequence[str], variants: Sequence[str]) -> dict[str, int]:
    """Numbers of the sentences of refusal, in the order of the table."""
    found: dict[str, int] = {}
    for scene in rows:
        for variant in variants:
            outcome = outcomes.get((scene, variant))
            if outcome is not None and outcome.refused:
                found.setdefault(_reason(outcome), len(found) + 1)
    return found


def _reason(outcome: VariationOutcome) -> str:
    """Why it is refused, in the same words for every body."""
    name = scenes.make(outcome.scene).scene.character.name
    return outcome.refused.replace(f"body {name!r}", "the body")


def _folded(text: str, indent: str = "") -> str:
    """Lines as the pages have them, the second and following ones set in."""
    return "\n".join(textwrap.wrap(text, WIDTH, subsequent_indent=indent))
