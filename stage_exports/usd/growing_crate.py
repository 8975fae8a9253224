"""A crate, as a .usdc file is called, that grows behind what USD has written of it.

USD writes a layer as a whole: at the end of a take it would go through all samples once more. So it
writes what does not move, with one sample each of what does; samples follow as they come, and at
last tables of them. Where a crate tells how far away a table is, it then tells of the new one.

What is used of the format (`pxr/usd/sdf/crateFile.cpp`): an array stands as the number of its
elements and the elements; a value is told by a word of 64 bits, its type in the upper 16 and its
place in the file in the others; time samples are the distance to the word of their times, and
behind that the distance to the number of their values and those values' words.
"""

from __future__ import annotations

import os
import struct
from array import array
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from pxr import Sdf

from warp_softbody.stage_exports.conventions import TRANSLATION
from warp_softbody.stage_exports.usd.crate_integers import LEAST, compressed
from warp_softbody.stage_exports.usd.merging import export
from warp_softbody.stage_exports.usd.samples import SampleLayer
from warp_softbody.stage_exports.usd.series import Series

VERSION = bytes((0, 8, 0))
"""Of the format, which USD writes unless a layer holds something newer."""

ARRAY, INLINED, COMPRESSED = 1 << 63, 1 << 62, 1 << 61
PLACES = (1 << 48) - 1
"""Parts of a word."""

FIRST, LAST = 1e300 / 3.0, 1e300 / 7.0
"""Stand for the first and last time code until these are known."""

SMALL, MOST_KNOWN = 1024, 4096
"""Bytes of an array that is written once however often it comes, and how many are remembered."""

MUCH = 1 << 20
"""Bytes."""

ALIGNED = 4
"""Bytes; arrays of single precision are then read where they stand."""

_TABLE = struct.Struct("<qQdQqQQ")
"""Distance, times (their number, the one time and their word), distance, number, word."""


class UnknownCrate(Exception):
    """USD has written something elsewhere than it is looked for."""


class GrowingCrate:
    """A crate of a static layer and of samples.

    Its bytes depend on the frames alone, and not on how many of them come at once.
    """

    def __init__(self, path: Path, static: Any, series: Sequence[Series]) -> None:
        """Begin the file.

        Args:
            path: of the file.
            static: layer of what does not move.
            series: what will move, with at least one value each, as an example.

        Raises:
            OSError: it cannot be written.
            UnknownCrate: this version of USD writes crates in another way.
        """
        export(_example(static, series), str(path))
        begun = path.read_bytes()
        if begun[8:11] != VERSION:
            raise UnknownCrate
        self._tables = [_Table(begun, number) for number in range(len(series))]
        self._ends = [_place(begun, mark) for mark in (FIRST, LAST)]
        self._codes = array("d")
        self._known: dict[tuple[int, bytes], int] = {}
        self._file = path.open("r+b")
        self._file.seek(len(begun))
        self._end = len(begun)
        self._on_disk = 0
        self._parts: list[bytes] = []
        self._write(bytes(-len(begun) % ALIGNED))

    @property
    def frames(self) -> int:
        """Number of those that it holds."""
        return len(self._codes)

    def add(self, codes: Sequence[float], series: Sequence[Series]) -> None:
        """Write the values of further frames.

        Raises:
            OSError: the disk is full.
        """
        for row in range(len(codes)):
            for table, one in zip(self._tables, series, strict=True):
                table.words.append(self._word(table, one.values[row]))
        self._codes.extend(codes)
        self._flush()

    def to_disk(self) -> None:
        """Put what there is on the disk, if it is much, so that little is left for the end.

        Raises:
            OSError: the disk is full.
        """
        if self._end - self._on_disk >= MUCH:
            self._file.flush()
            os.fdatasync(self._file.fileno())
            self._on_disk = self._end

    def finish(self) -> None:
        """Write the tables, and where they are; the file is a whole crate then.

        Raises:
            OSError: the disk is full.
        """
        times = self._end
        self._write(struct.pack("<Q", len(self._codes)) + self._codes.tobytes())
        places = []
        for table in self._tables:
            places.append(self._end)
            word = table.time_type | times
            self._write(struct.pack("<QqQ", word, 8, len(table.words)) + table.words.tobytes())
        self._flush()
        for table, place in zip(self._tables, places, strict=True):
            self._file.seek(table.place)
            self._file.write(struct.pack("<q", place - table.place))
        for place, code in zip(self._ends, (self._codes[0], self._codes[-1]), strict=True):
            self._file.seek(place)
            self._file.write(struct.pack("<d", code))
        self._file.close()

    def close(self) -> None:
        """Let go of the file, whatever is in it."""
        self._file.close()

    def _word(self, table: _Table, value: npt.NDArray[Any]) -> int:
        """The word of a value, which is written unless it was before."""
        data = value.tobytes()
        if data == table.last:
            return table.words[-1]
        table.last = data
        known = self._known.get((table.type, data)) if len(data) <= SMALL else None
        if known is None:
            known = self._written(table.type, value, data)
            if len(data) <= SMALL and len(self._known) < MOST_KNOWN:
                self._known[table.type, data] = known
        return known

    def _written(self, type_: int, value: npt.NDArray[Any], data: bytes) -> int:
        word = type_ | self._end
        if type_ & ARRAY:
            if value.ndim == 1 and value.dtype == np.int32 and len(value) >= LEAST:
                data, word = compressed(value), word | COMPRESSED
            self._write(struct.pack("<Q", len(value)))
        self._write(data + bytes(-len(data) % ALIGNED))
        return word

    def _write(self, data: bytes) -> None:
        self._parts.append(data)
        self._end += len(data)

    def _flush(self) -> None:
        parts, self._parts = self._parts, []
        self._file.write(b"".join(parts))


class _Table:
    """The samples of one attribute.

    Attributes:
        place: in the file, of the distance to the word of the times.
        type: the part of a value's word that is no place.
        time_type: likewise of the times' word.
        words: of all values.
        last: bytes of the last value.
    """

    def __init__(self, begun: bytes, number: int) -> None:
        """Find the samples of an attribute, whose example stands at a time of its own.

        Raises:
            UnknownCrate: they do not look as they should.
        """
        self.place = _place(begun, _mark(number)) - 16
        first, many, _, times, second, count, word = _TABLE.unpack_from(begun, self.place)
        self.type, self.time_type = word & ~PLACES, times & ~PLACES
        found = first, many, times & PLACES, second, count
        if found != (24, 1, self.place + 8, 8, 1) or word & (INLINED | COMPRESSED):
            raise UnknownCrate
        self.words = array("Q")
        self.last = b""


def _mark(number: int) -> float:
    """A time that nothing else is."""
    return -1e300 / (3.0 + number)


def _place(begun: bytes, mark: float) -> int:
    """Where a number stands that stands there once."""
    data = struct.pack("<d", mark)
    place = begun.find(data)
    if place < 0 or begun.find(data, place + 1) >= 0:
        raise UnknownCrate
    return place


def _example(static: Any, series: Sequence[Series]) -> Any:
    """The static layer, with a single short sample of each attribute at its mark."""
    layer = Sdf.Layer.CreateAnonymous(".usda")
    layer.TransferContent(static)
    layer.startTimeCode, layer.endTimeCode = FIRST, LAST
    samples = SampleLayer(layer)
    for number, one in enumerate(series):
        first = one.values[0]
        # longer arrays are packed
        short = first if one.attribute == TRANSLATION else first[:1]
        samples.add([_mark(number)], [one._replace(values=[short])])
    layer.startTimeCode, layer.endTimeCode = FIRST, LAST
    return layer
