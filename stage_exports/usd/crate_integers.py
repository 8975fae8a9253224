"""Whole numbers as a crate packs them, in what `pxr/usd/sdf/integerCoding.h` and LZ4 allow.

Differences from number to number are told by a common one, two bits for each that say how long it
is, and the ones that are not the common. Here all have the same length, so that the bits are one
byte over and over, which LZ4 tells once; the rest it gets as it is.
"""

from __future__ import annotations

import struct

import numpy as np
import numpy.typing as npt

LEAST = 16
"""Elements below which an array is not packed."""

_LENGTHS = (np.dtype(np.int8), np.dtype(np.int16), np.dtype(np.int32))

_SHORTEST = 4
"""Bytes of a repetition that LZ4 can tell of."""


def compressed(values: npt.NDArray[np.int32]) -> bytes:
    """(n,) numbers, at least 16 of them, with the number of bytes in front."""
    steps = np.diff(values.astype(np.int64), prepend=0)
    largest = int(np.abs(steps).max())
    code = (largest > 127) + (largest > 32767)
    # 01, 10 or 11 four times, behind the common difference, which is not used
    head = bytes(4) + bytes([(code + 1) * 0b01010101])
    packed = b"\0" + _repeated(head, -(-len(values) // 4), steps.astype(_LENGTHS[code]).tobytes())
    return struct.pack("<Q", len(packed)) + packed


def _repeated(head: bytes, times: int, tail: bytes) -> bytes:
    """LZ4 of a head whose last byte stands so many times, and a tail of at least 12 bytes."""
    again = times - 1 - _SHORTEST
    if again < 0:
        return _sequence(head + head[-1:] * (times - 1) + tail)
    return _sequence(head, again) + _sequence(tail)


def _sequence(literals: bytes, again: int | None = None) -> bytes:
    """Literals, and the last of them over again, four times more than told."""
    token = min(len(literals), 15) << 4 | min(again or 0, 15)
    start = bytes([token]) + _more(len(literals)) + literals
    return start if again is None else start + b"\1\0" + _more(again)


def _more(count: int) -> bytes:
    """What the four bits of a token cannot hold of a number."""
    return b"" if count < 15 else b"\xff" * ((count - 15) // 255) + bytes([(count - 15) % 255])
