"""Node sets, names, colours, paths and controllers have checks of their own."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterable, Mapping
from enum import Enum
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from warp_softbody.errors import InputError
from warp_softbody.inputs.checks import plain, refuse, several, shown, vector

IntArray = npt.NDArray[np.int32]
Member = TypeVar("Member", bound=Enum)

LONGEST_NAME = 200
"""Bytes of a name in UTF-8, or of each of its parts between dots: of a body and its region."""

LONGEST_CHOICE = 20
"""Characters of an enumeration's values beyond which sentences list its names."""


def node_set(label: str, value: object, count: int) -> IntArray:
    """Ascending node indices (k,) int32 out of ``count`` nodes; one named twice counts once.

    Args:
        label: what the sentence calls it.
        value: indices in any order, or a mask of ``count`` truth values that marks the nodes, which
            may be of any type: zeros and ones, as many as there are nodes, are no indices.
        count: nodes of the mesh.

    Raises:
        InputError: neither indices nor a mask of that length, or an index out of range.
    """
    wanted = f"node indices from 0 to {count - 1}, or {count} truth values that mark nodes"
    try:
        given = np.asarray(list(value) if isinstance(value, set | frozenset | range) else value)
    except Exception:
        refuse(label, wanted, value)
    if given.dtype == object and all(isinstance(item, bool | np.bool_) for item in given.flat):
        given = given.astype(bool)
    if given.shape == (count,) and _is_mask(given):
        nodes = np.flatnonzero(given)
    elif given.ndim != 1 or given.dtype.kind not in "iuf":
        refuse(label, wanted, value)
    else:
        if given.size:
            wrong = np.flatnonzero(~((given >= 0) & (given < count) & (given == np.floor(given))))
            if wrong.size:
                raise InputError(f"{label} must be {wanted}, but it holds {given[wrong[0]]}")
        nodes = np.unique(given)
    result = nodes.astype(np.int32)
    result.setflags(write=False)
    return result


def _is_mask(given: npt.NDArray[Any]) -> bool:
    """Whether an array of the length of a mask is one; three nodes or more cannot all be 0 or 1."""
    if given.dtype.kind == "b":
        return True
    marks = given.dtype.kind in "iuf" and len(given) > 2
    return bool(marks and np.isin(given, (0, 1)).all())


def text(label: str, value: object) -> str:
    """Any text that UTF-8 can hold."""
    if not isinstance(value, str):
        refuse(label, "a text", value)
    try:
        value.encode("utf-8")
    except UnicodeEncodeError:
        refuse(label, "a text that UTF-8 can hold", value)
    return value


def name(label: str, value: object) -> str:
    """A text that can name a thing in a file: not empty, UTF-8, printable, not too long."""
    if type(value) is str and _is_name(value):
        return value
    given = text(label, plain(value))
    if not given.strip():
        refuse(label, "a text that is not empty", value)
    parts = [part.encode("utf-8") for part in given.split(".")]
    if not given.isprintable():
        refuse(label, "a text of printable characters", value)
    longest = max(len(part) for part in parts)
    if longest > LONGEST_NAME:
        raise InputError(
            f"{label} must have at most {LONGEST_NAME} bytes in UTF-8, "
            f"not the {longest} of {shown(given)}"
        )
    return given


@lru_cache(maxsize=1024)
def _is_name(given: str) -> bool:
    """Whether `name` takes a text; kept, as controllers name the same things in every step."""
    try:
        longest = max(len(part.encode("utf-8")) for part in given.split("."))
    except UnicodeEncodeError:
        return False
    return bool(given.strip()) and given.isprintable() and longest <= LONGEST_NAME


def identifier(label: str, value: object) -> str:
    """A name that a prim of a stage can have: letters, digits and underscores."""
    given = name(label, value)
    if not given.isidentifier():
        refuse(label, "an identifier of letters, digits and underscores", value)
    return given


def names(label: str, value: object) -> tuple[str, ...]:
    """Several names; a single text is none."""
    given = several(label, value, "a tuple of names")
    return tuple(name(f"{label}[{i}]", item) for i, item in enumerate(given))


def distinct(label: str, given: Iterable[str]) -> None:
    """Refuse names of which two are equal."""
    seen: set[str] = set()
    for item in given:
        if item in seen:
            raise InputError(f"two {label} have the name {item!r}")
        seen.add(item)


def color(label: str, value: object) -> tuple[float, float, float]:
    """Red, green and blue, each from 0 to 1."""
    wanted = "three numbers from 0 to 1 (linear red, green, blue)"
    try:
        red, green, blue = vector(label, value)
    except InputError:
        refuse(label, wanted, value)
    if not 0.0 <= min(red, green, blue) <= max(red, green, blue) <= 1.0:
        refuse(label, wanted, value)
    return red, green, blue


def mapping(label: str, value: object) -> Mapping[Any, Any]:
    """Things by name."""
    if not isinstance(value, Mapping):
        refuse(label, "a dictionary", value)
    return value


def path(label: str, value: object) -> Path:
    """A path that the file system can hold, whether or not anything stands there."""
    given = os.fspath(value) if isinstance(value, os.PathLike) else value
    if not isinstance(given, str) or not given:
        refuse(label, "the path of a file", value)
    try:
        os.lstat(given)
    except ValueError:
        refuse(label, "a path that the file system can hold", value)
    except OSError as error:
        if error.errno == errno.ENAMETOOLONG:
            refuse(label, "a path that is not too long for the file system", value)
    return Path(given)


def member(label: str, value: object, kind: type[Member]) -> Member:
    """A member of an enumeration, or its value."""
    if isinstance(value, kind):
        return value
    for option in kind:
        if type(value) is type(option.value) and value == option.value:
            return option
    texts = [str(option.value) for option in kind]
    if max(map(len, texts)) > LONGEST_CHOICE:
        texts = [option.name for option in kind]
    refuse(label, f"one of {', '.join(texts)}", value)


def controller(label: str, value: object) -> Any:
    """An object with a method ``goals(view)``."""
    if isinstance(value, type):
        raise InputError(
            f"{label} must be a controller, not the class {value.__name__}: make one of it by "
            f"{value.__name__}(...)"
        )
    if not callable(getattr(value, "goals", None)):
        refuse(label, "an object with a method goals(view)", value)
    return value
