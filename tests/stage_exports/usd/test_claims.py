"""Two users of one path: writers of one process and of others, and those who recover."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from warp_softbody.errors import OutputError
from warp_softbody.stage_exports import StageWriter, read_take, recover, validate
from warp_softbody.stage_exports.usd.claims import folders_of
from warp_softbody.world.scene import Scene

ROOT = Path(__file__).parents[3]
OTHER = """
import sys
import numpy as np
from warp_softbody.body.character import Character
from warp_softbody.world.frame import ContactSample, Frame
from warp_softbody.body.mesh import TetMesh
from warp_softbody.world.scene import Scene
from warp_softbody.stage_exports import StageWriter

points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
mesh = TetMesh.from_arrays(points, [[0, 1, 2, 3]])
with StageWriter(sys.argv[1], Scene(character=Character(name="tet", mesh=mesh)),
                 chunk_frames=2) as stage:
    for index in range(5):
        stage.write(Frame(index=index, time=index / 30, positions=points + index,
            velocities=points, activations=np.zeros(0), fiber_points=np.zeros((0, 3)),
            contacts=ContactSample()))
    print("written", flush=True)
    sys.stdin.read()
"""


@pytest.fixture
def other(tmp_path: Path) -> Iterator[subprocess.Popen[str]]:
    """Another process in the middle of a take of `taken.usdc`: two chunks and a frame."""
    process = subprocess.Popen(
        [sys.executable, "-c", OTHER, str(tmp_path / "taken.usdc")],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), *sys.path])},
    )
    assert process.stdout is not None and process.stdout.readline() == "written\n"
    yield process
    process.kill()
    process.communicate()


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_a_path_that_another_process_writes_is_refused(
    scene: Scene, tmp_path: Path, other: subprocess.Popen[str]
) -> None:
    path = tmp_path / "taken.usdc"
    before = names(tmp_path)
    with pytest.raises(OutputError, match=f"process {other.pid} is writing it"):
        StageWriter(path, scene)
    with pytest.raises(OutputError, match="still being written"):
        recover(path)
    assert names(tmp_path) == before
    other.communicate("")
    assert len(read_take(path)) == 5 and names(tmp_path) == ["taken.usdc"]


def test_frames_of_a_killed_process_are_recovered(
    tmp_path: Path, other: subprocess.Popen[str]
) -> None:
    path = tmp_path / "taken.usdc"
    other.send_signal(signal.SIGKILL)
    other.wait()
    assert recover(path) == path
    take = read_take(path)
    np.testing.assert_array_equal(take.tet_points[:, 0, 0], [0.0, 1.0, 2.0, 3.0])
    assert validate(path) == [] and names(tmp_path) == ["taken.usdc"]


def test_a_killed_take_stays_until_a_new_one_is_whole(
    scene: Scene, make_frames: Any, tmp_path: Path, other: subprocess.Popen[str]
) -> None:
    path = tmp_path / "taken.usdc"
    other.kill()
    other.wait()
    with StageWriter(path, scene, chunk_frames=1) as stage:
        for frame in make_frames(scene, 3):
            stage.write(frame)
        assert len(folders_of(path)) == 2
    assert len(read_take(path)) == 3 and names(tmp_path) == ["taken.usdc"]


def test_the_second_of_two_writers_in_one_process_is_refused(
    scene: Scene, make_frames: Any, tmp_path: Path
) -> None:
    """Whenever it was made; once the first has closed the path is free."""
    path = tmp_path / "twice.usdc"
    first, second = (StageWriter(path, scene, chunk_frames=2) for _ in range(2))
    with first:
        for frame in make_frames(scene, 7):
            first.write(frame)
            with pytest.raises(OutputError, match="another writer of this process is writing it"):
                second.write(replace(frame, positions=frame.positions + 100.0))
            with pytest.raises(OutputError, match="another writer of this process is writing it"):
                StageWriter(path, scene)
        assert len(folders_of(path)) == 1
    assert len(read_take(path)) == 7 and names(tmp_path) == ["twice.usdc"]
    with StageWriter(path, scene) as third:
        third.write(next(make_frames(scene)))
    assert len(read_take(path)) == 1


def test_recover_leaves_a_file_of_somebody_else(
    scene: Scene, make_frames: Any, tmp_path: Path
) -> None:
    """One that appeared during the take; what the chunks hold is made elsewhere."""
    path, out = tmp_path / "take.usdc", tmp_path / "elsewhere" / "other.usda"
    out.parent.mkdir()
    writer = StageWriter(path, scene, chunk_frames=2)
    for frame in make_frames(scene, 5):
        writer.write(frame)
    path.write_bytes(b"precious")
    with pytest.raises(OutputError, match=r"another was written there.*recover.*--out OTHER"):
        writer.close()
    for place in (None, path):
        with pytest.raises(OutputError, match=r"take\.usdc' stays as it is"):
            recover(path, place)
    out.write_bytes(b"too")
    with pytest.raises(OutputError, match=r"other\.usda' stays as it is"):
        recover(path, out)
    assert path.read_bytes() == b"precious" and out.read_bytes() == b"too"
    out.unlink()
    assert recover(path, out) == out and len(read_take(out)) == 5
    assert path.read_bytes() == b"precious" and names(tmp_path) == ["elsewhere", "take.usdc"]


def test_a_take_that_begins_after_another_has_ended_replaces_it(
    scene: Scene, make_frames: Any, tmp_path: Path
) -> None:
    """Whenever its writer was made; unless it may not overwrite."""
    path = tmp_path / "next.usdc"
    later, careful = StageWriter(path, scene), StageWriter(path, scene, overwrite=False)
    for writer, count in ((StageWriter(path, scene), 3), (later, 5), (careful, 2)):
        for frame in make_frames(scene, count):
            writer.write(frame)
        if writer is careful:
            with pytest.raises(OutputError, match="another was written there"):
                writer.close()
        else:
            writer.close()
    assert len(read_take(path)) == 5


def test_a_live_take_is_not_recovered(scene: Scene, make_frames: Any, tmp_path: Path) -> None:
    path = tmp_path / "live.usdc"
    with StageWriter(path, scene, chunk_frames=2) as stage:
        for frame in make_frames(scene, 6):
            stage.write(frame)
            if frame.index == 4:
                with pytest.raises(OutputError, match="still being written"):
                    recover(path)
    assert len(read_take(path)) == 6


def test_links_are_not_followed(scene: Scene, make_frames: Any, tmp_path: Path) -> None:
    """Whatever stands where something is made beside the target, no other file is changed."""
    victim, folder = tmp_path / "victim", tmp_path / "elsewhere"
    victim.write_text("precious")
    folder.mkdir()
    work = tmp_path / "work"
    work.mkdir()
    path = work / "take.usdc"
    for name in (".writing.take.usdc", ".warp_softbody_probe", "take.usdc", ".take.usdc.part"):
        (work / name).symlink_to(victim)
    (work / ".take.usdc.chunks").symlink_to(folder)
    with StageWriter(path, scene, chunk_frames=2) as stage:
        for frame in make_frames(scene, 5):
            stage.write(frame)
    assert victim.read_text() == "precious" and names(folder) == []
    assert not path.is_symlink() and len(read_take(path)) == 5


def test_a_writer_that_is_dropped_leaves_nothing(
    scene: Scene, make_frames: Any, tmp_path: Path
) -> None:
    writer = StageWriter(tmp_path / "dropped.usdc", scene)
    writer.write(next(make_frames(scene)))
    del writer
    assert names(tmp_path) == []
