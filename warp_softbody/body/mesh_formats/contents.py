"""`Contents` carries what a tet file holds from the reading process to the one that asked."""

from __future__ import annotations

import io
import json
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import numpy.typing as npt


class Contents(NamedTuple):
    """Points and tets of a file, unchecked.

    Attributes:
        points: (n, 3) float64 m.
        tets: (m, 4) int64.
        groups: numbers of the points (k,) int64 of each named group.
        notes: a sentence each, without the file's name, on what else the file holds.
    """

    points: npt.NDArray[np.float64]
    tets: npt.NDArray[np.int64]
    groups: Mapping[str, npt.NDArray[np.int64]]
    notes: tuple[str, ...]


class ReadingFailed(Exception):
    """A file cannot be read; the text is the reason, without the file's name."""


def pack(result: Contents | str) -> bytes:
    """Bytes of the contents, or of the reason why there are none."""
    arrays: list[npt.NDArray[np.float64] | npt.NDArray[np.int64]] = []
    if isinstance(result, str):
        header: dict[str, object] = {"error": result}
    else:
        header = {"groups": list(result.groups), "notes": result.notes}
        arrays = [result.points, result.tets, *result.groups.values()]
    stream = io.BytesIO()
    np.savez(stream, np.frombuffer(json.dumps(header).encode(), dtype=np.uint8), *arrays)
    return stream.getvalue()


def unpack(data: bytes) -> Contents:
    """Contents that were packed.

    Raises:
        ReadingFailed: a reason was packed in their place.
    """
    with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
        header = json.loads(arrays["arr_0"].tobytes())
        if "error" in header:
            raise ReadingFailed(header["error"])
        groups = {name: arrays[f"arr_{i}"] for i, name in enumerate(header["groups"], 3)}
        return Contents(arrays["arr_1"], arrays["arr_2"], groups, tuple(header["notes"]))
