"""Polylines of OBJ files: ``l`` elements, under the names of their objects and groups."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.errors import MeshError

LARGEST_FILE = 2**28
"""Bytes of a file that are read."""


def read_polylines(path: Path) -> list[tuple[str, FloatArray]]:
    """Names and points (k, 3) of the polylines of a file, each name once.

    Raises:
        MeshError: it is missing, too large, holds no polyline, or a line of it makes no sense.
    """
    try:
        if path.stat().st_size > LARGEST_FILE:
            raise MeshError(f"{path}: it has more than {LARGEST_FILE >> 20} MiB")
        text = path.read_text(errors="replace")
    except OSError as error:
        raise MeshError(f"{path}: cannot be read: {error.strerror or error}") from error
    points: list[list[float]] = []
    lines: list[tuple[str, list[int]]] = []
    name = path.stem
    for number, line in enumerate(text.splitlines(), start=1):
        head, *words = line.split("#")[0].split() or [""]
        try:
            if head == "v":
                points.append([float(word) for word in words[:3]])
                if len(points[-1]) != 3 or not np.isfinite(points[-1]).all():
                    raise ValueError("a vertex needs three finite numbers")
            elif head in ("o", "g") and words:
                name = "_".join(words)
            elif head == "l":
                lines.append((name, [_place(word, len(points)) for word in words]))
        except ValueError as error:
            raise MeshError(f"{path}, line {number}: {error}") from error
    if not lines:
        raise MeshError(f"{path}: it holds no polyline; curves are exported as lines ('l')")
    found, used = [], set[str]()
    for name, corners in lines:
        if len(corners) < 2:
            raise MeshError(f"{path}: polyline {name!r} has fewer than two points")
        own, count = name, 1
        while own in used:
            own, count = f"{name}_{count}", count + 1
        used.add(own)
        found.append((own, np.array([points[corner] for corner in corners])))
    return found


def _place(word: str, count: int) -> int:
    """Index from 0 of a vertex that is counted from 1, or back from the last."""
    given = int(word.split("/")[0])
    index = given - 1 if given > 0 else count + given
    if not 0 <= index < count or not given:
        raise ValueError(f"there is no vertex {given} among {count}")
    return index
