"""Values of every wrong kind, and which of them no parameter of a type hint may take."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np


class Awkward:
    """An object of a user's own that can be neither shown nor read as an array."""

    def __repr__(self) -> str:
        """Fail."""
        raise RuntimeError("no text")

    def __array__(self, *_: Any, **__: Any) -> np.ndarray[Any, Any]:
        """Fail."""
        raise RuntimeError("no array")


def _numbers() -> Iterator[int]:
    yield from (1, 2, 3)


TEXTS: tuple[Any, ...] = ("soft", "", b"soft", "\udcff", "x" * 10_000, "a\0b", "~nobody/x")
NO_NUMBERS: tuple[Any, ...] = (
    None,
    True,
    1j,
    [],
    (),
    {},
    set(),
    [[1, 2], [3]],
    {"a": 1},
    np.complex128(2.0),
)
OBJECTS: tuple[Any, ...] = (
    object(),
    Awkward(),
    int,
    math.sqrt,
    lambda: 1,
    _numbers,
    np.array(["a"], dtype=object),
)
NOT_FINITE: tuple[Any, ...] = (math.nan, math.inf, -math.inf, np.float32("nan"), np.array(math.nan))
SIZES: tuple[Any, ...] = (
    -1,
    0,
    1.7,
    1e300,
    -1e300,
    10**400,
    2**63,
    -(2**70),
    np.int64(-5),
    np.longdouble(1e4000),
)
ARRAYS: tuple[Any, ...] = (
    np.zeros(3, dtype=bool),
    np.full(3, np.nan),
    np.full((2, 3), np.inf),
    np.zeros((0, 3)),
    np.zeros((2, 3, 4)),
    np.array(1.5 + 2.0j),
    [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]],
    range(5),
    (1.0, 2.0),
    (math.nan, 0.0, 0.0),
    ("a", "b", "c"),
    np.array([2**32 + 3]),
    np.array(["2020-01-01"], dtype="datetime64[D]"),
)
EVERY: tuple[Any, ...] = (*TEXTS, *NO_NUMBERS, *OBJECTS, *NOT_FINITE, *SIZES, *ARRAYS)

REFUSED: dict[str, tuple[Any, ...]] = {
    "float": (*TEXTS, *NO_NUMBERS[1:], *OBJECTS, math.nan, ARRAYS[1], ARRAYS[6]),
    "int": (*TEXTS, *NO_NUMBERS[1:], *OBJECTS, *NOT_FINITE, *SIZES[2:6], *ARRAYS),
    "bool": (*TEXTS, *OBJECTS, *NOT_FINITE, *SIZES, *ARRAYS, 1j, []),
    "str": (*NO_NUMBERS[1:], *OBJECTS, *NOT_FINITE, *SIZES, *ARRAYS, "", "\udcff"),
    "Vector": (*TEXTS, *NO_NUMBERS, *OBJECTS, *NOT_FINITE, *SIZES, ARRAYS[1], ARRAYS[8]),
    "FloatArray": (*TEXTS, True, 1j, {}, set(), [[1, 2], [3]], *OBJECTS[:-1], ARRAYS[5]),
    "object": (*TEXTS, *NO_NUMBERS[1:], *OBJECTS, *NOT_FINITE, *SIZES, *ARRAYS),
}
"""By the kind of a parameter what it must refuse, whatever else is given."""


def label(value: object) -> str:
    """A value as a test's failure shows it."""
    try:
        return repr(value)[:60]
    except RuntimeError:
        return type(value).__name__


def kind_of(hint: str) -> str | None:
    """The kind of `REFUSED` that a type hint as it is written stands for; None if none is sure."""
    plain = hint.removesuffix(" | None")
    for name, kind in {
        "float": "float",
        "int": "int",
        "bool": "bool",
        "str": "str",
        "Vector": "Vector",
        "tuple[float, float, float]": "Vector",
        "FloatArray": "FloatArray",
    }.items():
        if plain == name:
            return kind
    return (
        "object" if plain.isidentifier() and plain[0].isupper() and plain not in ALIASES else None
    )


ALIASES = {
    "Guide",
    "Any",
    "Gait",
    "Size",
    "Ground",
    "IntArray",
    "Values",
    "Build",
    "Ends",
    "Reward",
    "Controller",
    "FiberKind",
}
"""Hints that stand for more than objects of one class."""
