"""Records that hold arrays compare, hash, copy and print as Python objects should."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

Kind = TypeVar("Kind")

SHORT = 6
"""Items of a tuple beyond which only their number is shown."""


class Value:
    """Base of dataclasses with arrays: ``==`` compares what they hold, copies are made anew.

    Pickles and deep copies hold the fields alone and are built by the constructor, so that they are
    checked and read-only like the original. Such a record has no hash, see `FrozenValue`.
    """

    def __eq__(self, other: object) -> bool:
        """Whether both are of one class and all fields are equal, arrays to the last bit."""
        if self is other:
            return True
        if type(self) is not type(other):
            return NotImplemented
        return all(
            same(getattr(self, name), getattr(other, name)) for name in _field_names(type(self))
        )

    if not TYPE_CHECKING:
        __hash__ = None

    def __reduce__(self) -> tuple[Callable[..., Any], tuple[Any, ...]]:
        """The class and its fields."""
        held = {name: getattr(self, name) for name in _field_names(type(self))}
        return _made, (type(self), {name: _movable(value) for name, value in held.items()})

    def __repr__(self) -> str:
        """The fields in a few words each."""
        parts = (f"{name}={brief(getattr(self, name))}" for name in _field_names(type(self)))
        return f"{type(self).__name__}({', '.join(parts)})"


def unchecked(kind: type[Kind], **values: Any) -> Kind:
    """A record of a frozen dataclass without the checks of its constructor.

    For what a step makes again and again out of values that were checked before or that it made
    itself. All fields have to be given.
    """
    record = object.__new__(kind)
    record.__dict__.update(values)
    return record


def unchecked_copy(record: Kind, **values: Any) -> Kind:
    """A record like another, with some fields changed, and without checks."""
    held = {name: getattr(record, name) for name in _field_names(type(record))}
    return unchecked(type(record), **(held | values))


class FrozenValue(Value):
    """A `Value` whose arrays are read-only, so that it can stand in sets and as a key."""

    def __hash__(self) -> int:
        """Of all fields, kept for the next time."""
        known: int | None = self.__dict__.get("_hash")
        if known is None:
            known = hash((type(self).__name__, *map(_hashable, self._held())))
            self.__dict__["_hash"] = known
        return known

    def _held(self) -> tuple[Any, ...]:
        return tuple(getattr(self, name) for name in _field_names(type(self)))


def same(one: object, other: object) -> bool:
    """Whether two field values are equal; NaN is equal to NaN within arrays and as a number."""
    if one is other:
        return True
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return _same_arrays(np.asarray(one), np.asarray(other))
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        return one.keys() == other.keys() and all(same(one[key], other[key]) for key in one)
    if isinstance(one, tuple) and isinstance(other, tuple):
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, float) and isinstance(other, float) and one != one:
        return other != other
    return bool(one == other)


def _same_arrays(one: np.ndarray[Any, Any], other: np.ndarray[Any, Any]) -> bool:
    if one.shape != other.shape:
        return False
    floats = one.dtype.kind in "fc" and other.dtype.kind in "fc"
    return bool(np.array_equal(one, other, equal_nan=floats))


def brief(value: object) -> str:
    """A field value in a few words."""
    if isinstance(value, np.ndarray):
        return f"<{value.dtype} {'x'.join(map(str, value.shape)) or 'number'}>"
    if isinstance(value, Mapping):
        return f"<{len(value)} by name: {_first(value)}>"
    if isinstance(value, tuple) and (len(value) > SHORT or any(map(is_dataclass, value))):
        return f"<{len(value)} {type(value[0]).__name__}>"
    return repr(value)


def _first(mapping: Mapping[Any, Any]) -> str:
    keys = [str(key) for key in mapping]
    return ", ".join(keys[:SHORT]) + (", ..." if len(keys) > SHORT else "")


_names: dict[Any, tuple[str, ...]] = {}


def _field_names(kind: type[Any]) -> tuple[str, ...]:
    found = _names.get(kind)
    if found is None:
        found = _names[kind] = tuple(entry.name for entry in fields(kind) if entry.init)
    return found


def _made(kind: type[Any], held: dict[str, Any]) -> Any:
    return kind(**held)


def _movable(value: object) -> object:
    """Read-only mappings cannot be pickled; the constructor makes them anew."""
    return dict(value) if isinstance(value, Mapping) else value


def _hashable(value: object) -> object:
    if isinstance(value, np.ndarray):
        # zero and minus zero are equal
        return value.shape, (value + 0 if value.dtype.kind == "f" else value).tobytes()
    if isinstance(value, Mapping):
        return tuple(sorted((str(key), _hashable(item)) for key, item in value.items()))
    if isinstance(value, tuple):
        return tuple(map(_hashable, value))
    return value
