r"""The messages that a page is sent.

A live page reads one endless answer of messages, each with its length in front:

    u32  bytes that follow
    u8   kind: 1 outline, 2 update, 3 status
    ...  contents

An outline (`SceneOutline.as_json`) and a status (`session.py`) are JSON in UTF-8. An update holds
one moment. Numbers are little-endian; n, s, k and p are the counts of numbers, muscle segments,
surface points and fibre points, which the outline tells:

    f64  time, s
    f32  scale, m, and 3 f32 origin, m, of the grid
    u16  c, contacts;  u16  q, patches of the plan
    n    f32  numbers, by the outline's names; NaN for what there is not
    c+q  6 f32  point, m, and force, N, of each contact, then of each patch
    c+q  u8  mode (0 lift, 1 stick, 2 slide), plus 4 for the character on the ground
    s    u8  contraction: 1 - l_d / l_0 from 0 to 0.5 as 0 to 255
    6(k+p) bytes  cells of the surface points, then of the fibre points, x y z by x y z, u16:
         first all low bytes, then all high bytes; each cell less its cell in the update before
         (modulo 65536) in a finished take, whose bytes then compress well, less 0 in a live one

A point is at origin + scale * cell. A take's updates stand one after the other, each with its u32
length in front, and without a kind.
"""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.live.grid import Grid, MovingGrid
from warp_softbody.world.frame import ContactSample

OUTLINE, UPDATE, STATUS = 1, 2, 3
HEAD = struct.Struct("<d4f2H")
LENGTH = struct.Struct("<I")
ON_GROUND = 4
"""Added to the mode of a contact of the character with the ground."""
MOST_CONTACTS = 4096
"""Of an update; a page that shows more shows none of them well."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Moment:
    """What an update tells.

    Attributes:
        time: s.
        surface: (k, 3) m, the shown points of all bodies.
        fibers: (p, 3) m.
        contraction: (s,) 1 - l_d / l_0.
        contacts: of all bodies.
        patches: of the plan.
        numbers: (n,) by the names of the outline.
    """

    time: float
    surface: FloatArray
    fibers: FloatArray
    contraction: FloatArray
    numbers: FloatArray
    contacts: ContactSample = field(default_factory=ContactSample)
    patches: ContactSample = field(default_factory=ContactSample)


class UpdateEncoder:
    """Encodes moments one after the other."""

    def __init__(self, start: FloatArray, *, differences: bool) -> None:
        """For points (k, 3) m in their start pose; ``differences`` are those of a take."""
        self._grid = MovingGrid(start)
        self._differences = differences
        self._before: Grid | None = None

    def encode(self, moment: Moment) -> bytes:
        """The contents of the update."""
        origin, cells = self._grid.place(np.concatenate([moment.surface, moment.fibers]))
        samples = [_clipped(moment.contacts), _clipped(moment.patches)]
        counts = [len(points) for points, _ in samples]
        head = HEAD.pack(moment.time, self._grid.scale, *origin.tolist(), *counts)
        places = np.concatenate([points for points, _ in samples])
        modes = np.concatenate([modes for _, modes in samples])
        contraction = np.clip(np.rint(510.0 * moment.contraction), 0, 255)
        parts = [
            head,
            moment.numbers.astype("<f4").tobytes(),
            places.astype("<f4").tobytes(),
            modes.astype(np.uint8).tobytes(),
            contraction.astype(np.uint8).tobytes(),
            self._packed(cells),
        ]
        return b"".join(parts)

    def _packed(self, cells: Grid) -> bytes:
        told = cells
        if self._differences and self._before is not None:
            told = cells - self._before
        self._before = cells
        pairs = told.astype("<u2").ravel().view(np.uint8).reshape(-1, 2)
        return bytes(pairs.T.tobytes())


def _clipped(sample: ContactSample) -> tuple[FloatArray, npt.NDArray[np.int32]]:
    """Points with forces (c, 6), and modes with their mark (c,)."""
    rows = np.concatenate([sample.points, sample.forces], axis=1)[:MOST_CONTACTS]
    on_ground = (sample.bodies == 0) & (sample.partners < 0)
    return rows, (sample.modes + ON_GROUND * on_ground)[:MOST_CONTACTS]


def message(kind: int, contents: bytes) -> bytes:
    """A message of the live stream."""
    return LENGTH.pack(1 + len(contents)) + bytes([kind]) + contents


def as_text(value: dict[str, Any]) -> bytes:
    """JSON in UTF-8 of what is finite."""
    return json.dumps(value, allow_nan=False, separators=(",", ":")).encode()
