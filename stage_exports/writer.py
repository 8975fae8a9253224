"""Frames to a USD file, chunk by chunk."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType

import numpy as np

from warp_softbody import checks, input_kinds
from warp_softbody.errors import InputError, OutputError
from warp_softbody.frame import Frame
from warp_softbody.scene import Scene
from warp_softbody.stage_exports.bodies import staged_bodies
from warp_softbody.stage_exports.chunks import ChunkFolder
from warp_softbody.stage_exports.conventions import (
    EXTENSIONS,
    TIME_CODE_DIGITS,
    character_path,
    checked_target,
)
from warp_softbody.stage_exports.samples import TimedFrame, sample_layer
from warp_softbody.stage_exports.static import static_layer


class StageWriter:
    """Writes a take: `with StageWriter(path, scene) as stage: stage.write(frame)`.

    Frames wait in memory until a chunk is full; closed chunks survive a crash (see `recover`). At
    the end, also after an exception or Ctrl-C in the `with` body, the frames so far become one
    valid file that replaces an older one in a single step. Without a frame nothing is left behind.
    A new take of the same name lets go of chunks that a crashed one left: recover them first.
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
    ) -> None:
        """Check everything that can be checked before the first frame; create nothing.

        Args:
            path: target, ending in .usdc, .usda or .usd.
            scene: what the frames are snapshots of.
            fps: time codes per second; a frame stands at its own time times fps.
            overwrite: replace an existing file; otherwise it is an OutputError.
            metadata: kept in the stage's customLayerData, by name.
            chunk_frames: frames held in memory at most.
        """
        fps = checks.number("fps of a StageWriter", fps, above=0.0, unit="1/s")
        chunk_frames = checks.whole("chunk_frames of a StageWriter", chunk_frames, low=1)
        checks.truth("overwrite of a StageWriter", overwrite)
        checks.instance("scene of a StageWriter", scene, Scene)
        for character in scene.characters:
            character_path(character.name)
        self._path = checked_target(path, extensions=EXTENSIONS, overwrite=overwrite)
        self._scene = scene
        self._fps = fps
        self._metadata = _checked_metadata({} if metadata is None else metadata)
        self._chunk_frames = chunk_frames
        self._bodies = staged_bodies(scene)
        self._chunks = ChunkFolder(self._path)
        self._pending: list[TimedFrame] = []
        self._stored = 0
        self._last_time_code = -math.inf
        self._closed = False

    @property
    def path(self) -> Path:
        """Where the stage stands after closing."""
        return self._path

    def write(self, frame: Frame) -> None:
        """Add a frame; times must increase."""
        if self._closed:
            raise OutputError(f"{str(self._path)!r} is closed; no frame can be added")
        checks.instance("frame to write", frame, Frame)
        time_code = round(frame.time * self._fps, TIME_CODE_DIGITS)
        if not time_code > self._last_time_code:
            raise InputError(
                f"frame {frame.index} at {frame.time!r} s is not later than the last one"
            )
        self._check_arrays(frame)
        self._pending.append(TimedFrame(time_code, frame))
        self._last_time_code = time_code
        if len(self._pending) >= self._chunk_frames:
            self._flush()

    def close(self) -> None:
        """Merge the chunks into the target; harmless when closed already."""
        if self._closed:
            return
        if self._pending:
            self._flush()
        if self._stored:
            self._chunks.merge()
            self._chunks.remove()
        self._closed = True

    def __enter__(self) -> StageWriter:
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

    def _flush(self) -> None:
        """Close a chunk. The frames are let go last, so that an interrupt here loses none."""
        if not self._stored:
            static = static_layer(self._scene, self._bodies, self._fps, self._metadata)
            self._chunks.start(static)
        samples = sample_layer(self._bodies, self._pending)
        self._chunks.add(self._stored, samples)
        self._stored, self._pending = self._stored + len(self._pending), []

    def _check_arrays(self, frame: Frame) -> None:
        last, contacts = self._bodies[-1], frame.contacts
        nodes, touching = last.nodes.stop, len(contacts.points)
        # with one body it is clear whose contacts they are
        named = len(contacts.nodes) if last.alone else touching
        for name, array, shape in (
            ("positions", frame.positions, (nodes, 3)),
            ("velocities", frame.velocities, (nodes, 3)),
            ("activations", frame.activations, (last.segments.stop,)),
            ("fiber_points", frame.fiber_points, (last.vertices.stop, 3)),
            ("contact nodes", contacts.nodes, (named,)),
            ("contact modes", contacts.modes, (touching,)),
            ("contact forces", contacts.forces, (touching, 3)),
        ):
            if array.shape != shape:
                raise InputError(
                    f"frame {frame.index}: {name} must have the shape {shape}, got {array.shape}"
                )
            if not np.isfinite(array).all():
                raise InputError(f"frame {frame.index}: {name} holds a number that is not finite")
        if np.any((contacts.nodes < 0) | (contacts.nodes >= nodes)):
            raise InputError(f"frame {frame.index}: a contact node is not one of the {nodes} nodes")


def _checked_metadata(metadata: Mapping[str, str | float]) -> dict[str, str | float]:
    checked: dict[str, str | float] = {}
    for name, value in input_kinds.mapping("metadata of a StageWriter", metadata).items():
        input_kinds.name("a name in the metadata of a StageWriter", name)
        given = checks.plain(value)
        if isinstance(given, str):
            checked[name] = input_kinds.text(f"metadata {name!r}", given)
        elif isinstance(given, bool):
            checked[name] = given
        elif isinstance(given, int) and abs(given) < 2**63:
            checked[name] = given
        elif isinstance(given, float):
            checked[name] = given
        else:
            checks.refuse(f"metadata {name!r}", "text or a number", value)
    return checked
