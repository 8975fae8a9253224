"""Which file it is: a process trusts those it wrote itself, and a take replaces what it knew of."""

from __future__ import annotations

import os
from pathlib import Path

Identity = tuple[int, int, int, int]

BEFORE = "before"
"""File in a folder of chunks."""

_OWN: set[Identity] = set()


def identity(path: Path) -> Identity | None:
    """What changes when a file is written anew; None where there is none."""
    try:
        found = os.lstat(path)
    except OSError:
        return None
    return found.st_dev, found.st_ino, found.st_size, found.st_mtime_ns


def mark_own(path: Path) -> None:
    """Remember a file as it is now."""
    found = identity(path)
    if found is not None:
        _OWN.add(found)


def is_own(path: Path) -> bool:
    """Whether this process wrote the file and nothing has changed it since."""
    return identity(path) in _OWN


def keep_identity(folder: Path, found: Identity | None) -> None:
    """Write down in a folder of chunks which file, if any, the take is to replace."""
    (folder / BEFORE).write_text(_told(found))


def may_replace(folder: Path, target: Path) -> bool:
    """Whether nothing stands at a target but the file that the take of these chunks was to replace.

    Args:
        folder: of the chunks; where it does not tell, no file may be replaced.
        target: of the take.
    """
    found = identity(target)
    if found is None:
        return True
    try:
        return (folder / BEFORE).read_text() == _told(found)
    except (OSError, ValueError):
        return False


def _told(found: Identity | None) -> str:
    # a disk may have another number when it is mounted again
    return "" if found is None else " ".join(str(number) for number in found[1:])
