"""A process trusts the files that it wrote itself; this is where they are remembered."""

from __future__ import annotations

import os
from pathlib import Path

Identity = tuple[int, int, int, int]

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
