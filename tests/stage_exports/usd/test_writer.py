"""How a take reaches the disk: whole, repeatable, and despite what goes wrong on the way."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Usd

from warp_softbody.errors import InputError, OutputError
from warp_softbody.stage_exports import StageWriter, read_take, recover, validate
from warp_softbody.stage_exports.usd.merging import merge
from warp_softbody.world.scene import Scene


def write(path: Path, scene: Scene, make_frames: Any, count: int = 7, **options: Any) -> Path:
    with StageWriter(path, scene, **options) as stage:
        for frame in make_frames(scene, count):
            stage.write(frame)
    return path


@pytest.mark.parametrize("extension", [".usdc", ".usda", ".usd"])
def test_repeated_takes_are_the_same_bytes(
    scene: Scene, make_frames: Any, tmp_path: Path, extension: str
) -> None:
    metadata = {"scene": "sway", "time_step": 1 / 120}
    files = [tmp_path / f"{name}{extension}" for name in ("first", "second")]
    first, second = (write(path, scene, make_frames, metadata=metadata) for path in files)
    assert first.read_bytes() == second.read_bytes()
    assert read_take(first).metadata == metadata


@pytest.mark.parametrize("chunk_frames", [1, 3, 7])
def test_chunks_do_not_show(
    scene: Scene, make_frames: Any, tmp_path: Path, chunk_frames: int
) -> None:
    whole = write(tmp_path / "whole.usdc", scene, make_frames)
    parts = write(tmp_path / "parts.usdc", scene, make_frames, chunk_frames=chunk_frames)
    assert whole.read_bytes() == parts.read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["parts.usdc", "whole.usdc"]


def test_no_more_than_a_chunk_waits_in_memory(
    scene: Scene, make_frames: Any, tmp_path: Path
) -> None:
    folder = tmp_path / ".long.usdc.chunks"
    with StageWriter(tmp_path / "long.usdc", scene, chunk_frames=4) as stage:
        for frame in make_frames(scene, 9):
            stage.write(frame)
        names = sorted(path.name for path in folder.glob("frames_*"))
        assert names == ["frames_00000000.usdc", "frames_00000004.usdc"]
    assert not folder.exists()


@pytest.mark.parametrize("extension", [".usdc", ".usda", ".usdz"])
def test_long_takes_are_merged_part_by_part(
    scene: Scene, make_frames: Any, tmp_path: Path, extension: str
) -> None:
    whole, parts = (tmp_path / f"{name}{extension}" for name in ("whole", "parts"))
    with StageWriter(tmp_path / "long.usdc", scene, chunk_frames=2) as stage:
        for frame in make_frames(scene, 9):
            stage.write(frame)
        folder = tmp_path / ".long.usdc.chunks"
        kept = sorted(path.name for path in folder.iterdir())
        assert merge(str(folder), str(whole)) == 8
        assert merge(str(folder), str(parts), group_bytes=1) == 8
        assert sorted(path.name for path in folder.iterdir()) == kept
    first, second = (
        Usd.Stage.Open(str(path)).Flatten(addSourceFileComment=False) for path in (whole, parts)
    )
    assert first.ExportToString() == second.ExportToString()
    assert validate(parts) == validate(whole)


def test_a_stage_begun_before_its_frames_is_the_same(
    scene: Scene, make_frames: Any, tmp_path: Path
) -> None:
    """And goes with its folder where no frame comes."""
    begun, not_begun = tmp_path / "begun.usdc", tmp_path / "not_begun.usdc"
    for path in (begun, not_begun):
        with StageWriter(path, scene) as stage:
            if path == begun:
                stage.settle()
                assert (tmp_path / ".begun.usdc.chunks" / "grown.usdc").exists()
            for frame in make_frames(scene, 3):
                stage.write(frame)
    assert begun.read_bytes() == not_begun.read_bytes()
    with StageWriter(tmp_path / "empty.usdc", scene) as stage:
        stage.settle()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["begun.usdc", "not_begun.usdc"]


@pytest.mark.parametrize("kind", [RuntimeError, KeyboardInterrupt])
def test_an_interrupted_take_is_a_valid_stage(
    scene: Scene, make_frames: Any, tmp_path: Path, kind: type[BaseException]
) -> None:
    path = tmp_path / "cut.usdc"
    with pytest.raises(kind), StageWriter(path, scene, chunk_frames=2) as stage:
        for frame in make_frames(scene, 9):
            if frame.index == 5:
                raise kind("enough")
            stage.write(frame)
    assert len(read_take(path)) == 5
    assert validate(path) == []


def test_without_a_frame_nothing_is_left(scene: Scene, tmp_path: Path) -> None:
    with StageWriter(tmp_path / "none.usdc", scene):
        pass
    with pytest.raises(RuntimeError), StageWriter(tmp_path / "none.usdc", scene):
        raise RuntimeError("before the first frame")
    assert list(tmp_path.iterdir()) == []


def test_an_older_file_stays_until_the_new_one_is_whole(
    scene: Scene, make_frames: Any, tmp_path: Path
) -> None:
    path = write(tmp_path / "twice.usdc", scene, make_frames)
    older = path.read_bytes()
    with StageWriter(path, scene, chunk_frames=1) as stage:
        stage.write(next(make_frames(scene)))
        assert path.read_bytes() == older
    assert len(read_take(path)) == 1


def test_recover_makes_a_stage_of_closed_chunks(
    scene: Scene, make_frames: Any, tmp_path: Path
) -> None:
    path = tmp_path / "crash.usdc"
    writer = StageWriter(path, scene, chunk_frames=3)
    for frame in make_frames(scene, 8):
        writer.write(frame)
    (tmp_path / ".crash.usdc.chunks" / ".warp-softbody-half").mkdir()
    assert not path.exists()
    with pytest.raises(OutputError, match="still being written"):
        recover(path)
    del writer
    assert recover(path) == path
    assert len(read_take(path)) == 6
    assert validate(path) == []
    assert [entry.name for entry in tmp_path.iterdir()] == ["crash.usdc"]
    with pytest.raises(OutputError, match="nothing to recover"):
        recover(path)


FULL_DISK = """
import resource, signal, sys
import numpy as np
from warp_softbody.body.character import Character
from warp_softbody.errors import OutputError
from warp_softbody.world.frame import ContactSample, Frame
from warp_softbody.body.mesh import TetMesh
from warp_softbody.world.scene import Scene
from warp_softbody.stage_exports import StageWriter

