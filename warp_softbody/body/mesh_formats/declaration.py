"""A `Declaration` holds how many points and cells a file says that it has."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True, kw_only=True)
class Declaration:
    """Sizes that a file declares, None for what it does not.

    Attributes:
        points: how many it holds.
        cells: how many of all kinds.
        solids: how many that fill space.
        point_numbers: the numbers that it gives to points, in its order.
        cell_numbers: the numbers that it gives to cells, in its order.
        cut_off: whether its format has no end mark and its last line no line end.
    """

    points: int | None = None
    cells: int | None = None
    solids: int | None = None
    point_numbers: list[int] = field(default_factory=list)
    cell_numbers: list[int] = field(default_factory=list)
    cut_off: bool = False
