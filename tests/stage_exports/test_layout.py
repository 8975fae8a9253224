"""What stands where in an exported stage, read back with USD."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Kind, Usd, UsdGeom, UsdLux, UsdShade

from warp_softbody.stage_exports import StageWriter
from warp_softbody.world.scene import Scene


@pytest.fixture
def stage(write_take: Any) -> Any:
    return Usd.Stage.Open(str(write_take()))


def test_root_metadata(stage: Any) -> None:
    assert UsdGeom.GetStageUpAxis(stage) == "Z"
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1.0
    assert stage.GetTimeCodesPerSecond() == stage.GetFramesPerSecond() == 30.0
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (0.0, 5.0)
    assert stage.GetDefaultPrim().GetPath() == "/World"


def test_model_hierarchy(stage: Any) -> None:
    body = stage.GetPrimAtPath("/World/block")
    assert Usd.ModelAPI(body).GetKind() == Kind.Tokens.component
    assert body.IsModel() and stage.GetPrimAtPath("/World").IsGroup()


def test_skin_is_the_compacted_surface(stage: Any, scene: Scene) -> None:
    skin = UsdGeom.Mesh(stage.GetPrimAtPath("/World/block/Skin"))
    mesh = scene.character.mesh
    faces = np.array(skin.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)
    rest = np.array(skin.GetPointsAttr().Get())
    np.testing.assert_allclose(rest[faces], mesh.points[mesh.surface], atol=1e-7)
    assert np.unique(faces).tolist() == list(range(len(rest)))
    assert skin.GetSubdivisionSchemeAttr().Get() == "none"
    bound, _ = UsdShade.MaterialBindingAPI(skin).ComputeBoundMaterial()
    assert bound.GetPath() == "/World/Materials/Body"


def test_tets_carry_rest_and_surface(stage: Any, scene: Scene) -> None:
    tets = UsdGeom.TetMesh(stage.GetPrimAtPath("/World/block/Tets"))
    mesh = scene.character.mesh
    rest = UsdGeom.PrimvarsAPI(tets).GetPrimvar("rest")
    assert rest.GetInterpolation() == "vertex"
    np.testing.assert_allclose(np.array(rest.Get()), mesh.points, atol=1e-7)
    np.testing.assert_array_equal(np.array(tets.GetTetVertexIndicesAttr().Get()), mesh.tets)
    assert tets.GetPurposeAttr().Get() == "guide"
    own = {frozenset(face) for face in tets.GetSurfaceFaceVertexIndicesAttr().Get()}
    assert own == {frozenset(face) for face in UsdGeom.TetMesh.ComputeSurfaceFaces(tets)}


@pytest.mark.parametrize("name", ["Skin", "Tets"])
def test_moving_points_have_velocity_and_extent(stage: Any, name: str) -> None:
    prim = UsdGeom.PointBased(stage.GetPrimAtPath(f"/World/block/{name}"))
    assert prim.GetPointsAttr().GetTypeName() == "point3f[]"
    for attribute in (prim.GetPointsAttr(), prim.GetVelocitiesAttr(), prim.GetExtentAttr()):
        assert attribute.GetTimeSamples() == [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]
    points = np.array([prim.GetPointsAttr().Get(code) for code in (2, 3, 4)])
    by_difference = (points[2] - points[0]) * 15.0
    velocities = np.array(prim.GetVelocitiesAttr().Get(3))
    np.testing.assert_allclose(velocities, by_difference, atol=5e-3 * np.abs(velocities).max())


def test_fibers_hold_one_value_a_segment(stage: Any, scene: Scene) -> None:
    fibers = UsdGeom.BasisCurves(stage.GetPrimAtPath("/World/block/Fibers"))
    count = scene.character.segment_count
    activation = UsdGeom.PrimvarsAPI(fibers).GetPrimvar("activation")
    assert activation.GetInterpolation() == "uniform"
    assert len(activation.Get(3)) == fibers.GetCurveCount() == count
    expected = np.linspace(1.0, 0.5, count) ** 0.5
    np.testing.assert_allclose(np.array(activation.Get(3)), expected, rtol=1e-6)
    assert len(fibers.GetPointsAttr().Get(3)) == 2 * count


def test_contacts_change_their_number(stage: Any) -> None:
    contacts = UsdGeom.Points(stage.GetPrimAtPath("/World/block/Contacts"))
    counts = [contacts.GetPointCount(code) for code in range(6)]
    assert counts == [0, 1, 2, 0, 1, 2]
    primvars = UsdGeom.PrimvarsAPI(contacts)
    assert list(primvars.GetPrimvar("mode").Get(2)) == [1, 1]
    assert np.array(primvars.GetPrimvar("force").Get(2)).tolist() == [[0, 0, 2], [0, 0, 2]]


def test_surroundings(stage: Any) -> None:
    ground = stage.GetPrimAtPath("/World/Ground")
    assert ground.GetAttribute("softbody:friction").Get() == 0.7
    assert UsdLux.DistantLight(stage.GetPrimAtPath("/World/Light")).GetNormalizeAttr().Get()
    assert stage.GetPrimAtPath("/World/Sky").IsA(UsdLux.DomeLight)
    surface = UsdShade.Material(stage.GetPrimAtPath("/World/Materials/Body")).ComputeSurfaceSource()
    assert surface[0].GetIdAttr().Get() == "UsdPreviewSurface"


def test_camera_sees_the_body(stage: Any) -> None:
    camera = UsdGeom.Camera(stage.GetPrimAtPath("/World/Camera")).GetCamera(0)
    view = camera.frustum.ComputeViewMatrix() * camera.frustum.ComputeProjectionMatrix()
    for point in stage.GetPrimAtPath("/World/block/Skin").GetAttribute("points").Get():
        assert np.abs(np.array(view.Transform(point))).max() < 1.0


def test_a_passive_body_in_free_space_has_no_fibers_or_contacts(
    scene: Scene, make_frames: Any, tmp_path: Path
) -> None:
    bare = Scene(character=replace(scene.character, muscles=()))
    path = tmp_path / "bare.usda"
    with StageWriter(path, bare) as writer:
        for frame in make_frames(bare):
            writer.write(frame)
    stage = Usd.Stage.Open(str(path))
    names = [prim.GetName() for prim in stage.GetPrimAtPath("/World/block").GetChildren()]
    assert names == ["Skin", "Tets"]
    assert not stage.GetPrimAtPath("/World/Ground")
