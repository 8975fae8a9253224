"""An STL file lists triangles, each with a normal, as text or in 50 bytes."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from warp_softbody.body.mesh_formats.polygons import Polygons

HEADER, FACET = 84, 50
"""Bytes of the header, with the count at its end, and of each triangle."""

LONGEST_WORD = 80
"""Letters of a word; a number has fewer."""

WORDS = {0: "facet", 1: "normal", 5: "outer", 6: "loop", 7: "vertex", 11: "vertex", 15: "vertex"}
WORDS |= {19: "endloop", 20: "endfacet"}
"""Place of each keyword among the 21 words of a triangle."""


def read_stl(path: Path) -> Polygons:
    """Three points for each triangle."""
    data = path.read_bytes()
    count = int.from_bytes(data[80:HEADER], "little") if len(data) >= HEADER else -1
    if len(data) == HEADER + FACET * count:
        records = np.frombuffer(data, dtype=np.uint8, offset=HEADER).reshape(-1, FACET)
        corners = np.ascontiguousarray(records[:, 12:48]).view("<f4")
    elif data[:200].lstrip().lower().startswith(b"solid"):
        corners = _text_corners(data)
    else:
        raise ValueError(
            f"it has {len(data)} bytes, but {HEADER + FACET * count} with the {count} triangles "
            f"that it declares"
            if count >= 0
            else "it is too short"
        )
    points = corners.reshape(-1, 3).astype(np.float64)
    return Polygons(points, np.arange(len(points)).reshape(-1, 3))


def _text_corners(data: bytes) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Corners (f, 9) of a text; names of solids may hold any words."""
    words: list[str] = []
    depth = 0
    for line in data.decode("utf-8", errors="replace").splitlines():
        first = line.split(maxsplit=1)[:1]
        if first and first[0].lower() in ("solid", "endsolid"):
            depth += 1 if first[0].lower() == "solid" else -1
            if depth not in (0, 1):
                raise ValueError("solid and endsolid do not take turns")
        elif first:
            words += line.split()
    if depth:
        raise ValueError("it ends without endsolid")
    if len(words) % 21:
        raise ValueError("it ends within a triangle, or a triangle has not 21 words")
    longest = max(map(len, words), default=0)
    if longest > LONGEST_WORD:
        raise ValueError(f"one of its words has {longest} letters")
    table = np.array(words, dtype=str).reshape(-1, 21)
    for place, word in WORDS.items():
        wrong = np.flatnonzero(np.char.lower(table[:, place]) != word)
        if wrong.size:
            raise ValueError(f"triangle {wrong[0]} has {table[wrong[0], place]!r}, not {word!r}")
    columns = [8, 9, 10, 12, 13, 14, 16, 17, 18]
    return table[:, columns].astype(np.float64)
