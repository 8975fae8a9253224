"""Kinds of option values.

Each checks what Python gives, reads what a command line gives, and says in words what it takes.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Any, Protocol

from warp_softbody.inputs import checks


class OptionKind(Protocol):
    """What values an option takes."""

    def check(self, label: str, value: object) -> Any:
        """The value in its plain type.

        Raises:
            InputError: it is none of these values; the sentence begins with the label.
        """

    def read(self, text: str) -> object:
        """What a text of the command line stands for, yet to be checked."""

    @property
    def range(self) -> str:
        """The values in a few words, for help and tables."""


@dataclass(frozen=True, kw_only=True)
class NumberKind:
    """A finite number, from ``low`` to ``high`` and between ``above`` and ``below``."""

    low: float = -checks.LARGEST
    high: float = checks.LARGEST
    above: float = -math.inf
    below: float = math.inf
    unit: str = ""

    def check(self, label: str, value: object) -> float:
        """The number as a float."""
        return checks.number(
            label,
            value,
            low=self.low,
            high=self.high,
            above=self.above,
            below=self.below,
            unit=self.unit,
        )

    def read(self, text: str) -> object:
        """A float, or the text where it is no number."""
        try:
            return float(text)
        except ValueError:
            return text

    @property
    def range(self) -> str:
        """Its ends."""
        ends = []
        if self.low > -checks.LARGEST and self.high < checks.LARGEST:
            ends.append(f"{self.low:g} to {self.high:g}")
        elif self.low > -checks.LARGEST:
            ends.append(f"at least {self.low:g}")
        if math.isfinite(self.above):
            ends.append(f"above {self.above:g}")
        if math.isfinite(self.below):
            ends.append(f"below {self.below:g}")
        return " and ".join(ends)


@dataclass(frozen=True, kw_only=True)
class WholeKind:
    """A whole number from ``low`` to ``high``; None for no upper end."""

    low: int
    high: int | None = None

    def check(self, label: str, value: object) -> int:
        """The number as an int."""
        if self.high is None:
            return checks.whole(label, value, low=self.low)
        return checks.whole(label, value, low=self.low, high=self.high)

    def read(self, text: str) -> object:
        """An int, or the text where it is no whole number."""
        return int(text) if text.isdecimal() else text

    @property
    def range(self) -> str:
        """Its ends."""
        return f"at least {self.low}" if self.high is None else f"{self.low} to {self.high}"


@dataclass(frozen=True)
class ChoiceKind:
    """One of a few known values, which are all texts or all whole numbers."""

    known: tuple[str | int, ...]

    def check(self, label: str, value: object) -> str | int:
        """The known value that is equal."""
        return checks.choice(label, value, self.known)

    def read(self, text: str) -> object:
        """The known value that is written so, or the text where none is."""
        return {str(value): value for value in self.known}.get(text, text)

    @property
    def range(self) -> str:
        """The values."""
        return ", ".join(str(value) for value in self.known)


@dataclass(frozen=True)
class TruthKind:
    """True or False."""

    def check(self, label: str, value: object) -> bool:
        """The value as a bool."""
        return checks.truth(label, value)

    def read(self, text: str) -> object:
        """True or False, or the text where it is neither."""
        return {"true": True, "false": False}.get(text.lower(), text)

    @property
    def range(self) -> str:
        """Both."""
        return "on, off"


@dataclass(frozen=True, kw_only=True)
class TextKind:
    """A text of a pattern; ``wanted`` says in words which texts these are."""

    pattern: re.Pattern[str]
    wanted: str

    def check(self, label: str, value: object) -> str:
        """The text."""
        if not (isinstance(value, str) and self.pattern.fullmatch(value)):
            checks.refuse(label, self.wanted, value)
        return value

    def read(self, text: str) -> object:
        """The text."""
        return text

    @property
    def range(self) -> str:
        """In words."""
        return self.wanted