mesh = TetMesh.from_arrays([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 1, 2, 3]])
scene = Scene(character=Character(name="tet", mesh=mesh))
rng = np.random.default_rng(1)
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (48_000, 48_000))
try:
    with StageWriter(sys.argv[1], scene, chunk_frames=50) as stage:
        for index in range(350):
            stage.write(Frame(index=index, time=index / 30, positions=rng.random((4, 3)),
                velocities=rng.random((4, 3)), activations=np.zeros(0),
                fiber_points=np.zeros((0, 3)), contacts=ContactSample()))
except OutputError as error:
    print("OutputError:", error)
"""


def test_a_full_disk_keeps_every_closed_chunk(tmp_path: Path) -> None:
    """No file may pass 48 kB: each chunk fits, the merged stage does not."""
    path = tmp_path / "full.usdc"
    path.write_bytes(b"older")
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run(
        [sys.executable, "-c", FULL_DISK, str(path)],
        capture_output=True,
        text=True,
        env=environment,
        check=False,
    )
    assert done.stdout.startswith("OutputError:"), done.stdout + done.stderr
    assert "recover" in done.stdout
    assert path.read_bytes() == b"older"
    assert len(read_take(recover(path))) == 350


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("take.abc", "must end in one of"),
        ("take", "must end in one of"),
        ("folder.usdc", "it is a folder"),
        ("missing/take.usdc", "there is no folder"),
        ("file/take.usdc", "file' is a file and no folder"),
    ],
)
def test_bad_targets_are_refused_at_once(
    scene: Scene, tmp_path: Path, name: str, sentence: str
) -> None:
    (tmp_path / "folder.usdc").mkdir()
    (tmp_path / "file").touch()
    with pytest.raises(OutputError, match=sentence):
        StageWriter(tmp_path / name, scene)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "folder.usdc"]


@pytest.mark.skipif(not Path("/proc/self").is_dir(), reason="needs a folder nobody may write in")
def test_an_unwritable_folder_is_refused_at_once(scene: Scene) -> None:
    with pytest.raises(OutputError, match="cannot write in the folder"):
        StageWriter("/proc/self/take.usdc", scene)


def test_an_existing_file_can_be_protected(scene: Scene, make_frames: Any, tmp_path: Path) -> None:
    path = write(tmp_path / "kept.usdc", scene, make_frames)
    with pytest.raises(OutputError, match="overwrite is off"):
        StageWriter(path, scene, overwrite=False)


def test_frames_that_do_not_fit_are_refused(scene: Scene, make_frames: Any, tmp_path: Path) -> None:
    first, second = make_frames(scene, 2)
    with StageWriter(tmp_path / "strict.usdc", scene) as stage:
        stage.write(first)
        with pytest.raises(InputError, match="not later"):
            stage.write(first)
        with pytest.raises(InputError, match="positions must have the shape"):
            stage.write(replace(second, positions=np.zeros((1, 3))))
        with pytest.raises(InputError, match="velocities holds a number that is not finite"):
            stage.write(replace(second, velocities=second.velocities * np.nan))
        stage.write(second)
    assert len(read_take(tmp_path / "strict.usdc")) == 2
    with pytest.raises(OutputError, match="is closed"):
        stage.write(second)


def test_odd_settings_are_refused(scene: Scene, tmp_path: Path) -> None:
    path = tmp_path / "take.usdc"
    with pytest.raises(InputError, match="fps"):
        StageWriter(path, scene, fps=0.0)
    with pytest.raises(InputError, match="chunk_frames"):
        StageWriter(path, scene, chunk_frames=0)
    with pytest.raises(InputError, match="metadata 'when'"):
        StageWriter(path, scene, metadata={"when": object()})  # type: ignore[dict-item]
    ground = Scene(character=replace(scene.character, name="Ground"))
    with pytest.raises(InputError, match="cannot be named 'Ground'"):
        StageWriter(path, ground)


def test_time_codes_follow_the_clock_of_the_stage(
    scene: Scene, make_frames: Any, tmp_path: Path
) -> None:
    path = write(tmp_path / "film.usdc", scene, make_frames, count=4, fps=24.0)
    stage = Usd.Stage.Open(str(path))
    codes = stage.GetPrimAtPath("/World/block/Skin").GetAttribute("points").GetTimeSamples()
    np.testing.assert_allclose(codes, [0.0, 0.8, 1.6, 2.4], atol=1e-9)
    np.testing.assert_allclose(read_take(path).times, np.arange(4) / 30, atol=1e-9)
