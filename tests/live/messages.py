"""Reads what a page is sent, apart from the program's own code, by the words of `wire.py`."""

from __future__ import annotations

import base64
import json
import re
import struct
import zlib
from dataclasses import dataclass
from typing import Any

import numpy as np

from warp_softbody.arrays import FloatArray


@dataclass
class Told:
    """An update as it is read.

    Attributes:
        time: s.
        scale: m, of a cell.
        numbers: by name.
        places: (k + p, 3) m, surface points, then fibre points.
        contacts, patches: (c, 6) points and forces.
        modes: (c + q,).
        contraction: (s,).
        cells: (k + p, 3).
    """

    time: float
    scale: float
    numbers: dict[str, float]
    places: FloatArray
    contacts: FloatArray
    patches: FloatArray
    modes: list[int]
    contraction: FloatArray
    cells: np.ndarray[Any, np.dtype[np.uint16]]


def read_update(contents: bytes, outline: dict[str, Any], before: Told | None = None) -> Told:
    """One update; ``before`` is that of a take before it."""
    time, scale, x, y, z, contacts, patches = struct.unpack_from("<d4f2H", contents)
    at = 28

    def take(kind: str, count: int) -> np.ndarray[Any, Any]:
        nonlocal at
        found = np.frombuffer(contents, kind, count, at)
        at += found.nbytes
        return found

    numbers = take("<f4", len(outline["numbers"]))
    rows = take("<f4", 6 * (contacts + patches)).reshape(-1, 6)
    modes = take("u1", contacts + patches)
    contraction = take("u1", len(outline["segments"]) // 2)
    count = 3 * (outline["points"] + outline["fiberPoints"])
    low, high = take("u1", count), take("u1", count)
    assert at == len(contents)
    cells = (low + 256 * high.astype(np.uint16)).astype(np.uint16).reshape(-1, 3)
    if before is not None:
        cells = cells + before.cells
    return Told(
        time=time,
        scale=scale,
        numbers=dict(zip(outline["numbers"], numbers.tolist(), strict=True)),
        places=np.array((x, y, z)) + scale * cells.astype(float),
        contacts=rows[:contacts].astype(float),
        patches=rows[contacts:].astype(float),
        modes=modes.tolist(),
        contraction=contraction / 510.0,
        cells=cells,
    )


def read_take_page(page: str) -> tuple[dict[str, Any], list[Told]]:
    """Outline and updates of a page that plays a take."""
    packed = re.search(r'<script type="text/plain" id="take">([^<]*)</script>', page)
    assert packed is not None
    contents = zlib.decompress(base64.b64decode(packed.group(1), validate=True))
    parts, at = [], 0
    while at < len(contents):
        (length,) = struct.unpack_from("<I", contents, at)
        parts.append(contents[at + 4 : at + 4 + length])
        at += 4 + length
    outline = json.loads(parts[0])
    updates: list[Told] = []
    for part in parts[1:]:
        updates.append(read_update(part, outline, updates[-1] if updates else None))
    return outline, updates
