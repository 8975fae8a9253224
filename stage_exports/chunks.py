"""A take on disk while it is being written: closed chunks in a hidden folder beside the target.

Each layer is exported to a temporary name and renamed, so a file with a final name is whole. What a
crash or a full disk leaves behind is therefore a valid beginning of the take, and `recover` makes
a stage of it.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from pxr import Sdf, Tf, UsdUtils

from warp_softbody.errors import OutputError
from warp_softbody.stage_exports.conventions import EXTENSIONS, checked_target

_STATIC = "static.usdc"


class ChunkFolder:
    """The chunks of one take.

    Attributes:
        target: the file that the chunks become.
        folder: hidden, beside the target; absent before the first chunk and after the merge.
    """

    def __init__(self, target: Path) -> None:
        """Touch nothing yet."""
        self.target = target
        self.folder = target.with_name(f".{target.name}.chunks")

    def start(self, static: Any) -> None:
        """Begin a take: forget what an older one left and store what does not move."""
        self.remove()
        try:
            with self._one_sentence():
                self.folder.mkdir()
                export(static, self.folder / _STATIC)
        except OutputError:
            self.remove()
            raise

    def add(self, first_frame: int, samples: Any) -> None:
        """Store a chunk; writing the same chunk again replaces it."""
        with self._one_sentence():
            export(samples, self.folder / f"frames_{first_frame:08d}.usdc")

    def merge(self) -> None:
        """Make one file of all chunks under the target's name, whole or not at all."""
        with self._one_sentence():
            merged = Sdf.Layer.CreateAnonymous(".usda")
            merged.TransferContent(_opened(self.folder / _STATIC))
            layers = [_opened(chunk) for chunk in self._closed()]
            for layer in layers:
                UsdUtils.StitchLayers(merged, layer)
            merged.startTimeCode = layers[0].startTimeCode
            merged.endTimeCode = layers[-1].endTimeCode
            export(merged, self.target)

    def remove(self) -> None:
        """Delete the chunks, if there are any."""
        shutil.rmtree(self.folder, ignore_errors=True)

    def any_closed(self) -> bool:
        """Whether there are frames to make a stage of."""
        return bool(self._closed())

    def _closed(self) -> list[Path]:
        return sorted(self.folder.glob("frames_*.usdc"))

    @contextmanager
    def _one_sentence(self) -> Iterator[None]:
        """Turn what USD and the system raise into an OutputError that says what is saved."""
        try:
            yield
        except (OSError, Tf.ErrorException) as error:
            kept = "no frame of the take is kept"
            if self.any_closed():
                kept = (
                    "the closed chunks of the take are kept beside it, and "
                    "warp_softbody.stage_exports.recover makes a stage of them"
                )
            raise OutputError(
                f"{str(self.target)!r} could not be written ({_reason(error)}); {kept}"
            ) from error


def recover(path: str | Path) -> Path:
    """Make a stage of the chunks that an interrupted take left beside `path`; returns its path."""
    target = checked_target(path, extensions=EXTENSIONS)
    chunks = ChunkFolder(target)
    if not chunks.any_closed():
        raise OutputError(f"nothing to recover for {str(path)!r}: no chunks stand beside it")
    chunks.merge()
    chunks.remove()
    return target


def export(layer: Any, path: Path) -> None:
    """Write a layer under a temporary name in the same folder and rename it."""
    temporary = path.with_name(f".writing.{path.name}")
    try:
        if not layer.Export(str(temporary)):
            raise OSError("USD could not export the layer")
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


def _opened(path: Path) -> Any:
    """A layer read anew: OpenAsAnonymous never hands out what an older file of that name held."""
    layer = Sdf.Layer.OpenAsAnonymous(str(path))
    if layer is None:
        raise OSError(f"{path.name} is missing or damaged")
    return layer


def _reason(error: Exception) -> str:
    """The cause alone: USD appends every error that followed from it."""
    if isinstance(error, Tf.ErrorException) and error.args:
        return str(error.args[0].commentary)
    return str(error)
