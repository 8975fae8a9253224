"""Values as TOML: small tables that people read, numbers that come back to the last bit."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping
from enum import Enum
from typing import Any

import numpy as np

WIDTH = 100
"""Columns beyond which the items of an array stand in lines of their own."""


def toml_text(values: Mapping[str, Any]) -> str:
    """A whole text; dictionaries become tables, and lists of dictionaries arrays of tables."""
    return "\n".join(_lines(values, ())).strip("\n") + "\n"


def _lines(values: Mapping[str, Any], place: tuple[str, ...]) -> Iterable[str]:
    tables = {key: value for key, value in values.items() if _is_table(value)}
    for key, value in values.items():
        if key not in tables:
            yield f"{_key(key)} = {_value(value, len(key) + 3)}"
    for key, value in tables.items():
        name = ".".join(map(_key, (*place, key)))
        items = [value] if isinstance(value, Mapping) else value
        left, right = ("[", "]") if isinstance(value, Mapping) else ("[[", "]]")
        for item in items:
            yield ""
            yield f"{left}{name}{right}"
            yield from _lines(item, (*place, key))


def _is_table(value: object) -> bool:
    if isinstance(value, list | tuple):
        return bool(value) and all(isinstance(item, Mapping) for item in value)
    return isinstance(value, Mapping)


def _key(key: str) -> str:
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else json.dumps(key, ensure_ascii=False)


def _value(value: Any, indent: int = 0) -> str:
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, Enum):
        value = value.value
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{_key(k)} = {_value(v)}' for k, v in value.items())}}}"
    if isinstance(value, list | tuple):
        items = [_value(item) for item in value]
        short = f"[{', '.join(items)}]"
        if indent + len(short) <= WIDTH:
            return short
        return "[\n" + "".join(f"    {line},\n" for line in _filled(items)) + "]"
    # repr gives the shortest digits that come back to the same bits
    return repr(value)


def _filled(items: list[str]) -> Iterable[str]:
    """Items in lines that are not too long."""
    line = ""
    for item in items:
        if line and len(line) + len(item) > WIDTH - 8:
            yield line
            line = ""
        line = f"{line}, {item}" if line else item
    yield line
