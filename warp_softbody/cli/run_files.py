"""`RunFiles` writes the files of a run: stage, movie, picture and page.

The libraries of each are loaded where it is asked for, since they take longer than a short run.
"""

from __future__ import annotations

import time
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING

from warp_softbody.cli.interruption import held_back
from warp_softbody.inputs.extras import require_package
from warp_softbody.stage_exports.camera_paths import FOLLOW, CameraChoice
from warp_softbody.stage_exports.conventions import checked_target
from warp_softbody.stage_exports.usd.physics_names import Profile
from warp_softbody.world.frame import Frame
from warp_softbody.world.scene import Scene

if TYPE_CHECKING:
    from warp_softbody.live import HtmlTake
    from warp_softbody.stage_exports import Movie, StageWriter
    from warp_softbody.stage_exports.pictures.picture import Size
    from warp_softbody.stage_exports.usd.beside import StageBeside


class RunFiles:
    """Writes each frame to the files asked for; the picture shows the last one.

    Everything about the files is checked on construction and none of them is created before the
    first frame. At the end, also after an error, they hold the frames so far.

    Attributes:
        last_seconds: wall time of the last frame or of the closing, s.
    """

    def __init__(
        self,
        scene: Scene,
        *,
        fps: float,
        stage: Path | None = None,
        movie: Path | None = None,
        picture: Path | None = None,
        page: Path | None = None,
        name: str = "take",
        metadata: dict[str, str | float] | None = None,
        camera: CameraChoice = FOLLOW,
        size: Size | None = None,
        physics: Profile = "newton",
    ) -> None:
        """Check paths, extensions and the packages that drawing needs."""
        self.last_seconds = 0.0
        self._scene = scene
        self._files = ExitStack()
        self._last: Frame | None = None
        self._picture = picture
        self._size: dict[str, Size] = {}
        if size is not None:
            with held_back():
                from warp_softbody.stage_exports.pictures.picture import checked_size

            self._size["size"] = checked_size(size)
        if picture is not None:
            checked_target(picture, extensions=(".png",))
        _require_drawing(movie, picture)
        self._writers: list[StageWriter | StageBeside | Movie | HtmlTake] = []
        if stage is not None:
            with held_back():
                from warp_softbody.stage_exports.usd.beside import stage_writer

                writer = stage_writer(
                    stage, scene, fps=fps, metadata=metadata, camera=camera, physics=physics
                )
            self._writers.append(writer)
        if page is not None:
            from warp_softbody.live import HtmlTake

            self._writers.append(HtmlTake(page, scene, fps=fps, name=name))
        if movie is not None:
            with held_back():
                from warp_softbody.stage_exports import Movie

            self._writers.append(Movie(movie, scene, fps=fps, camera=camera, **self._size))

    @property
    def has_frames(self) -> bool:
        """Whether there is anything in the files."""
        return self._last is not None

    def write(self, frame: Frame) -> None:
        """Add a frame to the stage and to the movie."""
        begun = time.perf_counter()
        for writer in self._writers:
            writer.write(frame)
        self._last = frame
        self._count(begun)

    def __enter__(self) -> RunFiles:
        """Write inside the body."""
        for writer in self._writers:
            self._files.enter_context(writer)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Finish the files; the picture is drawn unless one of them failed."""
        begun = time.perf_counter()
        self._files.__exit__(kind, error, trace)
        if kind is None and self._picture is not None and self._last is not None:
            with held_back():
                from warp_softbody.stage_exports import draw_picture

            draw_picture(self._picture, self._scene, self._last, **self._size)
        self._count(begun)

    def _count(self, begun: float) -> None:
        self.last_seconds = time.perf_counter() - begun


def _require_drawing(movie: Path | None, picture: Path | None) -> None:
    """Refuse before the simulation what could not be drawn after it."""
    needed = ["embreex", "imageio"] if movie or picture else []
    if movie and movie.suffix.lower() == ".mp4":
        needed.append("imageio_ffmpeg")
    for package in needed:
        require_package(package, "pictures and movies", "view")
