"""The tables of docs/stability.md."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from benchmarks.stability.outcomes import CONFIGURATIONS, StabilityOutcome, everything
from benchmarks.stability.peers import PEERS, peers
from warp_softbody.atomic_files import replace_text

BEGIN = "<!-- written by python -m benchmarks.stability, from here -->"
END = "<!-- to here -->"

MOST_CHARACTERS = 140
"""Of a cell."""


def markdown(outcomes: Sequence[StabilityOutcome]) -> str:
    """What peers and ours did, and the numbers of the first configuration and of all failures."""
    found = {(outcome.case, outcome.configuration): outcome for outcome in outcomes}
    verdicts = [["case", "what is extreme", *PEERS, *CONFIGURATIONS]]
    for row in everything():
        known = dict(zip(PEERS, peers(row.name), strict=True))
        cells = [
            _cell(found[row.name, column])
            if (row.name, column) in found
            else known.get(column, "-")
            for column in (*PEERS, *CONFIGURATIONS)
        ]
        verdicts.append([row.name, row.extreme, *cells])
    numbers = [["case", "configuration", *NUMBERS]]
    for outcome in outcomes:
        if outcome.runs and (
            outcome.failures or outcome.configuration == next(iter(CONFIGURATIONS))
        ):
            numbers.append([outcome.case, outcome.configuration, *_numbers(outcome)])
    return f"{_table(verdicts)}\n\n{_table(numbers)}"


def _cell(outcome: StabilityOutcome) -> str:
    text = outcome.verdict
    if len(text) > MOST_CHARACTERS:
        text = text[: MOST_CHARACTERS - 3] + "..."
    return f"**{text}**" if outcome.failures else text


NUMBERS = (
    "starts",
    "steps",
    "volume",
    "least tet",
    "inverted",
    "shape",
    "start, J",
    "peak, J",
    "rise, J",
    "spin",
    "drift, m",
    "iterations",
    "unconverged",
)


def _numbers(outcome: StabilityOutcome) -> list[str]:
    """The worst of the runs in each column; a dash for what none came to, or is not known."""
    runs = outcome.runs
    ended = [run for run in runs if run.stopped is None and run.overlooked is None]
    unconverged = str(sum(run.unconverged for run in runs))
    if not ended:
        steps = str(max(run.steps for run in runs))
        return [str(len(runs)), steps, *["-"] * (len(NUMBERS) - 3), unconverged]
    ours = outcome.configuration in CONFIGURATIONS
    energies = [
        f"{max(run.start for run in ended):.3g}",
        f"{max(run.peak for run in ended):.3g}",
        f"{max(run.growth for run in ended):.1e}",
        f"{max(run.spin for run in ended):.1e}",
    ]
    return [
        str(len(runs)),
        str(ended[0].steps),
        f"{max((run.volume for run in ended), key=lambda volume: abs(volume - 1.0)):.4f}",
        f"{min(run.smallest for run in ended):.4f}",
        str(max(run.inverted for run in ended)),
        f"{max(run.shape for run in ended):.1e}",
        *(energies if ours else ["-"] * len(energies)),
        f"{max(run.drift for run in ended):.1e}",
        f"{sum(run.iterations for run in ended) / len(ended):.1f}" if ours else "-",
        unconverged,
    ]


def _table(rows: list[list[str]]) -> str:
    lines = ["| " + " | ".join(cells) + " |" for cells in rows]
    lines.insert(1, "|" + " --- |" * len(rows[0]))
    return "\n".join(lines)


def text(outcomes: Sequence[StabilityOutcome]) -> str:
    """A line for each outcome, for a terminal."""
    width = max(len(outcome.case) for outcome in outcomes)
    return "\n".join(
        f"{outcome.case:{width}}  {outcome.configuration:{max(map(len, CONFIGURATIONS))}}  "
        f"{'FAILS ' if outcome.failures else ''}{outcome.verdict}"
        for outcome in outcomes
    )


def replaced(page: str, table: str) -> str:
    """A page with what stands between the two marks replaced.

    Raises:
        ValueError: the page has no such marks.
    """
    before, begin, rest = page.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not (begin and end):
        raise ValueError(f"the page has no lines {BEGIN!r} and {END!r}")
    return f"{before}{BEGIN}\n\n{table}\n\n{END}{after}"


def write(path: Path, outcomes: Sequence[StabilityOutcome]) -> None:
    """Put the tables into a page."""
    page = path.read_text(encoding="utf-8")
    replace_text(path, replaced(page, markdown(outcomes)))
