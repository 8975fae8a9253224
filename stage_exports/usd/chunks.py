"""A take on disk while it is being written: closed chunks in a hidden folder beside the target.

A file with a final name is whole, because each layer is written under another one and renamed. What
a crash or a full disk leaves behind is therefore a valid beginning of the take, and `recover` makes
a stage of it. Each writer has a folder of its own (`claims.py`).
"""

from __future__ import annotations

import os
import weakref
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from threading import RLock
from typing import Any

from warp_softbody.atomic_files import replacing
from warp_softbody.errors import InputError, OutputError
from warp_softbody.stage_exports.conventions import EXTENSIONS, checked_target
from warp_softbody.stage_exports.usd.claims import (
    Claim,
    claim,
    folder_name,
    folders_of,
    left_behind,
    writing_process,
)
from warp_softbody.stage_exports.usd.isolation import apart
from warp_softbody.stage_exports.usd.merging import PACKED, STATIC, closed_chunks, export, reason
from warp_softbody.stage_exports.usd.stage_files import identity, mark_own
from warp_softbody.stage_exports.usd.textures import keep_textures, kept_textures

USD = RLock()
"""Held while layers are made and written: USD's change blocks are those of the whole process."""


class ChunkFolder:
    """The chunks of one take.

    Attributes:
        target: the file that the chunks become.
    """

    def __init__(self, target: Path, *, overwrite: bool = True) -> None:
        """Touch nothing yet.

        Args:
            target: the file that the chunks become.
            overwrite: whether a file may stand there that is written before this take begins.

        Raises:
            OutputError: another process writes it.
        """
        self.target = target
        self._claim: Claim | None = None
        self._overwrite = overwrite
        self._before = identity(target)
        with self._one_sentence(), suppress(FileNotFoundError):
            # where the longest name made beside it is too long, this says so
            os.lstat(target.with_name(f"{folder_name(target)}.99"))
        self._require_alone(None)

    def begin(self) -> None:
        """Make a folder for the chunks and hold it; harmless when there is one.

        Raises:
            OutputError: another process writes the same target.
        """
        if self._claim is not None:
            return
        with self._one_sentence():
            self._claim = claim(self.target)
        weakref.finalize(self, _abandon, self._claim)
        if self._overwrite:
            self._before = identity(self.target)
        self._require_alone(self._claim)

    def start(self, static: Any, textures: Mapping[str, bytes]) -> None:
        """Store what does not move, and textures by their paths from the stage."""
        with self._one_sentence():
            keep_textures(self._folder, textures)
            _stored(static, self._folder / STATIC)

    def add(self, first_frame: int, samples: Any) -> None:
        """Store a chunk; writing the same chunk again replaces it."""
        with self._one_sentence():
            _stored(samples, self._folder / f"frames_{first_frame:08d}.usdc")

    def finish(self) -> None:
        """Make the stage, in one step, and forget these chunks and what crashed takes left.

        Raises:
            OutputError: it could not be written, or another stands there since this take began.
        """
        with self._one_sentence():
            if identity(self.target) not in (None, self._before):
                raise OSError("another was written there since this take began")
            _merged(self._folder, self.target, trusted=True)
        self.forget()
        for older in left_behind(self.target):
            older.remove()

    def forget(self) -> None:
        """Delete the folder, if there is one."""
        if self._claim is not None:
            self._claim.remove()
            self._claim = None

    def leave(self) -> None:
        """Let go of the folder, so that `recover` finds it; delete it if it holds no frame."""
        if self._claim is not None:
            _abandon(self._claim)
            self._claim = None

    @property
    def _folder(self) -> Path:
        self.begin()
        assert self._claim is not None
        return self._claim.folder

    def _require_alone(self, own: Claim | None) -> None:
        process = writing_process(self.target, None if own is None else own.folder)
        if process is not None:
            self.forget()
            raise OutputError(
                f"cannot write {str(self.target)!r}: process {process} is writing it; "
                "choose another name, or wait"
            )

    @contextmanager
    def _one_sentence(self) -> Iterator[None]:
        """Turn what USD and the system raise into an OutputError that says what is saved."""
        try:
            yield
        except (OSError, InputError) as error:
            kept = "no frame of the take is kept"
            if self._claim is not None and closed_chunks(self._claim.folder):
                kept = (
                    "the closed chunks of the take are kept beside it, and "
                    "`warp-softbody recover` makes a stage of them"
                )
            raise OutputError(
                f"{str(self.target)!r} could not be written ({reason(error)}); {kept}"
            ) from error


def recover(path: str | Path) -> Path:
    """Make a stage of the chunks that an interrupted take left beside `path`; returns its path.

    Of several such takes it is the one that was written to last; the others stay.

    Raises:
        OutputError: there are none, the take is still being written, or a chunk is damaged.
    """
    return recovered(path)[0]


def recovered(path: str | Path) -> tuple[Path, int]:
    """The path that `recover` returns, and the number of frames."""
    target = checked_target(path, extensions=EXTENSIONS)
    claims = left_behind(target)
    try:
        chosen = next((one for one in claims if closed_chunks(one.folder)), None)
        if chosen is None:
            raise OutputError(_nothing(target, claims))
        try:
            frames = _merged(chosen.folder, target, trusted=False)
        except (OSError, InputError) as error:
            raise OutputError(
                f"{str(target)!r} could not be recovered ({reason(error)}); "
                f"the chunks are kept in {str(chosen.folder)!r}"
            ) from error
        chosen.remove()
    finally:
        for one in claims:
            _abandon(one)
    return target, frames


def _stored(layer: Any, path: Path) -> None:
    with USD, replacing(path) as temporary:
        export(layer, str(temporary))


def _merged(folder: Path, target: Path, *, trusted: bool) -> int:
    """Make one file of all chunks of a folder, in that folder first; returns its frames' number."""
    size = sum(chunk.stat().st_size for chunk in folder.glob("*.usdc"))
    if target.suffix.lower() != PACKED:
        keep_textures(target.parent, kept_textures(folder))
    with USD, replacing(target, within=folder) as path:
        frames: int = apart("merge", folder, str(path), size=size, trusted=trusted)
    if trusted:
        mark_own(target)
    return frames


def _nothing(target: Path, free: list[Claim]) -> str:
    if set(folders_of(target)) - {one.folder for one in free}:
        return f"{str(target)!r} is still being written; recover it once that has ended"
    return f"nothing to recover for {str(target)!r}: no chunks stand beside it"


def _abandon(left: Claim) -> None:
    """Let go of a folder; one without a frame is deleted."""
    if not left.held:
        return
    if closed_chunks(left.folder):
        left.release()
    else:
        left.remove()
