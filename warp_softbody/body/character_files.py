"""A character in one file (`NAME.char`): a zip archive of one JSON text and NumPy arrays.

Nothing in it is run, and what it holds is checked as if it were given in Python. The same character
gives the same bytes; what the file that it replaces was taught is kept, if that has the same body.
"""

from __future__ import annotations

import hashlib
import io
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from zipfile import ZIP_DEFLATED, BadZipFile, ZipFile, ZipInfo

import numpy as np

from warp_softbody.atomic_files import replacing
from warp_softbody.body.character_contents import Array, Arrays, Kept, arguments, described
from warp_softbody.errors import InputError, OutputError, SoftBodyError

EXTENSION = ".char"
FORMAT, VERSION = "warp_softbody character", 1
TEXT = "character.json"
LESSONS = "lessons.json"
"""What the character has learnt (`lessons.py`); who it is is read without it."""

LOOKS = ("name", "color", "skin")
"""Of the text: nothing that a body moves by."""

MOST_BYTES = 2**30
"""Of all that is read of one file, unpacked."""

BEGINNING_OF_TIME = (1980, 1, 1, 0, 0, 0)
"""Of every entry, so that the time of writing is no part of the file."""


def save_character(character: Kept, path: Path) -> None:
    """Write a character whole or not at all.

    Over a file of the same body (`body_of`), what that has learnt is kept.

    Raises:
        InputError: the path does not end in .char.
        OutputError: the folder cannot be written in.
    """
    _check_extension(path)
    arrays: dict[str, Array] = {}

    def stored(array: Array) -> str:
        name = f"array_{len(arrays)}.npy"
        arrays[name] = np.ascontiguousarray(array)
        return name

    text = json.dumps({"format": FORMAT, "version": VERSION, **described(character, stored)})
    entries = {TEXT: text.encode()}
    for name, array in arrays.items():
        data = io.BytesIO()
        np.lib.format.write_array(data, array, allow_pickle=False)
        entries[name] = data.getvalue()
    write_entries(path, {**entries, **_lessons_kept(path, entries)})


def write_entries(path: Path, entries: Mapping[str, bytes]) -> None:
    """Write a character's file of its entries by name, whole or not at all.

    Raises:
        OutputError: the folder cannot be written in.
    """
    try:
        with replacing(path) as new, ZipFile(new, "w", ZIP_DEFLATED) as archive:
            for name, data in entries.items():
                _put_entry(archive, name, data)
    except OSError as error:
        raise OutputError(f"{path}: cannot be written: {error.strerror or error}") from error


def body_of(entries: Mapping[str, bytes]) -> str:
    """A text that is the same for files of the same body, whatever it looks like or has learnt.

    Raises:
        ValueError, KeyError, TypeError: the entries are no character's.
    """

    def resolved(value: Any) -> Any:
        if isinstance(value, dict):
            return {name: resolved(own) for name, own in value.items()}
        if isinstance(value, list):
            return [resolved(own) for own in value]
        # an array's name tells only in which order it was stored
        held = isinstance(value, str) and value in entries
        return hashlib.sha256(entries[value]).hexdigest() if held else value

    text = dict(json.loads(entries[TEXT]))
    moved = {name: own for name, own in text.items() if name not in LOOKS}
    return hashlib.sha256(json.dumps(resolved(moved), sort_keys=True).encode()).hexdigest()


def _lessons_kept(path: Path, entries: Mapping[str, bytes]) -> dict[str, bytes]:
    """What the file at a path has learnt, as an entry, if its body is that of the new entries."""
    try:
        old = read_entries(path)
        same = LESSONS in old and body_of(old) == body_of(entries)
    except (InputError, KeyError, TypeError, ValueError, RecursionError):
        # no character's file, or none yet
        return {}
    return {LESSONS: old[LESSONS]} if same else {}


def load_character(path: Path) -> dict[str, Any]:
    """Arguments of the constructor of a character that `save_character` wrote.

    Raises:
        InputError: the file is missing, is none of its kind, or holds what no character can have.
    """
    entries = read_entries(path)
    try:
        text = json.loads(entries.pop(TEXT))
        if text["format"] != FORMAT or text["version"] != VERSION:
            raise InputError(
                f"version {text['version']!r} of a {text['format']!r} is not known; known is "
                f"version {VERSION} of a {FORMAT!r}"
            )
        return arguments(text, Arrays(entries))
    except SoftBodyError as error:
        raise InputError(f"{path}: {error}") from error
    except (KeyError, TypeError, ValueError, AttributeError, RecursionError) as error:
        raise InputError(
            f"{path}: it does not hold a character: {type(error).__name__} at {error}"
        ) from error


def read_entries(path: Path) -> dict[str, bytes]:
    """Everything that a character's file holds, by name.

    Raises:
        InputError: the file is missing, or is none of its kind.
    """
    _check_extension(path)
    try:
        with ZipFile(path) as archive:
            return _entries(archive, path)
    except FileNotFoundError as error:
        raise InputError(f"{path}: there is no such file") from error
    except (OSError, BadZipFile, NotImplementedError, RuntimeError, EOFError) as error:
        raise InputError(f"{path}: cannot be read as a character: {error}") from error


def _check_extension(path: Path) -> None:
    if path.suffix.lower() != EXTENSION:
        raise InputError(f"{path}: a character's file must end in {EXTENSION}")


def _put_entry(archive: ZipFile, name: str, data: bytes) -> None:
    """Add an entry whose bytes hang on its name and data alone."""
    entry = ZipInfo(name, BEGINNING_OF_TIME)
    entry.compress_type = ZIP_DEFLATED
    archive.writestr(entry, data)


def _entries(archive: ZipFile, path: Path) -> dict[str, bytes]:
    """All entries; their sizes are checked before any is unpacked."""
    size = sum(entry.file_size for entry in archive.infolist())
    if size > MOST_BYTES:
        raise InputError(f"{path}: it unpacks to {size} bytes, but at most {MOST_BYTES} are read")
    if TEXT not in archive.namelist():
        raise InputError(f"{path}: it is not a character's file, as it has no {TEXT}")
    return {name: archive.read(name) for name in archive.namelist()}
