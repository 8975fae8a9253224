"""What a writer takes and keeps: copies of frames of its scene, in order, while it is open."""

from __future__ import annotations

import math
import threading
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from warp_softbody.errors import InputError, OutputError
from warp_softbody.stage_exports import StageWriter, read_take, validate
from warp_softbody.world.frame import ContactSample
from warp_softbody.world.scene import Scene


def test_frames_are_copied(scene: Scene, make_frames: Any, tmp_path: Path) -> None:
    path = tmp_path / "copied.usdc"
    kept = [frame.positions.copy() for frame in make_frames(scene, 5)]
    with StageWriter(path, scene) as stage:
        for frame in make_frames(scene, 5):
            stage.write(frame)
            frame.positions[:] = 0.0
            frame.contacts.points[:] = np.nan
    np.testing.assert_allclose(read_take(path).tet_points, kept, atol=1e-6)
    assert validate(path) == []


def test_what_is_no_frame_of_the_scene_is_refused(
    scene: Scene, make_frames: Any, tmp_path: Path
) -> None:
    first, frame = make_frames(scene, 2)
    one = np.zeros((1, 3))
    wrong = ContactSample(points=one, modes=np.array([7]), forces=one)
    halves = ContactSample(points=one, modes=np.array([1.5]), forces=one)
    with StageWriter(tmp_path / "strict.usdc", scene) as stage:
        stage.write(first)
        short, far = frame.positions[:5], frame.velocities + 1e300
        two = replace(wrong, modes=np.zeros(2, int))
        cases: list[tuple[dict[str, Any], str]] = [
            ({"time": math.nan}, "time must be a finite number of s"),
            ({"time": math.inf}, "time must be a finite number of s"),
            ({"time": -1.0}, "not later than the last one, which is at 0 s"),
            ({"positions": short}, "positions must have the shape"),
            ({"positions": [["a"]]}, "positions must be an array"),
            ({"velocities": far}, "beyond single precision"),
            ({"contacts": wrong}, r"contact modes must be from \[0, 1, 2\], got \[7\]"),
            ({"contacts": halves}, "contact modes must be whole numbers"),
            ({"patches": two}, "patch modes must"),
        ]
        for change, sentence in cases:
            with pytest.raises(InputError, match=sentence):
                stage.write(replace(frame, **change))
        with pytest.raises(InputError, match="must be a Frame, not 'frame'"):
            stage.write("frame")  # type: ignore[arg-type]
        stage.write(frame)
    assert len(read_take(tmp_path / "strict.usdc")) == 2


def test_a_closed_writer_says_so(scene: Scene, make_frames: Any, tmp_path: Path) -> None:
    path = tmp_path / "closed.usdc"
    stage = StageWriter(path, scene)
    stage.write(next(make_frames(scene)))
    stage.close()
    written = path.read_bytes()
    stage.close()
    with pytest.raises(OutputError, match="is closed; no frame can be added"):
        stage.write(next(make_frames(scene)))
    with pytest.raises(OutputError, match="is closed"), stage:
        pass
    assert path.read_bytes() == written


def test_threads_may_share_a_writer(scene: Scene, make_frames: Any, tmp_path: Path) -> None:
    """Frames of two threads arrive each once, or are refused because a later one came before."""
    path = tmp_path / "shared.usdc"
    refused: list[str] = []
    frames = iter(list(make_frames(scene, 60)))
    with StageWriter(path, scene, chunk_frames=2) as stage:

        def write() -> None:
            for frame in frames:
                try:
                    stage.write(frame)
                except InputError as error:
                    refused.append(str(error))

        threads = [threading.Thread(target=write) for _ in range(2)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(timeout=60.0)
            assert not thread.is_alive()
    assert len(read_take(path)) == 60 - len(refused)
    assert all("not later than the last one" in sentence for sentence in refused)
    assert validate(path) == []
