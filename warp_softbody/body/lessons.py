"""What a character has learnt, kept in its file: gains by the motion that they are of."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from zipfile import ZIP_DEFLATED, ZipFile

from warp_softbody.atomic_files import replacing
from warp_softbody.body.character_files import load_character, put_entry, read_entries
from warp_softbody.errors import InputError, OutputError

ENTRY = "lessons.json"
"""In the archive, beside the character, who is read without it."""

Lesson = Mapping[str, float]
"""Gains by their paths, as ``activation.effort`` or ``launch.0``."""


def read_lessons(path: Path) -> dict[str, Lesson]:
    """What the character of a file has learnt, by the motion's name; {} where it was not taught.

    Raises:
        InputError: the file is missing or is no character's, or its lessons are none.
    """
    text = read_entries(path).get(ENTRY)
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


def write_lesson(path: Path, do: str, gains: Lesson) -> None:
    """Add what a character has learnt to its file, in place of what it knew of that motion.

    Raises:
        InputError: the file is missing, or is no character's.
        OutputError: it cannot be written.
    """
    load_character(path)
    lessons = {**read_lessons(path), do: dict(gains)}
    entries = {**read_entries(path), ENTRY: json.dumps(lessons, sort_keys=True).encode()}
    try:
        with replacing(path) as new, ZipFile(new, "w", ZIP_DEFLATED) as archive:
            for name, data in entries.items():
                put_entry(archive, name, data)
    except OSError as error:
        raise OutputError(f"{path}: cannot be written: {error.strerror or error}") from error
