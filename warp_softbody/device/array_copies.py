"""Copies of device arrays that can be written back."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import numpy.typing as npt

Copies = tuple[npt.NDArray[Any], ...]


def copied(arrays: Iterable[Any]) -> Copies:
    """What device arrays hold now."""
    return tuple(np.array(array.numpy()) for array in arrays)


def fits(arrays: Iterable[Any], saved: Copies) -> bool:
    """Whether copies can be written to device arrays: as many, of the same shapes and types."""
    kinds = [(array.numpy().shape, array.numpy().dtype) for array in arrays]
    return kinds == [(values.shape, values.dtype) for values in saved]


def write_back(arrays: Iterable[Any], saved: Copies) -> None:
    """Let device arrays hold what they once held; they have to fit."""
    for array, values in zip(arrays, saved, strict=True):
        array.assign(values)
