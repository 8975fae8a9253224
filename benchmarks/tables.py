"""Tables that people read on a terminal or in a file."""

from __future__ import annotations

import io
from collections.abc import Iterable, Sequence

from rich.console import Console
from rich.table import Table

WIDTH = 400
"""Characters, so that no line is folded."""


def as_text(titles: Sequence[str], rows: Iterable[Iterable[object]], *, left: str) -> str:
    """Lines of a table whose columns are as wide as what they hold.

    Args:
        titles: of the columns.
        rows: cells of each row.
        left: title of the column of text, set to the left; numbers are set to the right.
    """
    table = Table(box=None, pad_edge=False)
    for title in titles:
        table.add_column(title, justify="left" if title == left else "right")
    for row in rows:
        table.add_row(*map(str, row))
    console = Console(file=io.StringIO(), width=WIDTH, no_color=True, highlight=False, markup=False)
    with console.capture() as captured:
        console.print(table)
    return "\n".join(line.rstrip() for line in captured.get().splitlines())
