"""Frames as an animated GIF or an MP4, drawn without a display."""

from __future__ import annotations

import os
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy.typing as npt

from warp_softbody import array_checks, checks
from warp_softbody.errors import InputError, MissingExtraError, OutputError
from warp_softbody.frame import Frame
from warp_softbody.scene import Scene
from warp_softbody.stage_exports.bodies import staged_bodies
from warp_softbody.stage_exports.camera import Camera, start_box
from warp_softbody.stage_exports.conventions import FloatArray, checked_target
from warp_softbody.stage_exports.picture import Size, checked_size, imageio
from warp_softbody.stage_exports.render import Renderer
from warp_softbody.stage_exports.subject import Pose, Subject


class Movie:
    """Draws frames as they come: `with Movie("balance.mp4", scene) as movie: movie.write(frame)`.

    The camera stands still. At the end, also after an exception, the frames so far replace an older
    file in one step; without a frame nothing is left behind.
    """

    def __init__(
        self,
        path: str | Path,
        scene: Scene,
        *,
        fps: float = 30.0,
        size: Size = (640, 480),
        bounds: tuple[npt.ArrayLike, npt.ArrayLike] | None = None,
    ) -> None:
        """Check everything that can be checked before the first frame.

        Args:
            path: ends in .gif or .mp4.
            scene: what the frames are snapshots of.
            fps: frames per second of the movie; a GIF keeps it to a hundredth of a second a frame.
            size: width and height, pixels; even numbers for an .mp4.
            bounds: lowest and highest corner of what the camera must see, m; None for the start
                pose with some room.
        """
        self._target = checked_target(path, extensions=(".gif", ".mp4"))
        checks.instance("scene of a Movie", scene, Scene)
        fps = checks.number("fps of a Movie", fps, low=1e-3, high=1e4, unit="1/s")
        size = checked_size(size)
        if self._target.suffix.lower() == ".mp4" and (size[0] % 2 or size[1] % 2):
            raise InputError(f"an .mp4 needs an even width and height, got {size!r}")
        self._bodies = staged_bodies(scene)
        box = start_box(scene.whole.mesh.points) if bounds is None else _checked_box(bounds)
        camera = Camera.framing(*box, aspect=size[0] / size[1])
        subject = Subject.of_bodies(self._bodies, scene.ground)
        self._renderer = Renderer(subject, camera, size)
        self._temporary = self._target.with_name(f".writing.{self._target.name}")
        self._fps = fps
        self._writer: Any = None

    def write(self, frame: Frame) -> None:
        """Draw a frame and add it."""
        checks.instance("frame of a Movie", frame, Frame)
        image = self._renderer.draw(Pose.of_frame(frame, self._bodies))
        try:
            if self._writer is None:
                self._writer = _open_writer(self._temporary, self._fps)
            self._writer.append_data(image)
        except OSError as error:
            raise OutputError(f"{str(self._target)!r} could not be written: {error}") from error

    def close(self) -> None:
        """Finish the file; harmless when closed already or without a frame."""
        if self._writer is None:
            return
        writer, self._writer = self._writer, None
        try:
            writer.close()
            os.replace(self._temporary, self._target)
        except OSError as error:
            raise OutputError(f"{str(self._target)!r} could not be written: {error}") from error
        finally:
            self._temporary.unlink(missing_ok=True)

    def __enter__(self) -> Movie:
        """Write inside the body."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Keep the frames so far, whatever ended the body."""
        self.close()


def _checked_box(bounds: object) -> tuple[FloatArray, FloatArray]:
    """Lowest and highest corner of a box with some room in it."""
    low, high = array_checks.array("bounds of a Movie", bounds, (2, 3), unit="m")
    if not (low <= high).all() or (low == high).all():
        checks.refuse("bounds of a Movie", "the lowest and the highest corner of a box", bounds)
    return low, high


def _open_writer(path: Path, fps: float) -> Any:
    """An encoder that takes frames one by one, so that a long movie needs no more memory."""
    if path.suffix.lower() == ".gif":
        return imageio().get_writer(path, mode="I", duration=1000.0 / fps, loop=0)
    try:
        # Without the whole-macroblock rule of old players the movie keeps the size asked for.
        return imageio().get_writer(
            path, format="FFMPEG", mode="I", fps=fps, quality=8, macro_block_size=2
        )
    except ImportError as error:
        raise MissingExtraError(
            "an .mp4 needs imageio-ffmpeg, which is not installed: "
            "pip install 'warp-softbody[view]'"
        ) from error
