"""Tables of a scene file: what is asked for is taken, the rest refused with its line."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Any, NoReturn

from warp_softbody.errors import InputError, SoftBodyError
from warp_softbody.inputs import checks
from warp_softbody.scene_files.toml_lines import Place, lines_of

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

MOST_BYTES = 2**28
"""Of a scene file."""


@dataclass(frozen=True)
class TextSource:
    """Where tables come from.

    Attributes:
        path: of the file; what it names lies beside it.
        lines: of all keys.
    """

    path: Path
    lines: Mapping[Place, int]


class Table:
    """One table of a file, at a place in it."""

    def __init__(self, values: Mapping[str, Any], place: Place, source: TextSource) -> None:
        """Of values that are plain: numbers, texts, lists and dictionaries."""
        self._values = values
        self.place = place
        self.source = source

    def __contains__(self, key: str) -> bool:
        """Whether there is a key."""
        return key in self._values

    def __iter__(self) -> Iterator[str]:
        """The keys in their order."""
        return iter(self._values)

    def only(self, known: Iterable[str]) -> None:
        """Refuse keys that are not known.

        Raises:
            InputError: with the line, and the nearest right name.
        """
        names = list(known)
        for key in self._values:
            if key not in names:
                close = get_close_matches(key, names, n=1, cutoff=0.6)
                meant = f"did you mean {close[0]!r}? " if close else ""
                self.fail(f"there is no key {key!r}; {meant}known: {', '.join(names)}", key)

    def take(self, key: str, default: Any = None) -> Any:
        """The value of a key: numbers, texts, lists as tuples."""
        return _frozen(self._values.get(key, default))

    def needed(self, key: str) -> Any:
        """The value of a key that has to be there."""
        if key not in self._values:
            self.fail(f"the key {key!r} is missing")
        return self.take(key)

    def text(self, key: str, default: str | None = None) -> Any:
        """A text."""
        value = self.take(key, default)
        if value is not default and not isinstance(value, str):
            self.fail(f"must be a text, not {checks.shown(value)}", key)
        return value

    def choice(self, key: str, known: Iterable[str]) -> str:
        """One of several names, which has to be there."""
        names, value = list(known), self.needed(key)
        if value not in names:
            close = get_close_matches(str(value), names, n=1, cutoff=0.6)
            meant = f"did you mean {close[0]!r}? " if close else ""
            self.fail(f"there is no {checks.shown(value)}; {meant}known: {', '.join(names)}", key)
        return str(value)

    def table(self, key: str) -> Table:
        """The table of a key, an empty one where there is none."""
        value = self._values.get(key, {})
        if not isinstance(value, Mapping):
            self.fail(f"must be a table, not {checks.shown(value)}", key)
        return Table(value, (*self.place, key), self.source)

    def tables(self, key: str) -> list[Table]:
        """The tables of an array of tables."""
        value = self._values.get(key, [])
        if not isinstance(value, list) or not all(isinstance(item, Mapping) for item in value):
            self.fail(f"must be an array of tables, as [[{key}]]", key)
        place = (*self.place, key)
        return [Table(item, (*place, i), self.source) for i, item in enumerate(value)]

    def is_table(self, key: str) -> bool:
        """Whether the value of a key is a table."""
        return isinstance(self._values.get(key), Mapping)

    def path(self, key: str) -> Path:
        """A path that is given beside the file."""
        given: str = self.text(key)
        return self.source.path.parent / given

    def fail(self, message: str, key: str | None = None) -> NoReturn:
        """Raise the sentence with file, line and field."""
        place = self.place if key is None else (*self.place, key)
        raise InputError(f"{self._where(place)}{message}")

    @contextmanager
    def explained(self, key: str | None = None, *, named: bool = False) -> Iterator[None]:
        """Tell file, line and field of what a record refuses of this table's values.

        The field is ``key``, or the first of the keys that the sentence names. With ``named`` what
        names none of them is left to others.
        """
        try:
            yield
        except SoftBodyError as error:
            message = str(error)
            if message.startswith(f"{self.source.path}:"):
                raise
            keys = self._values if key is None else ()
            found = [name for name in keys if re.search(rf"\b{re.escape(name)}\b", message)]
            # sentences begin with class and field
            found.sort(key=lambda name: message.find(name))
            found += [] if key is None else [key]
            if named and not found:
                raise
            place = (*self.place, found[0]) if found else self.place
            raise InputError(f"{self._where(place)}{message}") from error

    def _where(self, place: Place) -> str:
        known = place
        while known not in self.source.lines:
            known = known[:-1]
        field = ""
        for part in place:
            field += f"[{part}]" if isinstance(part, int) else f".{part}" if field else str(part)
        return f"{self.source.path}:{self.source.lines[known]}: {field}{': ' if field else ''}"


def read_tables(path: Path) -> Table:
    """The outermost table of a file.

    Raises:
        InputError: it is missing, no UTF-8 text, or no TOML, with the line.
    """
    try:
        if path.stat().st_size > MOST_BYTES:
            raise InputError(f"{path}: it is larger than {MOST_BYTES} bytes")
        # with or without a mark of the byte order
        text = path.read_text(encoding="utf-8-sig")
        values = tomllib.loads(text)
    except FileNotFoundError as error:
        raise InputError(f"{path}: there is no such file") from error
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror or error}") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: it is no text in UTF-8") from error
    except tomllib.TOMLDecodeError as error:
        raise InputError(_no_toml(path, text, str(error))) from error
    except RecursionError as error:
        raise InputError(f"{path}: its arrays are nested too deeply") from error
    return Table(values, (), TextSource(path, lines_of(text)))


def _no_toml(path: Path, text: str, message: str) -> str:
    """What the library says, with the line itself, which has the key."""
    found = re.search(r"\(at line (\d+)", message)
    lines = text.splitlines()
    if found is None or not 0 < int(found[1]) <= len(lines):
        return f"{path}:{max(len(lines), 1)}: it is no TOML: {message}"
    number = int(found[1])
    return f"{path}:{number}: it is no TOML: {message}: {checks.shown(lines[number - 1].strip())}"


def _frozen(value: Any) -> Any:
    return tuple(_frozen(item) for item in value) if isinstance(value, list) else value
