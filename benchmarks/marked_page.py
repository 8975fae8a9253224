"""Tables that commands write into pages written by hand, between marks."""

from __future__ import annotations

from pathlib import Path

from warp_softbody.atomic_files import replace_text


def put(page: Path, begin: str, end: str, text: str) -> None:
    """Put a text between the marks of a page, in place of what is there.

    Raises:
        ValueError: the page has no such marks.
    """
    before, found, rest = page.read_text(encoding="utf-8").partition(begin)
    _, closed, after = rest.partition(end)
    if not (found and closed):
        raise ValueError(f"the page has no lines {begin!r} and {end!r}")
    replace_text(page, f"{before}{begin}\n\n{text}\n\n{end}{after}")


def rows(cells: list[list[str]]) -> str:
    """A Markdown table, its head first."""
    lines = ["| " + " | ".join(row) + " |" for row in cells]
    lines.insert(1, "|" + "---|" * len(cells[0]))
    return "\n".join(lines)
