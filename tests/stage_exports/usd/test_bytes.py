"""Long stages are little more than what moves in them, in single precision."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.stage_export import measured, raw_bytes, swaying
from warp_softbody import scenes
from warp_softbody.stage_exports import StageWriter

SHARE = 1.05
"""Of positions, velocities and forces: what else there is are activations and contact modes."""


def written(name: str, frames: int, folder: Path) -> int:
    """Bytes of a stage of so many frames, no two of which are alike."""
    scene, path = scenes.make(name).scene, folder / f"{frames}.usdc"
    with StageWriter(path, scene) as stage:
        for index in range(frames):
            stage.write(swaying(scene, index, 30.0))
    return path.stat().st_size


@pytest.mark.parametrize("name", ["walk-x", "balance-i"])
def test_a_frame_more_is_hardly_more_than_what_moves(name: str, tmp_path: Path) -> None:
    more = written(name, 160, tmp_path) - written(name, 40, tmp_path)
    assert 1.0 < more / (120 * raw_bytes(scenes.make(name).scene)) < SHARE


def test_the_benchmark_of_stages_opens_what_it_has_written(tmp_path: Path) -> None:
    row = measured("drop-block", 8, tmp_path)
    assert row["frames"] == 8 and float(row["of raw"]) > 1.0
    assert len(row["ms a frame, by quarter"].split()) == 4
    assert float(row["without mapped files, MB"]) > 0.0
