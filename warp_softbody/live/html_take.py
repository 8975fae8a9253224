"""An `HtmlTake` writes frames to one HTML file that plays them anywhere."""

from __future__ import annotations

from contextlib import ExitStack, suppress
from pathlib import Path
from types import TracebackType
from typing import BinaryIO

from warp_softbody.atomic_files import replacing
from warp_softbody.errors import OutputError
from warp_softbody.inputs import checks, input_kinds
from warp_softbody.live.scene_view import SceneView
from warp_softbody.live.take_page import TakePage
from warp_softbody.stage_exports.bodies import check_fits, staged_bodies
from warp_softbody.stage_exports.conventions import checked_target
from warp_softbody.world.frame import Frame
from warp_softbody.world.scene import Scene


class HtmlTake:
    """Writes a page by frames: `with HtmlTake("take.html", scene) as take: take.write(frame)`.

    The file holds the player and all frames, needs no other file and no connection, and opens in
    any browser. Places are rounded to 1/65535 of one and a half times the bodies' largest side. At
    the end, also after an exception, the frames so far replace an older file in one step; without a
    frame nothing is left behind.
    """

    def __init__(
        self, path: str | Path, scene: Scene, *, fps: float = 30.0, name: str = "take"
    ) -> None:
        """Check everything that can be checked before the first frame.

        Args:
            path: ends in .html.
            scene: what the frames are snapshots of.
            fps: frames per simulated second.
            name: the title of the page.

        Raises:
            InputError: a value is none of these.
            OutputError: the path cannot be written.
        """
        self._target = checked_target(path, extensions=(".html",))
        checks.instance("scene of an HtmlTake", scene, Scene)
        fps = checks.number("fps of an HtmlTake", fps, low=1e-3, high=1e6, unit="1/s")
        input_kinds.name("name of an HtmlTake", name)
        self._bodies = staged_bodies(scene)
        self._view = SceneView(scene, name=name, fps=fps)
        self._page = TakePage(self._view.outline)
        self._files = ExitStack()
        self._file: BinaryIO | None = None
        self._closed = False

    def write(self, frame: Frame) -> None:
        """Add a frame.

        Raises:
            InputError: it is none of this scene.
            OutputError: the page is closed, or could not be written; then nothing is left of it.
        """
        checks.instance("frame of an HtmlTake", frame, Frame)
        if self._closed:
            raise OutputError(f"{str(self._target)!r} is closed; no frame can be added")
        check_fits(frame, self._bodies)
        moment = self._view.moment(frame)
        try:
            if self._file is None:
                path = self._files.enter_context(replacing(self._target))
                self._file = self._files.enter_context(path.open("wb"))
                self._file.write(self._page.begin())
            self._file.write(self._page.add(moment))
        except OSError as error:
            self._give_up(error)
            raise self._unwritten(error) from error

    def close(self) -> None:
        """Finish the file; without a frame, or a second time, this does nothing.

        Raises:
            OutputError: it could not be written; an older file is as it was.
        """
        if self._closed:
            return
        self._closed = True
        if self._file is None:
            return
        try:
            with self._files:
                self._file.write(self._page.end())
        except OSError as error:
            raise self._unwritten(error) from error

    def _give_up(self, error: OSError) -> None:
        """Remove what was written."""
        self._closed = True
        with suppress(OSError), self._files:
            raise error

    def _unwritten(self, error: OSError) -> OutputError:
        return OutputError(f"{str(self._target)!r} could not be written: {error.strerror or error}")

    def __enter__(self) -> HtmlTake:
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
