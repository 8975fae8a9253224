"""A frame as bytes and back, for a process that shares memory with this one."""

from __future__ import annotations

import struct
from contextlib import suppress
from operator import attrgetter
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from warp_softbody.inputs.records import unchecked
from warp_softbody.world.frame import ContactSample, Frame

Kind = TypeVar("Kind", bound=np.generic)

_HEAD = struct.Struct("<qd7q")
"""Index, time, and rows of positions, activations, fibre points, contacts, nodes of contacts,
patches and nodes of patches."""

_CONTACTS = (
    *("points", "forces", "partner_weights"),
    *("modes", "bodies", "partners", "partner_nodes", "nodes"),
)
"""Three arrays of numbers and five of whole ones; there may be no nodes where there are points."""

_arrays = attrgetter("positions", "velocities", "activations", "fiber_points")
_contact_arrays = attrgetter(*_CONTACTS)

_NUMBERS, _WHOLES = np.dtype(np.float64), np.dtype(np.int32)
_OWN_KINDS: list[np.dtype[Any]] = [_NUMBERS] * 4
_CONTACT_KINDS: list[np.dtype[Any]] = [*[_NUMBERS] * 3, *[_WHOLES] * 5]
"""Of a frame's own arrays and of those of contacts."""


def packed(frame: Frame) -> bytes:
    """All of a frame but the names of its contacts, in double precision."""
    arrays = _arrays(frame)
    kinds = _OWN_KINDS
    counts = [len(arrays[0]), len(arrays[2]), len(arrays[3])]
    for sample in (frame.contacts, frame.patches):
        counted = len(sample.points), len(sample.nodes)
        counts += counted
        if any(counted):
            arrays += _contact_arrays(sample)
            kinds = kinds + _CONTACT_KINDS
    head = _HEAD.pack(frame.index, frame.time, *counts)
    # nearly all are of these kinds and lie in order: a run does this for every frame
    if [array.dtype for array in arrays] == kinds:
        with suppress(TypeError, ValueError, BufferError):
            return b"".join((head, *arrays))
    plain = map(np.ascontiguousarray, arrays, kinds)
    return b"".join((head, *(array.data for array in plain)))


def unpacked(data: memoryview) -> Frame:
    """The frame of such bytes, whose arrays are views of them."""
    index, time, nodes, segments, vertices, *counts = _HEAD.unpack_from(data)
    cursor = _Cursor(data, _HEAD.size)
    return unchecked(
        Frame,
        index=index,
        time=time,
        positions=cursor.numbers(nodes, 3),
        velocities=cursor.numbers(nodes, 3),
        activations=cursor.numbers(segments, 1),
        fiber_points=cursor.numbers(vertices, 3),
        contacts=_contacts(cursor, *counts[:2]),
        patches=_contacts(cursor, *counts[2:]),
    )


def _contacts(cursor: _Cursor, count: int, named: int) -> ContactSample:
    if not count and not named:
        return ContactSample()
    held: dict[str, npt.NDArray[Any]] = {name: cursor.numbers(count, 3) for name in _CONTACTS[:3]}
    for name, width in zip(_CONTACTS[3:-1], (1, 1, 1, 3), strict=True):
        held[name] = cursor.wholes(count, width)
    return unchecked(ContactSample, **held, nodes=cursor.wholes(named, 1), names=())


class _Cursor:
    """Takes array after array from bytes."""

    def __init__(self, data: memoryview, start: int) -> None:
        self._data = data
        self._place = start

    def numbers(self, rows: int, width: int) -> npt.NDArray[np.float64]:
        return self._take(rows, width, np.float64)

    def wholes(self, rows: int, width: int) -> npt.NDArray[np.int32]:
        return self._take(rows, width, np.int32)

    def _take(self, rows: int, width: int, kind: type[Kind]) -> npt.NDArray[Kind]:
        array = np.frombuffer(self._data, kind, rows * width, self._place)
        self._place += array.nbytes
        return array.reshape(rows, width) if width > 1 else array
