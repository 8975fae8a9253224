"""A disk without room: one sentence, an older file as it was, and nothing half-written."""

from __future__ import annotations

import resource
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from warp_softbody.atomic_files import replace_text
from warp_softbody.errors import OutputError
from warp_softbody.stage_exports import Movie, StageWriter, draw_picture
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
