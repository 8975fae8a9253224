"""Folders of chunks beside a target: whose they are, and which a crash has left.

Each writer has a folder of its own and holds a lock in it; the system lets go of the lock with the
process, however that ends. So a folder whose lock is free was left behind.
"""

from __future__ import annotations

import errno
import fcntl
import os
import shutil
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path

from warp_softbody.atomic_files import private_folder
from warp_softbody.errors import OutputError

LOCK = "lock"
_TAKEN = (errno.EEXIST, errno.ENOTEMPTY, errno.ENOTDIR)


_named_process: int | None = None


def speak_for(process: int) -> None:
    """Name another process as the writer of what this one writes: the one that had it made."""
    global _named_process
    _named_process = process


def is_this_process(process: int) -> bool:
    """Whether it is this one, or the one that this one speaks for."""
    return process in (os.getpid(), _named_process)


@dataclass
class Claim:
    """A folder of chunks and its lock, which is held until it is let go, by this process alone.

    Attributes:
        folder: of the chunks.
        lock: open descriptor; None for a folder without a lock file, which nobody can hold.
        process: that holds it; a fork of that one does not. 0 once it has been let go.
    """

    folder: Path
    lock: int | None
    process: int = field(default_factory=os.getpid)

    @property
    def held(self) -> bool:
        """Whether the folder is still this process's own."""
        return self.process == os.getpid()

    def release(self) -> None:
        """Let go of the lock; the folder stays."""
        if self.held and self.lock is not None:
            with suppress(OSError):
                # a fork has the same lock, which would stay with it
                fcntl.flock(self.lock, fcntl.LOCK_UN)
            os.close(self.lock)
        self.process = 0

    def remove(self) -> None:
        """Delete the folder and let go of it; harmless when that is done."""
        if self.held:
            shutil.rmtree(self.folder, ignore_errors=True)
        self.release()


def claim(target: Path) -> Claim:
    """A new folder for a writer of ``target``.

    It is locked before it gets the name by which others find it.

    Raises:
        OSError: no folder can be made there.
    """
    folder = private_folder(target.parent)
    try:
        flags = os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_CLOEXEC
        lock = os.open(folder / LOCK, flags, 0o600)
        _locked(lock)
        os.write(lock, str(_named_process or os.getpid()).encode())
        return Claim(_named(folder, target), lock)
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise


def left_behind(target: Path) -> list[Claim]:
    """The folders that nobody holds, the newest first; the caller holds them from now on."""
    found = [(folder, _free_lock(folder)) for folder in folders_of(target)]
    free = [Claim(folder, lock) for folder, (free, lock) in found if free]
    return sorted(free, key=lambda one: _changed(one.folder), reverse=True)


def _changed(folder: Path) -> int:
    try:
        return folder.stat().st_mtime_ns
    except OSError:
        return 0


def writing_process(target: Path, but: Path | None = None) -> int | None:
    """Number of the process whose other writer writes ``target``, or None.

    Args:
        target: what is written.
        but: the asker's own folder. Of two that started at the same time each sees the other's,
            and the older one goes on.
    """
    own = None if but is None else (but / LOCK).stat()
    for folder in folders_of(target):
        free, lock = _free_lock(folder)
        if lock is not None:
            os.close(lock)
        if free or folder == but:
            continue
        with suppress(OSError, ValueError):
            process = int((folder / LOCK).read_text())
            since = (folder / LOCK).stat().st_mtime_ns
            older = own is None or since <= own.st_mtime_ns
            if older:
                return process
    return None


def require_alone(target: Path, own: Path | None = None) -> None:
    """Refuse to write what another writer writes; for ``own`` see `writing_process`.

    Raises:
        OutputError: it does.
    """
    process = writing_process(target, own)
    if process is None:
        return
    other = f"process {process}"
    if is_this_process(process):
        other = "another writer of this process"
    raise OutputError(
        f"cannot write {str(target)!r}: {other} is writing it; choose another name, or wait"
    )


def folder_name(target: Path) -> str:
    """The usual name of the folder; further ones have a number behind it."""
    return f".{target.name}.chunks"


def folders_of(target: Path) -> list[Path]:
    """All folders of chunks beside a target; links are none."""
    name = folder_name(target)
    with suppress(OSError), os.scandir(target.parent) as entries:
        return [
            Path(entry.path)
            for entry in entries
            if entry.name.startswith(name)
            and (entry.name == name or entry.name[len(name) :].lstrip(".").isdecimal())
            and entry.is_dir(follow_symlinks=False)
        ]
    return []


def _named(folder: Path, target: Path) -> Path:
    """Give a folder the first name that is free; renaming never follows what stands there."""
    for number in count(1):
        place = target.with_name(folder_name(target) + (f".{number}" if number > 1 else ""))
        if os.path.lexists(place):
            continue
        try:
            os.rename(folder, place)
        except OSError as error:
            if error.errno not in _TAKEN:
                raise
        else:
            return place
    raise AssertionError("numbers do not end")


def _free_lock(folder: Path) -> tuple[bool, int | None]:
    """Whether nobody holds a folder, and the lock that was then taken."""
    try:
        lock = os.open(folder / LOCK, os.O_RDWR | os.O_NOFOLLOW | os.O_CLOEXEC)
    except FileNotFoundError:
        return True, None
    except OSError:
        # somebody else's
        return False, None
    if _locked(lock):
        return True, lock
    os.close(lock)
    return False, None


def _locked(lock: int) -> bool:
    """Take a lock unless it is held; where there are no locks, see whether its writer lives."""
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return not _lives(os.pread(lock, 20, 0))
    return True


def _lives(number: bytes) -> bool:
    try:
        os.kill(int(number), 0)
    except (ValueError, OverflowError, ProcessLookupError):
        return False
    except PermissionError:
        return True
    return True
