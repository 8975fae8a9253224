"""Gains with some of their numbers replaced, each by the path of its field."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any, TypeVar

from warp_softbody.errors import InputError

Gains = TypeVar("Gains")


def with_numbers(gains: Gains, numbers: Mapping[str, float]) -> Gains:
    """Gains with numbers at paths, as ``activation.effort`` or ``launch.0``.

    Raises:
        InputError: there is no such field, or it cannot have that number.
    """
    changed: Any = gains
    for path, number in numbers.items():
        changed = _changed(changed, path.split("."), number, f"{type(gains).__name__}.{path}")
    found: Gains = changed
    return found


def number_at(gains: object, path: str) -> float:
    """The number at a path."""
    value: Any = gains
    for name in path.split("."):
        value = value[int(name)] if isinstance(value, tuple) else getattr(value, name)
    return float(value)


def _changed(values: Any, path: list[str], number: float, label: str) -> Any:
    name, *rest = path
    if isinstance(values, tuple):
        if not (name.isdecimal() and int(name) < len(values)) or rest:
            raise InputError(f"there is no gain {label}")
        place = int(name)
        return (*values[:place], number, *values[place + 1 :])
    if not is_dataclass(values) or name not in [entry.name for entry in fields(values)]:
        raise InputError(f"there is no gain {label}")
    inner = _changed(getattr(values, name), rest, number, label) if rest else number
    return replace(values, **{name: inner})  # type: ignore[type-var]
