"""A `StageWriter` writes frames to a USD file, chunk by chunk."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from threading import RLock
from types import TracebackType
from typing import Any

import numpy as np

from warp_softbody.errors import OutputError
from warp_softbody.inputs import checks
from warp_softbody.stage_exports.bodies import staged_bodies
from warp_softbody.stage_exports.camera import Camera
from warp_softbody.stage_exports.camera_paths import FOLLOW, CameraChoice, camera_path
from warp_softbody.stage_exports.conventions import EXTENSIONS, checked_target
from warp_softbody.stage_exports.usd.chunks import USD, ChunkFolder
from warp_softbody.stage_exports.usd.frame_checks import checked_time_code, owned
from warp_softbody.stage_exports.usd.merging import reason
from warp_softbody.stage_exports.usd.physics_names import PROFILES, Profile
from warp_softbody.stage_exports.usd.samples import SampleLayer, TimedFrame, all_series, rest_series
from warp_softbody.stage_exports.usd.scene_checks import checked_metadata, checked_static_layer
from warp_softbody.stage_exports.usd.series import Series
from warp_softbody.stage_exports.usd.skin_looks import texture_files
from warp_softbody.stage_exports.usd.surroundings import ASPECT
from warp_softbody.stage_exports.usd.textures import FOLDER
from warp_softbody.world.frame import Frame
from warp_softbody.world.scene import Scene

LEAST_PAUSE = 1.0
"""s from one chunk to the next that is closed only because there is time for it."""


class StageWriter:
    """Writes frames as a USD stage: `with StageWriter(path, scene) as stage: stage.write(frame)`.

    Frames are copied and wait in memory until a chunk is full; closed chunks survive a crash (see
    `recover`). At the end, also after an exception or Ctrl-C in the `with` body, the frames so far
    become one valid file that replaces an older one in a single step. Without a frame nothing is
    left behind. A finished take lets go of chunks that a crashed one of its name left.

    A path that another writer has begun to write, in this process or another one, is refused. A
    writer may be shared by threads; the times of the frames must increase all the same.
    """

    def __init__(
        self,
        path: str | Path,
        scene: Scene,
        *,
        fps: float = 30.0,
        overwrite: bool = True,
        metadata: Mapping[str, str | float] | None = None,
        chunk_frames: int = 120,
        camera: CameraChoice = FOLLOW,
        physics: Profile = "newton",
    ) -> None:
        """Check everything that can be checked before the first frame; leave nothing on the disk.

        Args:
            path: target, ending in .usdc, .usda, .usd or .usdz.
            scene: what the frames are snapshots of.
            fps: time codes per second; a frame stands at its own time times fps.
            overwrite: replace an existing file; otherwise it is an OutputError.
            metadata: kept in the stage's customLayerData, by name.
            chunk_frames: frames held in memory at most.
            camera: "follow" keeps the bodies in the picture, "still" frames the start pose; or a
                `Camera`, or the place (x, y, z) m of one that looks at the start pose.
            physics: names under which other programs find what the bodies are made of: "newton",
                "omni" or "none" (`physics_names.py`).

        Raises:
            InputError: an option or a part of the scene cannot be stored.
            OutputError: the path cannot be written, or another writer writes it.
        """
        fps = checks.number("fps of a StageWriter", fps, above=0.0, unit="1/s")
        chunk_frames = checks.whole("chunk_frames of a StageWriter", chunk_frames, low=1)
        checks.choice("physics of a StageWriter", physics, PROFILES)
        checks.truth("overwrite of a StageWriter", overwrite)
        checks.instance("scene of a StageWriter", scene, Scene)
        self._fps = fps
        self._path = checked_target(path, extensions=EXTENSIONS, overwrite=overwrite)
        self._bodies = staged_bodies(scene)
        self._chunk_frames = chunk_frames
        kept = checked_metadata({} if metadata is None else metadata)
        start = np.asarray(scene.whole.mesh.points)
        self._camera = camera_path("camera of a StageWriter", camera, start, ASPECT)
        view = camera_path("camera of a StageWriter", camera, start, ASPECT).at(0.0, start)
        self._static: Any = checked_static_layer(
            scene, self._bodies, self._fps, kept, view, physics, self._path
        )
        self._at_rest = rest_series(self._bodies, view if self._camera.moves else None)
        self._chunks = ChunkFolder(self._path, overwrite=overwrite)
        self._pending: list[TimedFrame] = []
        self._stored = 0
        # parts of a chunk: their time codes and what moves
        self._held: tuple[tuple[list[float], list[Series]], ...] = ()
        self._last_time_code = -math.inf
        self._flushed = time.monotonic()
        self._closed = False
        self._lock = RLock()

    @property
    def path(self) -> Path:
        """Where the stage stands after closing."""
        return self._path

    def write(self, frame: Frame) -> None:
        """Add a copy of a frame; times must increase.

        Raises:
            InputError: the frame is not one of this scene, or not later than the last one.
            OutputError: the writer is closed, or a chunk could not be written: it is closed then,
                and the sentence says what is kept.
        """
        checks.instance("frame to write", frame, Frame)
        with self._lock:
            self._require_open()
            time_code = checked_time_code(frame, self._fps, self._last_time_code)
            own = owned(frame, self._bodies)
            self._chunks.begin()
            view = self._view(time_code, own) if self._camera.moves else None
            self._pending.append(TimedFrame(time_code, own, view))
            self._last_time_code = time_code
            if self._waiting >= self._chunk_frames:
                with self._closing():
                    self._flush()

    def settle(self) -> None:
        """Do what can be done before the end, for a caller who has time: nothing depends on it.

        Raises:
            OutputError: as `write` raises it.
        """
        with self._lock:
            if self._closed:
                return
            with self._closing():
                if self._chunks.begun:
                    self._prepare()
                self._settle()
                self._chunks.to_disk()
                rested = time.monotonic() - self._flushed >= LEAST_PAUSE
                if rested and 2 * self._waiting >= self._chunk_frames:
                    self._flush()

    def close(self) -> None:
        """Merge the chunks into the target; a second call does nothing.

        Raises:
            OutputError: the stage could not be written; closed chunks are kept for `recover`.
        """
        with self._lock:
            if self._closed:
                return
            try:
                self._settle()
                if self._frames:
                    self._chunks.finish(self._stored, self._samples if self._held else None)
            except OutputError:
                self._closed = True
                raise
            finally:
                if self._closed or not self._frames:
                    self._chunks.leave()
            self._closed = True

    def abandon(self) -> None:
        """End without a stage; all frames so far are kept for `recover`, if the disk takes them."""
        with self._lock:
            if self._closed:
                return
            self._closed = True
            with suppress(OutputError):
                if self._pending or self._held:
                    self._flush()
            self._chunks.leave()

    def __enter__(self) -> StageWriter:
        """Write inside the body; from here on no other writer may write this path."""
        with self._lock:
            self._require_open()
            self._chunks.begin()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Keep the frames so far, whatever ended the body."""
        self.close()

    @contextmanager
    def _closing(self) -> Iterator[None]:
        """Where a disk is full, close at once, so that one sentence can say what is kept."""
        try:
            yield
        except OutputError as error:
            self.close()
            if not self._frames:
                raise
            cause = error.__cause__ or error
            raise OutputError(
                f"{str(self._path)!r} could not be written to its end "
                f"({reason(cause)}); it is a stage of the first {self._frames} frames"
            ) from cause

    def _require_open(self) -> None:
        if self._closed:
            raise OutputError(f"{str(self._path)!r} is closed; no frame can be added")

    @property
    def _frames(self) -> int:
        """Those that are stored or converted."""
        return self._stored + sum(len(codes) for codes, _ in self._held)

    @property
    def _waiting(self) -> int:
        """Frames that are not in a closed chunk."""
        return self._frames - self._stored + len(self._pending)

    def _view(self, time_code: float, frame: Frame) -> Camera:
        return self._camera.at(time_code / self._fps, frame.positions)

    def _prepare(self) -> None:
        """Store what does not move, and begin the stage, which needs no frame."""
        if self._static is None:
            return
        textures = texture_files(self._bodies, FOLDER.format(self._path.stem))
        self._chunks.start(self._static, textures)
        self._chunks.grow(0, [], self._at_rest)
        self._static = None

    def _settle(self) -> None:
        """Convert what waits. The frames are let go last, so that an interrupt here loses none."""
        if not self._pending:
            return
        self._prepare()
        codes = [own.time_code for own in self._pending]
        series = all_series(self._bodies, self._pending)
        self._chunks.grow(self._frames, codes, series)
        self._held += ((codes, series),)
        self._pending = []

    def _flush(self) -> None:
        """Close a chunk; one that an interrupt leaves unfinished is closed once more."""
        self._settle()
        self._chunks.add(self._stored, self._samples())
        self._stored, self._held = self._frames, ()
        self._flushed = time.monotonic()

    def _samples(self) -> Any:
        """The frames that wait for their chunk, as a layer."""
        samples = SampleLayer()
        with USD:
            for codes, series in self._held:
                samples.add(codes, series)
        return samples.layer
