"""In which line of a TOML text each key stands, which the library that reads TOML does not tell."""

from __future__ import annotations

from typing import TypeAlias

Place: TypeAlias = tuple[str | int, ...]
"""Names of tables and keys on the way to a value; numbers within arrays."""


def lines_of(text: str) -> dict[Place, int]:
    """The line, from 1, of every table, key and item of a text that is valid TOML."""
    return _Scanner(text).scan()


class _Scanner:
    """Walks through a text once; what it is at is told by the first characters."""

    def __init__(self, text: str) -> None:
        self._text = text + "\n"
        self._at = 0
        self._line = 1
        self._lines: dict[Place, int] = {(): 1}
        self._counts: dict[Place, int] = {}

    def scan(self) -> dict[Place, int]:
        table: Place = ()
        while self._skip(blank=" \t\r\n"):
            if self._peek() == "[":
                table = self._header()
            else:
                self._pair(table)
        return self._lines

    def _peek(self) -> str:
        return self._text[self._at : self._at + 1]

    def _next(self, count: int = 1) -> None:
        self._line += self._text.count("\n", self._at, self._at + count)
        self._at += count

    def _skip(self, blank: str) -> bool:
        """Pass blanks and comments; whether anything is left."""
        while self._at < len(self._text):
            if self._peek() == "#":
                self._next(self._text.index("\n", self._at) - self._at)
            elif self._peek() in blank:
                self._next()
            else:
                return True
        return False

    def _header(self) -> Place:
        line = self._line
        several = self._text.startswith("[[", self._at)
        self._next(2 if several else 1)
        place = self._current(self._key(end="]"))
        self._next(2 if several else 1)
        if several:
            self._counts[place] = self._counts.get(place, -1) + 1
            self._lines.setdefault(place, line)
            place = (*place, self._counts[place])
        self._lines[place] = line
        return place

    def _current(self, names: Place) -> Place:
        """A place with the number of the last item after each array of tables on the way."""
        place: Place = ()
        for name in names[:-1]:
            place = (*place, name)
            if place in self._counts:
                place = (*place, self._counts[place])
        return (*place, *names[-1:])

    def _key(self, end: str) -> Place:
        """The parts of a dotted key, up to a character that ends it."""
        parts: list[str | int] = []
        while self._skip(blank=" \t") and self._peek() != end:
            if self._peek() == ".":
                self._next()
            elif self._peek() in "\"'":
                parts.append(self._string()[1:-1])
            else:
                start = self._at
                while self._peek() not in f'.{end} \t"':
                    self._next()
                parts.append(self._text[start : self._at])
        return tuple(parts)

    def _pair(self, table: Place) -> None:
        line = self._line
        place = table
        for name in self._key(end="="):
            place = (*place, name)
            self._lines.setdefault(place, line)
        self._next()
        self._value(place)

    def _value(self, place: Place) -> None:
        self._skip(blank=" \t")
        if self._peek() == "[":
            self._items(place)
        elif self._peek() == "{":
            self._inline(place)
        elif self._peek() in "\"'":
            self._string()
        else:
            while self._peek() not in ",]}#\n":
                self._next()

    def _items(self, place: Place) -> None:
        self._next()
        number = 0
        while self._skip(blank=" \t\r\n,") and self._peek() != "]":
            item: Place = (*place, number)
            self._lines[item] = self._line
            self._value(item)
            number += 1
        self._next()

    def _inline(self, place: Place) -> None:
        self._next()
        while self._skip(blank=" \t\r\n,") and self._peek() != "}":
            self._pair(place)
        self._next()

    def _string(self) -> str:
        quote = self._peek()
        mark = quote * 3 if self._text.startswith(quote * 3, self._at) else quote
        start = self._at
        self._next(len(mark))
        while not self._text.startswith(mark, self._at):
            self._next(2 if quote == '"' and self._peek() == "\\" else 1)
        self._next(len(mark))
        while len(mark) == 3 and self._peek() == quote:
            # up to two quotes may stand before those that end it
            self._next()
        return self._text[start : self._at]
