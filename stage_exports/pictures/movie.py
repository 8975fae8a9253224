"""Frames become an animated GIF or an MP4, drawn without a display."""

from __future__ import annotations

from contextlib import ExitStack, suppress
from pathlib import Path
from types import TracebackType

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.atomic_files import replacing
from warp_softbody.errors import InputError, OutputError
from warp_softbody.inputs import array_checks, checks
from warp_softbody.stage_exports.bodies import staged_bodies
from warp_softbody.stage_exports.camera import Camera
from warp_softbody.stage_exports.camera_paths import FOLLOW, CameraChoice, camera_path
from warp_softbody.stage_exports.conventions import checked_target
from warp_softbody.stage_exports.pictures.encoders import Encoder, check_movie, open_encoder
from warp_softbody.stage_exports.pictures.picture import Size, checked_size
from warp_softbody.stage_exports.pictures.render import Renderer
from warp_softbody.stage_exports.pictures.subject import Pose, Subject
from warp_softbody.world.frame import Frame
from warp_softbody.world.scene import Scene


class Movie:
    """Draws a movie by frames: `with Movie("balance.mp4", scene) as movie: movie.write(frame)`.

    The camera follows the bodies unless it is told otherwise. At the end, also after an exception,
    the frames so far replace an older file in one step; without a frame nothing is left behind.
    """

    def __init__(
        self,
        path: str | Path,
        scene: Scene,
        *,
        fps: float = 30.0,
        size: Size = (640, 480),
        bounds: tuple[npt.ArrayLike, npt.ArrayLike] | None = None,
        camera: CameraChoice = FOLLOW,
    ) -> None:
        """Check everything that can be checked before the first frame.

        Args:
            path: ends in .gif or .mp4.
            scene: what the frames are snapshots of.
            fps: frames per second of the movie; a GIF keeps it to a hundredth of a second a frame.
            size: width and height, pixels; even numbers for an .mp4.
            bounds: lowest and highest corner of what a camera that stands still must see, m; None
                for the start pose with some room.
            camera: as for a `StageWriter`; with ``bounds`` it stands still.

        Raises:
            InputError: a value is none of these.
            OutputError: the path cannot be written.
        """
        self._target = checked_target(path, extensions=(".gif", ".mp4"))
        checks.instance("scene of a Movie", scene, Scene)
        fps = checks.number("fps of a Movie", fps, low=1e-3, high=1e4, unit="1/s")
        size = checked_size(size)
        if self._target.suffix.lower() == ".mp4" and (size[0] % 2 or size[1] % 2):
            raise InputError(f"an .mp4 needs an even width and height, got {size!r}")
        self._bodies = staged_bodies(scene)
        start, aspect = np.asarray(scene.whole.mesh.points), size[0] / size[1]
        if bounds is not None:
            camera = Camera.framing(*_checked_box(bounds), aspect=aspect)
        self._camera = camera_path("camera of a Movie", camera, start, aspect)
        view = camera_path("camera of a Movie", camera, start, aspect).at(0.0, start)
        self._renderer = Renderer(Subject.of_bodies(self._bodies, scene.ground), view, size)
        self._fps = float(fps)
        self._file = ExitStack()
        self._path = self._target
        self._writer: Encoder | None = None
        self._count = 0
        self._closed = False

    def write(self, frame: Frame) -> None:
        """Draw a frame and add it.

        Raises:
            OutputError: the movie is closed, or could not be written; then nothing is left of it.
        """
        checks.instance("frame of a Movie", frame, Frame)
        if self._closed:
            raise OutputError(f"{str(self._target)!r} is closed; no frame can be added")
        if self._camera.moves:
            self._renderer.look(self._camera.at(frame.time, frame.positions))
        image = self._renderer.draw(Pose.of_frame(frame, self._bodies))
        try:
            if self._writer is None:
                self._path = self._file.enter_context(replacing(self._target))
                self._writer = open_encoder(self._path, self._fps)
            self._writer.append_data(image)
            self._count += 1
        except OSError as error:
            self._give_up(error)
            raise self._unwritten(error) from error
        except BaseException as error:
            # the encoder was broken off in the middle of a frame
            self._give_up(error)
            raise

    def close(self) -> None:
        """Finish the file; without a frame, or a second time, this does nothing.

        Raises:
            OutputError: it could not be written; an older file is as it was.
        """
        if self._closed:
            return
        self._closed = True
        if self._writer is None:
            return
        try:
            with self._file:
                self._writer.close()
                check_movie(self._path, self._count)
        except OSError as error:
            raise self._unwritten(error) from error

    def _give_up(self, error: BaseException) -> None:
        """End the encoder and remove what it wrote."""
        self._closed = True
        with suppress(BaseException), self._file:
            if self._writer is not None:
                self._writer.close()
            raise error

    def _unwritten(self, error: OSError) -> OutputError:
        lines = (error.strerror or str(error)).strip().splitlines()
        return OutputError(f"{str(self._target)!r} could not be written: {lines[0]}")

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
