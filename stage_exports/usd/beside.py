"""A stage is written by a process beside the run, so that the run hardly waits for it.

USD keeps Python's lock while it writes, so that a thread would not help. A fork does, and loads USD
while the run is prepared. It has a `StageWriter` of its own: what stands in the file is the same to
the last bit. Where a fork may not be made, or there is one processor, the run writes by itself.
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

from warp_softbody.errors import OutputError
from warp_softbody.inputs import checks
from warp_softbody.stage_exports.camera_paths import FOLLOW, CameraChoice
from warp_softbody.stage_exports.conventions import EXTENSIONS, checked_target
from warp_softbody.stage_exports.usd.byte_ring import ByteRing
from warp_softbody.stage_exports.usd.claims import require_alone
from warp_softbody.stage_exports.usd.forking import STOP, forked
from warp_softbody.stage_exports.usd.frame_bytes import packed
from warp_softbody.stage_exports.usd.messages import Messages
from warp_softbody.stage_exports.usd.physics_names import Profile
from warp_softbody.stage_exports.usd.stage_files import mark_own
from warp_softbody.world.frame import Frame
from warp_softbody.world.scene import Scene

if TYPE_CHECKING:
    from warp_softbody.stage_exports.usd.writer import StageWriter

LEAST_RING, FRAMES_AHEAD = 2 << 20, 8
"""Bytes of frames on their way at most, and how many there have to be room for."""

TOLD_AT_ONCE = 16
"""Frames of which the writer is told together: each telling wakes it."""

_ENDING: list[int] = []
"""Processes that have closed their stages."""


def stage_writer(
    path: str | Path,
    scene: Scene,
    *,
    fps: float = 30.0,
    metadata: Mapping[str, str | float] | None = None,
    camera: CameraChoice = FOLLOW,
    physics: Profile = "newton",
) -> StageWriter | StageBeside:
    """A `StageWriter`, in a process of its own where that is possible; for its arguments see there.

    Raises:
        InputError: an option or a part of the scene cannot be stored.
        OutputError: the path cannot be written. A writer beside the run may say so on entering it.
    """
    options = {"fps": fps, "metadata": metadata, "camera": camera, "physics": physics}
    if may_fork():
        return StageBeside(checked_target(path, extensions=EXTENSIONS), scene, options)
    from warp_softbody.stage_exports.usd.writer import StageWriter

    return StageWriter(path, scene, **options)  # type: ignore[arg-type]


def may_fork() -> bool:
    """Whether a second processor is free to be used, and no thread here may hold what it needs."""
    if sys.platform != "linux":
        return False
    tasks = Path("/proc/self/task")
    return len(os.sched_getaffinity(0)) > 1 and tasks.is_dir() and len(list(tasks.iterdir())) == 1


class StageBeside:
    """The run's half of a writer in a process of its own; used as a `StageWriter`.

    A mistake in a frame and a full disk are told by one of the next calls, since the writer is some
    frames behind. When it is behind by more than `ByteRing` holds the run waits for it.
    """

    def __init__(self, path: Path, scene: Scene, options: Mapping[str, Any]) -> None:
        """Fork the writer, which makes a `StageWriter` of these arguments.

        Args:
            path: absolute, where a file can be made.
            scene: what the frames are snapshots of.
            options: of the `StageWriter`.
        """
        _ENDING[:] = [process for process in _ENDING if os.waitpid(process, os.WNOHANG)[0] == 0]
        self.path = path
        nodes = len(scene.whole.mesh.points)
        # positions, velocities, and as much again for muscles and contacts
        self._ring = ByteRing(max(LEAST_RING, FRAMES_AHEAD * 96 * nodes))
        self._untold: list[tuple[int, int]] = []
        self._closed = False
        self._entered = False
        self._mistake: Exception | None = None
        self._pipe, theirs = Messages.pair()
        self._process = forked(self._pipe, theirs, self._ring, (path, scene, options))

    def __enter__(self) -> StageBeside:
        """Write inside the body; from here on no other process may write this path.

        The writer may still be loading USD, which takes as long as a run needs to begin. It is not
        waited for: what it has to say against the scene, it says at one of the first frames.

        Raises:
            OutputError: another process writes it.
        """
        try:
            require_alone(self.path)
            self._tell("enter")
            self._ring.settle()
            self._listen()
        except BaseException:
            self._closed = True
            self._end(STOP)
            raise
        return self

    def write(self, frame: Frame) -> None:
        """Add a copy of a frame; times must increase.

        Raises:
            InputError: the writer refused this frame, or one of the last.
            OutputError: the writer is closed, or could not write.
        """
        checks.instance("frame to write", frame, Frame)
        if self._closed:
            raise OutputError(f"{str(self.path)!r} is closed; no frame can be added")
        message = packed(frame)
        place = self._ring.put(message)
        while place is None:
            self._tell_frames()
            if len(message) > self._ring.size:
                self._tell("large", message)
                return
            self._hear()
            self._raise_mistake()
            place = self._ring.put(message)
        self._untold.append((place, len(message)))
        if len(self._untold) >= TOLD_AT_ONCE:
            self._tell_frames()
            self._listen()
        elif not self._entered:
            self._listen()

    def close(self) -> None:
        """Wait until the stage is whole; a second call does nothing.

        Raises:
            InputError: the writer refused one of the last frames; the stage is of those before it.
            OutputError: it could not be written; closed chunks are kept for `recover`.
        """
        if self._closed:
            return
        self._closed = True
        try:
            self._tell_frames()
            self._tell("close")
            while self._hear() != "closed":
                pass
            if not self._entered:
                self._raise_mistake()
        except BaseException:
            self._end(STOP)
            raise
        # what it still takes to end is not waited for
        self._pipe.close()
        _ENDING.append(self._process)
        mark_own(self.path)
        self._raise_mistake()

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Keep the frames so far, whatever ended the body."""
        self.close()

    def __del__(self) -> None:
        """A writer that nobody closed leaves its frames for `recover`."""
        if not self._closed:
            self._closed = True
            self._end()

    def _tell_frames(self) -> None:
        told, self._untold = self._untold, []
        if told:
            self._tell("frames", told)

    def _tell(self, *order: Any) -> None:
        try:
            self._pipe.send(order)
        except (BrokenPipeError, ConnectionResetError):
            # what it said before it ended is the better sentence
            while True:
                self._hear()

    def _listen(self) -> None:
        """Take what the writer has said so far.

        Raises:
            SoftBodyError: its mistake.
        """
        while self._pipe.has_any():
            self._hear()
        self._raise_mistake()

    def _hear(self) -> str:
        """What the writer says next; its first mistake is kept to be raised.

        Raises:
            SoftBodyError: it has ended; its mistake, if there is one.
        """
        try:
            said, told = self._pipe.receive()
        except (EOFError, ConnectionResetError):
            self._raise_mistake()
            raise self._lost() from None
        if said == "read":
            self._ring.let_go(told)
        elif said == "entered":
            self._entered = True
        elif said == "raised" and self._mistake is None:
            self._mistake = told
        return str(said)

    def _raise_mistake(self) -> None:
        mistake, self._mistake = self._mistake, None
        if mistake is None:
            return
        if not self._entered:
            # it has not begun, and there is nothing to close
            self._closed = True
            self._end(STOP)
        raise mistake

    def _lost(self) -> OutputError:
        return OutputError(
            f"{str(self.path)!r} could not be written (the process that wrote it has ended); if "
            "chunks of the take are kept beside it, `warp-softbody recover` makes a stage of them"
        )

    def _end(self, number: signal.Signals | None = None) -> None:
        """Let the writer end, at once if it is sent a signal, and wait for that; once."""
        process, self._process = self._process, 0
        if not process:
            return
        if number is not None:
            os.kill(process, number)
        self._pipe.close()
        os.waitpid(process, 0)
