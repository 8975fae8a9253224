"""Files that are replaced in one step, whatever stands or happens in their folder meanwhile."""

from __future__ import annotations

import fcntl
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

PREFIX = ".warp-softbody-"
"""Of every temporary name beside a target; what follows is random."""


@contextmanager
def replacing(target: Path, *, within: Path | None = None) -> Iterator[Path]:
    """A path to write to, which becomes ``target`` in one step when the body ends well.

    It lies in a new folder beside the target, or ``within`` another one on its disk, that only the
    owner may enter, under a name that nobody can foresee: no link can be put in its way, and what a
    library leaves beside its output goes with the folder. The contents are on the disk before the
    name is. After an exception or Ctrl-C the older file is as it was and nothing is left behind.

    Raises:
        OSError: the folder cannot be written in, or the disk is full.
    """
    folder = private_folder(target.parent if within is None else within)
    try:
        path = folder / f"new{target.suffix}"
        yield path
        put_in_place(path, target)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def put_in_place(path: Path, target: Path) -> None:
    """Give a file of the same disk its name, in one step, once its contents are on the disk.

    Raises:
        OSError: the disk is full.
    """
    sync(path)
    os.replace(path, target)
    sync_folder(target.parent)


def replace_text(target: Path, text: str) -> None:
    """Write a text file in UTF-8, in one step.

    Raises:
        OSError: the folder cannot be written in, or the disk is full.
    """
    with replacing(target) as path:
        path.write_text(text, encoding="utf-8")


def private_folder(parent: Path) -> Path:
    """A new folder that only the owner may enter, under a random name."""
    return Path(tempfile.mkdtemp(prefix=PREFIX, dir=parent))


def require_writable(folder: Path) -> None:
    """Try it: permission bits say little for root, on read-only mounts and in virtual folders.

    Raises:
        OSError: no file can be made there.
    """
    made = private_folder(folder)
    try:
        (made / "probe").write_bytes(b"probe")
    finally:
        shutil.rmtree(made, ignore_errors=True)


def require_makeable(folder: Path) -> None:
    """Try whether a folder can be written in, or made; nothing of it is made.

    Raises:
        OSError: it cannot.
    """
    while not os.path.lexists(folder) and folder != folder.parent:
        folder = folder.parent
    require_writable(folder)


@contextmanager
def folder_lock(folder: Path) -> Iterator[None]:
    """Let one process at a time read and replace a file of a folder, where there are locks."""
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        with suppress(OSError):
            fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield
    finally:
        os.close(descriptor)


def sync(path: Path) -> None:
    """Put a file's contents on the disk; a link is not followed."""
    descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_CLOEXEC)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def sync_folder(folder: Path) -> None:
    """Put a folder's names on the disk, where the file system can."""
    with suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
