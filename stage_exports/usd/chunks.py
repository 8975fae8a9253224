"""A take on disk while it is being written: closed chunks in a hidden folder beside the target.

A file with a final name is whole, because each layer is written under another one and renamed. What
a crash or a full disk leaves behind is therefore a valid beginning of the take, and `recovery.py`
makes a stage of it. Each writer has a folder of its own (`claims.py`).
"""

from __future__ import annotations

import os
import weakref
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from threading import RLock
from typing import Any

from warp_softbody.atomic_files import put_in_place, replacing
from warp_softbody.errors import InputError, OutputError
from warp_softbody.stage_exports.usd.claims import (
    Claim,
    claim,
    folder_name,
    left_behind,
    require_alone,
)
from warp_softbody.stage_exports.usd.growing_crate import GrowingCrate, UnknownCrate
from warp_softbody.stage_exports.usd.isolation import apart
from warp_softbody.stage_exports.usd.merging import (
    CRATES,
    PACKED,
    STATIC,
    closed_chunks,
    export,
    opened,
    reason,
)
from warp_softbody.stage_exports.usd.series import Series
from warp_softbody.stage_exports.usd.stage_files import identity, keep_identity, mark_own
from warp_softbody.stage_exports.usd.textures import keep_textures, kept_textures

GROWN = "grown.usdc"
"""The stage to be, of all frames so far."""

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
            OutputError: another writer, of any process, has begun to write it.
        """
        self.target = target
        self._claim: Claim | None = None
        self._overwrite = overwrite
        self._crate: GrowingCrate | None = None
        self._grows = target.suffix.lower() in CRATES
        self._before = identity(target)
        with self._one_sentence(), suppress(FileNotFoundError):
            # where the longest name made beside it is too long, this says so
            os.lstat(target.with_name(f"{folder_name(target)}.99"))
        self._require_alone(None)

    @property
    def begun(self) -> bool:
        """Whether there is a folder."""
        return self._claim is not None

    def begin(self) -> None:
        """Make a folder for the chunks and hold it; harmless when there is one.

        Raises:
            OutputError: another writer, of any process, writes the same target.
        """
        if self._claim is not None:
            return
        with self._one_sentence():
            self._claim = claim(self.target)
        weakref.finalize(self, abandon, self._claim)
        if self._overwrite:
            self._before = identity(self.target)
        self._require_alone(self._claim)
        with self._one_sentence():
            keep_identity(self._claim.folder, self._before)

    def start(self, static: Any, textures: Mapping[str, bytes]) -> None:
        """Store what does not move, and textures by their paths from the stage."""
        with self._one_sentence():
            keep_textures(self._folder, textures)
            _stored(static, self._folder / STATIC)

    def add(self, first_frame: int, samples: Any) -> None:
        """Store a chunk; writing the same chunk again replaces it."""
        with self._one_sentence():
            _stored(samples, self._folder / f"frames_{first_frame:08d}.usdc")

    def grow(self, first_frame: int, codes: Sequence[float], series: Sequence[Series]) -> None:
        """Add frames to the stage as it will be; the same ones again change nothing.

        Where that is not possible the stage is made of the chunks at the end.
        """
        if not self._grows:
            return
        self._grows = False
        with suppress(OSError, InputError, UnknownCrate):
            if self._crate is None:
                with USD:
                    static = opened(self._folder / STATIC)
                    self._crate = GrowingCrate(self._folder / GROWN, static, series)
            if self._crate.frames == first_frame:
                self._crate.add(codes, series)
            self._grows = True
        if not self._grows:
            self._let_go()

    def finish(self, first_frame: int, last: Callable[[], Any] | None) -> None:
        """Make the stage, in one step, and forget these chunks and what crashed takes left.

        Args:
            first_frame: of the last chunk.
            last: makes its samples, or None where all chunks are stored. They become a chunk only
                if the stage has to be made of chunks, or cannot be made.

        Raises:
            OutputError: it could not be written, or another stands there since this take began.
        """
        with self._one_sentence():
            try:
                self._make(first_frame, last)
            except BaseException:
                self._keep(first_frame, last)
                raise
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
        if self._crate is not None:
            self._crate.close()
        if self._claim is not None:
            abandon(self._claim)
            self._claim = None

    @property
    def _folder(self) -> Path:
        self.begin()
        assert self._claim is not None
        return self._claim.folder

    def to_disk(self) -> None:
        """Let a disk write what has grown; whether it is full is told at the end."""
        if self._grows and self._crate is not None:
            with suppress(OSError):
                self._crate.to_disk()

    def _keep(self, first_frame: int, last: Callable[[], Any] | None) -> None:
        self._grows = False
        self._let_go()
        if last is not None:
            self.add(first_frame, last())

    def _let_go(self) -> None:
        """Do without the crate that grew; the disk may be full of it."""
        if self._crate is not None:
            self._crate.close()
            self._crate = None
        with suppress(OSError):
            (self._folder / GROWN).unlink()

    def _make(self, first_frame: int, last: Callable[[], Any] | None) -> None:
        """Make the target of the crate that grew, or of the chunks where there is none."""
        if identity(self.target) not in (None, self._before):
            raise OSError("another was written there since this take began")
        if self._grows and self._crate is not None:
            with USD:
                keep_textures(self.target.parent, kept_textures(self._folder))
                self._crate.finish()
            # stands where only the owner may enter and the names go with it
            put_in_place(self._folder / GROWN, self.target)
        else:
            self._keep(first_frame, last)
            merged(self._folder, self.target, trusted=True)
        mark_own(self.target)

    def _require_alone(self, own: Claim | None) -> None:
        try:
            require_alone(self.target, None if own is None else own.folder)
        except OutputError:
            self.forget()
            raise

    @contextmanager
    def _one_sentence(self) -> Iterator[None]:
        """Turn what USD and the system raise into an OutputError that says what is saved."""
        try:
            yield
        except OutputError:
            # says so already
            raise
        except (OSError, InputError) as error:
            kept = "no frame of the take is kept"
            if self._claim is not None and closed_chunks(self._claim.folder):
                kept = (
                    "the closed chunks of the take are kept beside it, and "
                    "`warp-softbody recover`, with --out OTHER elsewhere, makes a stage of them"
                )
            raise OutputError(
                f"{str(self.target)!r} could not be written ({reason(error)}); {kept}"
            ) from error


def _stored(layer: Any, path: Path) -> None:
    with USD, replacing(path) as temporary:
        export(layer, str(temporary))


def merged(folder: Path, target: Path, *, trusted: bool) -> int:
    """Make one file of all chunks of a folder; returns its frames' number.

    Raises:
        InputError: a chunk is missing or damaged.
        OSError: the file could not be written.
    """
    size = sum(chunk.stat().st_size for chunk in folder.glob("*.usdc"))
    with _placed(folder, target) as path:
        frames: int = apart("merge", folder, path, size=size, trusted=trusted)
    return frames


@contextmanager
def _placed(folder: Path, target: Path) -> Iterator[str]:
    """A path in a folder of chunks to write the stage to, which then becomes the target."""
    if target.suffix.lower() != PACKED:
        keep_textures(target.parent, kept_textures(folder))
    beside = folder.parent == target.parent
    with USD, replacing(target, within=folder if beside else None) as path:
        yield str(path)


def abandon(left: Claim) -> None:
    """Let go of a folder; one without a frame is deleted."""
    if not left.held:
        return
    if closed_chunks(left.folder):
        left.release()
    else:
        left.remove()
