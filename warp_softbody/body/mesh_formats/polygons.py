"""The readers of surface files return their points and polygons in these types."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt


class Polygons(NamedTuple):
    """Points and faces of a file, unchecked.

    Attributes:
        points: (n, 3) m.
        faces: points of each face, from 0; an array (f, k) where all have k.
    """

    points: npt.ArrayLike
    faces: npt.NDArray[np.int64] | Sequence[Sequence[int]]


class Triangles(NamedTuple):
    """Points (n, 3) float64 m and triangles (f, 3) int64 over them."""

    points: npt.NDArray[np.float64]
    faces: npt.NDArray[np.int64]


Lines: TypeAlias = list[list[str]]


def word_lines(data: bytes, comment: str = "#") -> Lines:
    """Words of each line that is neither empty nor a comment.

    Raises:
        ValueError: the data is no text.
    """
    text = data.decode("utf-8")
    if "\0" in text:
        raise ValueError("it holds zero bytes where there should be text")
    words = (line.partition(comment)[0].split() for line in text.splitlines())
    return [line for line in words if line]
