"""What would fail when the first chunk is written fails when the writer is made."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from warp_softbody.errors import InputError, OutputError
from warp_softbody.stage_exports import Movie, StageWriter
from warp_softbody.world.scene import Scene


def forced(scene: Scene, **fields: Any) -> Scene:
    """A scene whose character holds what its own checks may refuse."""
    character = replace(scene.character)
    for name, value in fields.items():
        object.__setattr__(character, name, value)
    return replace(scene, character=character)


@pytest.mark.parametrize("color", ["red", (1.0, 0.0), (1.0, "a", 0.0), (1.0, float("nan"), 0.0), 3])
def test_a_color_that_is_none(scene: Scene, tmp_path: Path, color: Any) -> None:
    with pytest.raises(InputError, match="'block': color must be three finite numbers"):
        StageWriter(tmp_path / "take.usdc", forced(scene, color=color))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["a" * 5000, "a\ud800", "a/b", "a b", "Ground", ""])
def test_a_name_that_cannot_be_one_of_a_prim(scene: Scene, tmp_path: Path, name: str) -> None:
    with pytest.raises(InputError):
        StageWriter(tmp_path / "take.usdc", forced(scene, name=name))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "metadata", [{"a": "\ud800"}, {"a": 2**70}, {3: "a"}, {"": 1.0}, {"a": "b\0c"}, {"a": None}]
)
def test_metadata_that_cannot_be_kept(scene: Scene, tmp_path: Path, metadata: Any) -> None:
    with pytest.raises(InputError, match="metadata"):
        StageWriter(tmp_path / "take.usdc", scene, metadata=metadata)


@pytest.mark.parametrize(
    ("options", "sentence"),
    [({"fps": "30"}, "fps"), ({"fps": float("inf")}, "fps"), ({"chunk_frames": 2.5}, "chunk")],
)
def test_options_of_a_wrong_type(
    scene: Scene, tmp_path: Path, options: dict[str, Any], sentence: str
) -> None:
    with pytest.raises(InputError, match=sentence):
        StageWriter(tmp_path / "take.usdc", scene, **options)


def test_targets_that_cannot_be_written(scene: Scene, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.usdc")
    for name, sentence in (
        ("pipe.usdc", "it is not a regular file"),
        ("a" * 300 + ".usdc", "too long"),
        # the folder of chunks beside it has a longer name
        ("a" * 250 + ".usdc", "File name too long"),
        ("a\ud800.usdc", "that the file system can hold"),
        ("a\0.usdc", "path of a file to write must be"),
    ):
        with pytest.raises((InputError, OutputError), match=sentence):
            StageWriter(tmp_path / name, scene)
    with pytest.raises(InputError, match="must be the path of a file, not 3"):
        StageWriter(3, scene)  # type: ignore[arg-type]
    with pytest.raises(OutputError, match="it is not a regular file"):
        os.mkfifo(tmp_path / "pipe.gif")
        Movie(tmp_path / "pipe.gif", scene)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["pipe.gif", "pipe.usdc"]
