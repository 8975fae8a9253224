"""What the process beside a run does: a `StageWriter` that is told of frames through a pipe."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

from warp_softbody.errors import OutputError, SoftBodyError
from warp_softbody.stage_exports.usd import claims
from warp_softbody.stage_exports.usd.byte_ring import ByteRing
from warp_softbody.stage_exports.usd.frame_bytes import unpacked
from warp_softbody.stage_exports.usd.messages import Messages
from warp_softbody.stage_exports.usd.writer import StageWriter
from warp_softbody.world.scene import Scene

CHUNK_BYTES, CHUNK_FRAMES = 64 << 20, (240, 960)
"""Frames of a chunk, the more the smaller they are: a second of a letter.

It is closed at half of them while the writer waits for others, not at the end. A run that ends has
none closed: what it told of is kept in any case.
"""

GONE = (EOFError, BrokenPipeError, ConnectionResetError)
"""The run has ended without a word; what it had told of is kept for `recover`."""


def serve(
    pipe: Messages,
    ring: ByteRing,
    path: Path,
    scene: Scene,
    options: Mapping[str, Any],
) -> None:
    """Follow orders until the stage is closed, the run is gone, or a KeyboardInterrupt."""
    claims.speak_for(os.getppid())
    with suppress(*GONE, KeyboardInterrupt):
        try:
            writer = StageWriter(path, scene, **options, chunk_frames=_chunk_frames(scene))
        except Exception as error:
            pipe.send(("raised", _movable(error)))
            return
        try:
            _Service(pipe, ring, writer).follow()
        finally:
            writer.abandon()


def _chunk_frames(scene: Scene) -> int:
    # positions, velocities and skin
    least, most = CHUNK_FRAMES
    return max(least, min(most, CHUNK_BYTES // (36 * len(scene.whole.mesh.points))))


class _Service:
    """A writer and what it is told of.

    After a mistake it takes no more frames, as the run that made it would not have gone on; closing
    keeps those so far.
    """

    def __init__(self, pipe: Messages, ring: ByteRing, writer: StageWriter) -> None:
        self._pipe = pipe
        self._ring = ring
        self._writer = writer
        self._failed = False

    def follow(self) -> None:
        """Do as told until the stage is closed."""
        order = ""
        while order != "close":
            # converts frames while the run makes others, so that few are left at its end
            if not self._failed and not self._pipe.has_any():
                self._tried(self._writer.settle)
            order, *given = self._pipe.receive()
            if order == "frames":
                for place, size in given[0]:
                    self._write(self._ring.view(place, size))
                self._tell("read", len(given[0]))
            elif order == "large":
                self._write(memoryview(given[0]))
            elif order == "enter":
                self._tried(self._writer.__enter__, "entered")
            else:
                self._tried(self._writer.close, "closed")

    def _write(self, message: memoryview) -> None:
        if not self._failed:
            self._tried(partial(self._writer.write, unpacked(message)))

    def _tried(self, action: Callable[[], object], done: str | None = None) -> None:
        """Do something and tell that it is done, or what it raised instead."""
        try:
            action()
        except Exception as error:
            self._failed = True
            self._tell("raised", _movable(error))
        else:
            if done is not None:
                self._tell(done)

    def _tell(self, what: str, more: object = None) -> None:
        # whatever a run that is gone had told of is kept all the same
        with suppress(*GONE):
            self._pipe.send((what, more))


def _movable(error: Exception) -> Exception:
    """An error that the run can raise in its turn."""
    if isinstance(error, SoftBodyError):
        return error
    return OutputError(f"the stage could not be written ({type(error).__name__}: {error})")
