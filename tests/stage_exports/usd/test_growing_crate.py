"""A crate that grew holds what USD's own writer would have put into it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Sdf

from warp_softbody.stage_exports import StageWriter, read_take, validate
from warp_softbody.stage_exports.usd import growing_crate
from warp_softbody.stage_exports.usd.growing_crate import GrowingCrate
from warp_softbody.stage_exports.usd.merging import merge
from warp_softbody.stage_exports.usd.series import Series
from warp_softbody.world.scene import Scene


def as_text(path: Path) -> str:
    return str(Sdf.Layer.OpenAsAnonymous(str(path)).ExportToString())


def test_it_holds_what_merged_chunks_hold(scene: Scene, make_frames: Any, tmp_path: Path) -> None:
    path, merged = tmp_path / "take.usdc", tmp_path / "merged.usdc"
    with StageWriter(path, scene, chunk_frames=3) as stage:
        for frame in make_frames(scene, 9):
            stage.write(frame)
        assert merge(str(tmp_path / ".take.usdc.chunks"), str(merged)) == 9
    assert as_text(path) == as_text(merged)
    assert path.read_bytes() != merged.read_bytes()


@pytest.mark.parametrize("count", [1, 15, 16, 17, 20, 31, 60, 64, 300, 5000])
@pytest.mark.parametrize("largest", [0, 1, 40, 100, 20_000, 2**31 - 1])
def test_whole_numbers_come_back(tmp_path: Path, count: int, largest: int) -> None:
    rng = np.random.default_rng(count)
    path, name = tmp_path / "whole.usdc", "primvars:node"
    rows = [rng.integers(-largest, largest, count, np.int32, endpoint=True) for _ in range(3)]
    crate = GrowingCrate(path, Sdf.Layer.CreateAnonymous(), [Series("/a", name, rows)])
    crate.add([0.0, 1.0], [Series("/a", name, rows[:2])])
    crate.add([2.5], [Series("/a", name, rows[2:])])
    crate.finish()
    layer = Sdf.Layer.FindOrOpen(str(path))
    assert layer.ListTimeSamplesForPath("/a.primvars:node") == [0.0, 1.0, 2.5]
    for code, row in zip((0.0, 1.0, 2.5), rows, strict=True):
        np.testing.assert_array_equal(layer.QueryTimeSample("/a.primvars:node", code), row)


def test_what_comes_again_is_written_once(tmp_path: Path) -> None:
    rng = np.random.default_rng(2)
    large, small = (np.tile(rng.random((1, n, 3)), (50, 1, 1)).astype(np.float32) for n in (999, 9))
    small[::2] += 1.0
    given = [Series("/a", "points", large), Series("/b", "points", small)]
    crate = GrowingCrate(tmp_path / "again.usdc", Sdf.Layer.CreateAnonymous(), given)
    crate.add(range(50), given)
    crate.finish()
    size = (tmp_path / "again.usdc").stat().st_size
    assert size < large[0].nbytes + 2 * small[0].nbytes + 50 * 3 * 8 + 1500
    layer = Sdf.Layer.FindOrOpen(str(tmp_path / "again.usdc"))
    np.testing.assert_array_equal(layer.QueryTimeSample("/b.points", 48.0), small[48])
    np.testing.assert_array_equal(layer.QueryTimeSample("/a.points", 49.0), large[49])


def test_crates_of_another_kind_are_left_to_usd(
    scene: Scene, make_frames: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    grown, merged = tmp_path / "grown.usdc", tmp_path / "merged.usdc"
    for path in (grown, merged):
        with StageWriter(path, scene, chunk_frames=3) as stage:
            for frame in make_frames(scene, 7):
                stage.write(frame)
        monkeypatch.setattr(growing_crate, "VERSION", bytes((1, 0, 0)))
    assert as_text(grown) == as_text(merged)
    assert len(read_take(merged)) == 7 and validate(merged) == []
    assert sorted(path.name for path in tmp_path.iterdir()) == ["grown.usdc", "merged.usdc"]
