"""Frozen records of the package and their tables: a key for each field."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import MISSING, Field, fields, is_dataclass
from typing import Any, TypeVar

from warp_softbody.inputs.records import same
from warp_softbody.scene_files.tables import Table

Record = TypeVar("Record")


def record_of(
    kind: type[Record], table: Table, /, *, also: Iterable[str] = (), **given: Any
) -> Record:
    """A record whose fields are the keys of a table; fields that are records are tables.

    Args:
        kind: a dataclass.
        table: what it is made of.
        also: keys of the table that are no fields, and are read elsewhere.
        given: fields that are no keys.

    Raises:
        InputError: with file, line and field.
    """
    known = [entry for entry in fields(kind) if entry.init and entry.name not in given]  # type: ignore[arg-type]
    table.only([*(entry.name for entry in known), *also])
    values = {entry.name: _value(entry, table) for entry in known if entry.name in table}
    for entry in known:
        if entry.name not in table and _default(entry) is MISSING:
            table.fail(f"the key {entry.name!r} is missing")
    with table.explained():
        return kind(**values, **given)


def changed(record: Record, table: Table) -> Record:
    """A record like another one, but for the fields that are keys of a table."""
    names = [entry.name for entry in fields(record) if entry.init]  # type: ignore[arg-type]
    rest = {name: getattr(record, name) for name in names if name not in table}
    table.only(names)
    return record_of(type(record), table, **rest)


def _default(entry: Field[Any]) -> Any:
    if entry.default_factory is not MISSING:
        return entry.default_factory()
    return entry.default


def _value(entry: Field[Any], table: Table) -> Any:
    default = _default(entry)
    if is_dataclass(default) and not isinstance(default, type):
        return changed(default, table.table(entry.name))
    return table.take(entry.name)


def table_of(
    record: object, *, base: object = None, without: Iterable[str] = (), whole: bool = False
) -> dict[str, Any]:
    """The fields of a record that differ from those of ``base``, or from their defaults, by name.

    With ``whole`` all fields that have a value.
    """
    left_out = set(without)
    found: dict[str, Any] = {}
    for entry in fields(record):  # type: ignore[arg-type]
        value = getattr(record, entry.name)
        if not entry.init or entry.name in left_out or value is None:
            continue
        usual = _default(entry) if base is None else getattr(base, entry.name)
        if whole or not same(value, usual):
            nested = is_dataclass(value) and not isinstance(value, type)
            found[entry.name] = table_of(value, base=usual) if nested else value
    return found
