"""A disk without room: one sentence, an older file as it was, and nothing half-written."""

from __future__ import annotations

import errno
import resource
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from warp_softbody.atomic_files import replace_text
from warp_softbody.errors import OutputError
from warp_softbody.stage_exports import Movie, StageWriter, draw_picture, read_take, recover
from warp_softbody.stage_exports.usd import chunks
from warp_softbody.world.scene import Scene

Write = Callable[[Path, Scene, Any], None]


@contextmanager
def no_file_above(size: int) -> Iterator[None]:
    """No process of this one can make a file longer than so many bytes."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    former = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, former)


def movie(path: Path, scene: Scene, frames: Any) -> None:
    with Movie(path, scene, size=(320, 240)) as file:
        for frame in frames:
            file.write(frame)


def stage(path: Path, scene: Scene, frames: Any) -> None:
    with StageWriter(path, scene) as file:
        for frame in frames:
            file.write(frame)


def text(path: Path, scene: Scene, frames: Any) -> None:
    try:
        replace_text(path, "a" * 5000)
    except OSError as error:
        raise OutputError("written") from error


def picture(path: Path, scene: Scene, frames: Any) -> None:
    draw_picture(path, scene, next(frames), size=(320, 240))


@pytest.mark.parametrize(
    ("name", "write"),
    [
        ("a.mp4", movie),
        ("a.gif", movie),
        ("a.png", picture),
        ("a.usdc", stage),
        ("a.usda", stage),
        ("a.json", text),
    ],
)
def test_a_file_that_does_not_fit(
    scene: Scene, make_frames: Any, tmp_path: Path, name: str, write: Write
) -> None:
    path = tmp_path / name
    path.write_bytes(b"older")
    with no_file_above(2000), pytest.raises(OutputError, match=r"written|cannot write"):
        write(path, scene, make_frames(scene, 6))
    assert path.read_bytes() == b"older"
    assert [entry.name for entry in tmp_path.iterdir()] == [name]
    # with room all is well
    write(path, scene, make_frames(scene, 6))
    assert len(path.read_bytes()) > 2000


@pytest.mark.parametrize(
    ("name", "room", "sentence", "kept"),
    [
        # the stage that grows has room, a chunk has none
        ("a.usdc", 2, r"to its end \(No space left[^']*; it is a stage of the first 6 frames$", 6),
        ("a.usdc", 0, r"to its end \(No space left[^']*; it is a stage of the first 2 frames$", 2),
        # made of chunks at the end
        ("a.usda", 2, r"written \(No space left on device\); the closed chunks [^']*$", 4),
        ("a.usda", 0, r"written \(No space left on device\); no frame of the take is kept$", 0),
    ],
)
def test_one_sentence_tells_what_is_kept(
    scene: Scene,
    make_frames: Any,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    name: str,
    room: int,
    sentence: str,
    kept: int,
) -> None:
    """Room for so many chunks."""
    path = tmp_path / name
    stored = chunks._stored

    def full(layer: Any, place: Path) -> None:
        if place.name.startswith("frames_") and int(place.stem[7:]) >= 2 * room:
            raise OSError(errno.ENOSPC, "No space left on device")
        stored(layer, place)

    monkeypatch.setattr(chunks, "_stored", full)
    with (
        pytest.raises(OutputError, match=sentence),
        StageWriter(path, scene, chunk_frames=2) as one,
    ):
        for frame in make_frames(scene, 9):
            one.write(frame)
    monkeypatch.undo()
    if "chunks" in sentence:
        assert not path.exists()
        recover(path)
    assert [entry.name for entry in tmp_path.iterdir()] == [name] * (kept > 0)
    assert kept == 0 or len(read_take(path)) == kept
