"""Surfaces of USD stages: unit, up axis, transforms and handedness, as the stage says."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom
from trimesh import creation

import warp_softbody as wsb
from warp_softbody.cli import main
from warp_softbody.errors import MeshError
from warp_softbody.stage_exports import read_skin


@pytest.fixture
def stage(tmp_path: Path) -> Path:
    """A box of 20 x 40 x 80 cm, y up, left-handed, half of it by its transform, on its side."""
    path = tmp_path / "column.usda"
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    body = UsdGeom.Xform.Define(stage, "/body")
    body.AddScaleOp().Set(Gf.Vec3f(2.0, 2.0, 2.0))
    box = creation.box((10.0, 40.0, 20.0))
    mesh = UsdGeom.Mesh.Define(stage, "/body/box")
    mesh.CreatePointsAttr(box.vertices.tolist())
    mesh.CreateFaceVertexCountsAttr([3] * len(box.faces))
    mesh.CreateFaceVertexIndicesAttr(box.faces[:, ::-1].ravel().tolist())
    mesh.CreateOrientationAttr(UsdGeom.Tokens.leftHanded)
    stage.Save()
    return path


def test_a_stage_becomes_a_character(stage: Path) -> None:
    column = wsb.Character.from_surface(stage, tets=400)
    assert column.name == "column"
    np.testing.assert_allclose(np.ptp(column.mesh.points, axis=0), (0.2, 0.4, 0.8), atol=0.03)
    assert column.mesh.points[:, 2].min() == pytest.approx(0.0, abs=1e-6)
    assert column.mesh.volume == pytest.approx(0.2 * 0.4 * 0.8, rel=0.1)
    skin = wsb.Character.from_surface(read_skin(stage), name="column", tets=400)
    np.testing.assert_array_equal(skin.mesh.points, column.mesh.points)


def test_a_unit_may_be_given_in_place_of_the_stages(stage: Path) -> None:
    column = wsb.Character.from_surface(stage, height=1.6, tets=400)
    assert np.ptp(column.mesh.points[:, 2]) == pytest.approx(1.6, abs=0.06)


def test_stages_on_the_command_line(stage: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = stage.with_suffix(".char")
    assert main(["character", str(stage), "-o", str(out), "--tets", "400", "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert (facts["name"], facts["height"]) == ("column", pytest.approx(0.8, abs=0.03))


def test_a_stage_without_a_mesh_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "empty.usda"
    Usd.Stage.CreateNew(str(path)).Save()
    with pytest.raises(MeshError, match="holds no mesh"):
        wsb.Character.from_surface(path)
    with pytest.raises(MeshError, match="is not a USD file that can be read"):
        wsb.Character.from_surface(tmp_path / "none.usd")


def test_a_character_is_told_in_a_line(stage: Path) -> None:
    column = wsb.Character.from_surface(stage, tets=400)
    assert repr(column).startswith("Character(name='column', nodes=")
    assert len(repr(column)) < 100
