"""The passive scenes, run from the command line and measured from their stages."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from pxr import Usd, UsdGeom

from warp_softbody.cli import main
from warp_softbody.stage_exports import body_names, draw_take, measure, read_take, validate
from warp_softbody.stage_exports.measures import Measures
from warp_softbody.stage_exports.usd.reader import Take
from warp_softbody.world.height_field import HeightField
from warp_softbody.world.triangle_ground import TriangleGround


def run(folder: Path, scene: str, *options: str) -> tuple[Take, Measures]:
    """A run's stage, which has to be valid, finite and without inverted tets."""
    stage = folder / "take.usdc"
    assert main(["run", scene, "--out", str(stage), "--quiet", *options]) == 0
    assert validate(stage) == []
    take = read_take(stage)
    measures = measure(take)
    assert measures.finite.all()
    assert measures.smallest_volume_ratio.min() > 0.0
    return take, measures


def test_dropped_block_slides_to_rest(tmp_path: Path) -> None:
    take, measures = run(tmp_path, "drop-block")
    assert measures.penetration.max() < 1e-4
    assert np.linalg.norm(take.velocities[-1], axis=1).max() < 1e-4
    assert measures.centre_of_mass[-1, 0] > 0.09


@pytest.mark.parametrize(("degrees", "slides"), [(26.0, False), (27.1, True)])
def test_slope_decides_by_half_a_degree(degrees: float, slides: bool, tmp_path: Path) -> None:
    """The angle of friction 0.5 is 26.57 degrees."""
    settings = ["--set", f"slope_degrees={degrees}", "--set", "friction=0.5"]
    _, measures = run(tmp_path, "slope", *settings)
    later = measures.centre_of_mass[measures.times >= 0.5]
    moved = float(np.linalg.norm(later[-1] - later[0]))
    # 0.09 m/s^2 for the second and a half after half a second
    assert (moved > 0.05) if slides else (moved < 1e-4)
    assert measures.penetration.max() < 1e-4


def test_soft_ball_rolls_down_the_stairs(tmp_path: Path) -> None:
    """From the upper landing to the lower one, and never through."""
    take, measures = run(tmp_path, "stairs")
    assert isinstance(take.ground, TriangleGround)
    start, end = measures.centre_of_mass[0], measures.centre_of_mass[-1]
    assert start[2] - end[2] == pytest.approx(0.5, abs=0.05)
    assert end[0] > 1.4
    assert measures.penetration.max() < 1e-4
    # it rolls: the node that starts on top is below the centre in between
    top = int(take.rest[:, 2].argmax())
    assert (take.tet_points[:, top, 2] < measures.centre_of_mass[:, 2] - 0.1).any()
    picture = draw_take(tmp_path / "stairs.png", take, count=2, columns=2, size=(96, 72))
    assert picture.is_file()


def test_heavy_mat_lies_on_rough_ground(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """With some 500 contacts at once, steps converge, the mat rests, and its weight is carried."""
    stage = tmp_path / "take.usdc"
    assert main(["run", "rough-ground", "--out", str(stage), "--json", "--fps", "10"]) == 0
    summary = json.loads(capsys.readouterr().out)
    # landing is where every node changes its mode in a few steps
    assert summary["unconverged_steps"] <= 0.02 * 2.0 / summary["time_step"]
    assert validate(stage) == []
    take = read_take(stage)
    assert isinstance(take.ground, HeightField)
    contacts = take.contacts[-1]
    assert len(contacts.points) >= 500
    weight = 1500.0 * 1.0 * 1.0 * 0.05 * 9.81
    np.testing.assert_allclose(contacts.forces.sum(axis=0), [0, 0, weight], atol=1e-3 * weight)
    measures = measure(take)
    assert measures.penetration[-1] < 1e-4
    opened = Usd.Stage.Open(str(stage))
    mesh = UsdGeom.Mesh(opened.GetPrimAtPath("/World/Ground"))
    heights = np.array(mesh.GetPointsAttr().Get())[:, 2]
    np.testing.assert_allclose(heights, take.ground.heights.ravel(), atol=1e-8)
    assert len(mesh.GetFaceVertexCountsAttr().Get()) == 2 * 60 * 60


def test_cubes_come_to_rest_as_a_stack(tmp_path: Path) -> None:
    """Each bears those above it, none leans, and no node is in another cube or the floor."""
    run(tmp_path, "stack")
    takes = [read_take(tmp_path / "take.usdc", name) for name in body_names(tmp_path / "take.usdc")]
    assert [take.name for take in takes] == ["cube_0", "cube_1", "cube_2"]
    weight = 1000.0 * 0.3**3 * 9.81
    for level, take in enumerate(takes):
        measures = measure(take)
        assert measures.tilt[-1] < 1.0
        assert measures.penetration.max() < 1e-4
        assert np.linalg.norm(take.velocities[-1], axis=1).max() < 5e-3
        # a sway of 5 mm/s with some 2 Hz is 0.6 % of gravity
        if level == 0:
            below = take.contacts[-1].points[:, 2] < 1e-4
            carried = take.contacts[-1].forces[below, 2].sum()
            assert carried == pytest.approx(3.0 * weight, rel=0.01)
