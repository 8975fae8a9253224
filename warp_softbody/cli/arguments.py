"""The parser answers a mistake with one sentence and reads the kinds of values of options."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from typing import Any, NoReturn

from warp_softbody.cli.output import say
from warp_softbody.errors import InputError


class Parser(argparse.ArgumentParser):
    """An argument parser whose errors are InputErrors, and that takes no abbreviations."""

    def __init__(self, **keywords: Any) -> None:
        """Make a parser; subparsers are made in the same way."""
        super().__init__(**{**keywords, "allow_abbrev": False})

    def _print_message(self, message: str, file: Any = None) -> None:
        """Print help and version as everything else."""
        say(message.rstrip("\n"))

    def error(self, message: str) -> NoReturn:
        """Raise what argparse would print below the usage."""
        raise InputError(message.removeprefix("argument "))


def number(low: float, high: float, unit: str = "") -> Callable[[str], float]:
    """A reader of numbers from ``low`` to ``high``."""

    def read(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = float("nan")
        if not low <= value <= high:
            between = f"a number from {low:g} to {high:g}{unit and ' '}{unit}"
            raise argparse.ArgumentTypeError(f"must be {between}, got {text!r}")
        return value

    return read


def whole(low: int, high: int) -> Callable[[str], int]:
    """A reader of whole numbers from ``low`` to ``high``."""

    def read(text: str) -> int:
        if not (text.isdecimal() and low <= int(text) <= high):
            between = f"a whole number from {low} to {high}"
            raise argparse.ArgumentTypeError(f"must be {between}, got {text!r}")
        return int(text)

    return read


def key_value(text: str) -> tuple[str, str]:
    """A reader of ``key=value``."""
    key, equals, value = text.partition("=")
    if not (key.strip() and equals):
        raise argparse.ArgumentTypeError(f"must be key=value, got {text!r}")
    return key.strip(), value.strip()


def unique(pairs: list[tuple[str, str]], option: str) -> dict[str, str]:
    """A dictionary of pairs that name no key twice."""
    values: dict[str, str] = {}
    for key, value in pairs:
        if key in values:
            raise InputError(f"{option} gives {key!r} twice: {values[key]!r} and {value!r}")
        values[key] = value
    return values


def camera(text: str) -> str | tuple[float, ...]:
    """A reader of ``follow``, ``still``, or a place ``x,y,z``."""
    if text in ("follow", "still"):
        return text
    try:
        place = tuple(float(part) for part in text.split(","))
    except ValueError:
        place = ()
    if len(place) != 3 or not all(map(math.isfinite, place)):
        wanted = "follow, still or a place X,Y,Z in m"
        raise argparse.ArgumentTypeError(f"must be {wanted}, got {text!r}")
    return place


def size(text: str) -> tuple[int, int]:
    """A reader of ``WIDTHxHEIGHT``, pixels."""
    width, by, height = text.lower().partition("x")
    if not (by and width.isdecimal() and height.isdecimal()):
        raise argparse.ArgumentTypeError(f"must be WIDTHxHEIGHT, as 1280x720, got {text!r}")
    return int(width), int(height)
