"""Encoders of movies take frames one by one."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Any, Protocol

from warp_softbody.errors import MissingExtraError
from warp_softbody.stage_exports.pictures.libraries import imageio
from warp_softbody.stage_exports.pictures.render import Image


class Encoder(Protocol):
    """What makes a file of frames."""

    def append_data(self, image: Image, /) -> None:
        """Add a frame."""

    def close(self) -> None:
        """Finish the file."""


class Gif:
    """Frames with a palette each, which wait in memory for the end."""

    def __init__(self, path: Path, fps: float) -> None:
        """Prepare a file that shows every frame for 1/fps."""
        self._path = path
        self._milliseconds = 1000.0 / fps
        self._frames: list[Any] = []

    def append_data(self, image: Image, /) -> None:
        """Choose the frame's colours and keep it."""
        pillow = import_module("PIL.Image")
        frame = pillow.fromarray(image)
        self._frames.append(frame.convert("P", palette=pillow.Palette.ADAPTIVE))

    def close(self) -> None:
        """Write all frames, for ever in turn."""
        first, *others = self._frames
        first.save(
            self._path,
            format="GIF",
            save_all=True,
            append_images=others,
            duration=self._milliseconds,
            loop=0,
        )


def open_encoder(path: Path, fps: float) -> Encoder:
    """The encoder of a path's extension.

    Raises:
        MissingExtraError: it is not installed.
    """
    if path.suffix.lower() == ".gif":
        imageio()
        return Gif(path, fps)
    try:
        # Without the whole-macroblock rule of old players the movie keeps the size asked for.
        writer: Encoder = imageio().get_writer(
            path, format="FFMPEG", mode="I", fps=fps, quality=8, macro_block_size=2
        )
    except ImportError as error:
        raise MissingExtraError(
            "an .mp4 needs imageio-ffmpeg, which is not installed: "
            "pip install 'warp-softbody[view]'"
        ) from error
    return writer


def check_movie(path: Path, count: int) -> None:
    """Read a finished .mp4 again: its encoder does not say that it had no room.

    Raises:
        OSError: it cannot be read, or holds fewer frames than were drawn.
    """
    if path.suffix.lower() != ".mp4":
        return
    encoder = import_module("imageio_ffmpeg")
    try:
        found, _ = encoder.count_frames_and_secs(path)
    except RuntimeError as error:
        raise OSError("the encoder left a file that cannot be read; is the disk full?") from error
    if found < count:
        raise OSError(f"the encoder kept {found} of {count} frames; is the disk full?")
