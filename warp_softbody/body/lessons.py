"""What a character has learnt, kept in its file: gains by the motion that they are of."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from warp_softbody.body.character_files import (
    LESSONS,
    body_of,
    load_character,
    read_entries,
    write_entries,
)
from warp_softbody.errors import InputError

Lesson = Mapping[str, float]
"""Gains by their paths, as ``activation.effort`` or ``launch.0``."""


def read_lessons(path: Path) -> dict[str, Lesson]:
    """What the character of a file has learnt, by the motion's name; {} where it was not taught.

    Raises:
        InputError: the file is missing or is no character's, or its lessons are none.
    """
    return _lessons(path, read_entries(path))


def _lessons(path: Path, entries: Mapping[str, bytes]) -> dict[str, Lesson]:
    text = entries.get(LESSONS)
    if text is None:
        return {}
    try:
        found = json.loads(text)
        return {str(do): _checked(gains) for do, gains in found.items()}
    except (ValueError, TypeError, AttributeError, RecursionError) as error:
        raise InputError(f"{path}: its lessons are damaged: {error}") from error


def _checked(gains: Any) -> Lesson:
    numbers = {str(name): float(value) for name, value in gains.items()}
    if not all(map(math.isfinite, numbers.values())):
        raise ValueError("a gain is not finite")
    return numbers


def read_body(path: Path) -> str:
    """A text that is the same for files of the same body, whatever they have learnt.

    Raises:
        InputError: the file is missing, or is no character's.
    """
    load_character(path)
    return body_of(read_entries(path))


def write_lesson(path: Path, do: str, gains: Lesson, body: str | None = None) -> None:
    """Add what a character has learnt to its file, in place of what it knew of that motion.

    Args:
        path: of the file.
        do: the motion.
        gains: by path.
        body: the one that learnt them, as `read_body` told it; None for that of the file.

    Raises:
        InputError: the file is missing, is no character's, or is of another body by now.
        OutputError: it cannot be written.
    """
    load_character(path)
    entries = read_entries(path)
    if body is not None and body_of(entries) != body:
        raise InputError(
            f"{path}: it holds another body than the one that was taught, so that its gains are "
            "not written into it"
        )
    lessons = {**_lessons(path, entries), do: dict(gains)}
    text = json.dumps(lessons, sort_keys=True).encode()
    write_entries(path, {**entries, LESSONS: text})
