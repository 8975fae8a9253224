"""What stands where in an exported stage, read back with USD."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Kind, Usd, UsdGeom, UsdLux, UsdShade

from warp_softbody.stage_exports import StageWriter
from warp_softbody.stage_exports.conventions import MEANINGS
from warp_softbody.stage_exports.palette import activation_colors
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
    assert skin.GetSubdivisionSchemeAttr().Get() == "loop"
    bound, _ = UsdShade.MaterialBindingAPI(skin).ComputeBoundMaterial()
    assert bound.GetPath() == "/World/Materials/block"


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
def test_moving_points_have_an_extent(stage: Any, name: str) -> None:
    prim = UsdGeom.PointBased(stage.GetPrimAtPath(f"/World/block/{name}"))
    assert prim.GetPointsAttr().GetTypeName() == "point3f[]"
    for attribute in (prim.GetPointsAttr(), prim.GetExtentAttr()):
        assert attribute.GetTimeSamples() == [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]


@pytest.mark.parametrize("name", ["Skin", "Tets"])
def test_between_frames_points_are_on_the_line_between_them(stage: Any, name: str) -> None:
    """Readers would follow authored velocities through the ground instead."""
    prim = UsdGeom.PointBased(stage.GetPrimAtPath(f"/World/block/{name}"))
    before, between, after = (
        np.array(prim.ComputePointsAtTime(code, Usd.TimeCode(code))) for code in (2.0, 2.5, 3.0)
    )
    np.testing.assert_allclose(between, (before + after) / 2.0, atol=1e-7)


def test_nodes_carry_their_velocities(stage: Any) -> None:
    tets = UsdGeom.TetMesh(stage.GetPrimAtPath("/World/block/Tets"))
    points = [np.array(tets.GetPointsAttr().Get(code)) for code in (2, 3, 4)]
    by_difference = (points[2] - points[0]) * 15.0
    velocities = np.array(UsdGeom.PrimvarsAPI(tets).GetPrimvar("velocity").Get(3))
    np.testing.assert_allclose(velocities, by_difference, atol=5e-3 * np.abs(velocities).max())


def test_normals_are_left_to_viewers_and_edges_stay_sharp(stage: Any) -> None:
    """A block has flat faces and right angles: the mean over each point's faces is their normal.

    Drawn subdivided, the points of its edges stay where they are, on both sides.
    """
    skin = UsdGeom.Mesh(stage.GetPrimAtPath("/World/block/Skin"))
    assert not skin.GetNormalsAttr().HasAuthoredValue()
    assert skin.GetSubdivisionSchemeAttr().Get() == "loop"
    faces = np.array(skin.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)
    for code in (Usd.TimeCode.Default(), 0.0):
        points = np.array(skin.GetPointsAttr().Get(code), dtype=np.float64)
        a, b, c = (points[faces[:, corner]] for corner in range(3))
        areas = np.cross(b - a, c - a)
        sums = np.zeros_like(points)
        for corner in range(3):
            np.add.at(sums, faces[:, corner], areas)
        means = sums / np.linalg.norm(sums, axis=1, keepdims=True)
        flat = areas / np.linalg.norm(areas, axis=1, keepdims=True)
        np.testing.assert_allclose(means[faces], np.repeat(flat[:, None], 3, 1), atol=2e-3)
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    unique, counts = np.unique(edges, axis=0, return_counts=True)
    assert set(skin.GetCornerIndicesAttr().Get()) == set(unique[counts == 1].ravel())
    assert set(skin.GetCornerSharpnessesAttr().Get()) == {UsdGeom.Mesh.SHARPNESS_INFINITE}


def test_colours_are_places_in_a_palette(stage: Any) -> None:
    for name, size, code in (("Fibers", 6, 3), ("Contacts", 2, 5)):
        prim = stage.GetPrimAtPath(f"/World/block/{name}")
        color = UsdGeom.PrimvarsAPI(prim).GetPrimvar("displayColor")
        assert color.IsIndexed() and not color.GetTimeSamples() == []
        assert len(color.ComputeFlattened(code)) == size
    fibers = UsdGeom.PrimvarsAPI(stage.GetPrimAtPath("/World/block/Fibers"))
    activations = np.array(fibers.GetPrimvar("activation").Get(5))
    shown = np.array(fibers.GetPrimvar("displayColor").ComputeFlattened(5))
    # a place in the palette is a 63rd of the range off, and no channel changes by more than 4.2
    np.testing.assert_allclose(shown, activation_colors(activations), atol=4.2 * 0.5 / 126)


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
    widths = [np.array(contacts.GetWidthsAttr().Get(code)) for code in range(6)]
    assert [int((width > 0.0).sum()) for width in widths] == [0, 1, 2, 0, 1, 2]
    # a set without a point ends some renderers: one without a width stands for it
    assert [contacts.GetPointCount(code) for code in range(6)] == [1, 1, 2, 1, 1, 2]
    assert contacts.GetPointCount(Usd.TimeCode.Default()) == 1
    primvars = UsdGeom.PrimvarsAPI(contacts)
    assert list(primvars.GetPrimvar("mode").Get(2)) == [1, 1]
    assert np.array(primvars.GetPrimvar("force").Get(2)).tolist() == [[0, 0, 2], [0, 0, 2]]


def test_surroundings(stage: Any) -> None:
    ground = stage.GetPrimAtPath("/World/Ground")
    assert ground.GetAttribute("softbody:friction").Get() == 0.7
    assert UsdLux.DistantLight(stage.GetPrimAtPath("/World/Light")).GetNormalizeAttr().Get()
    assert stage.GetPrimAtPath("/World/Sky").IsA(UsdLux.DomeLight)
    surface = UsdShade.Material(
        stage.GetPrimAtPath("/World/Materials/block")
    ).ComputeSurfaceSource()
    assert surface[0].GetIdAttr().Get() == "UsdPreviewSurface"


def test_colours_are_no_primvars_of_a_material(stage: Any) -> None:
    """Converters to other formats refuse a diffuse colour that is read out of a primvar."""
    for prim in stage.Traverse():
        if prim.IsA(UsdShade.Shader):
            assert UsdShade.Shader(prim).GetIdAttr().Get() == "UsdPreviewSurface"
    for name in ("Fibers", "Contacts"):
        prim = stage.GetPrimAtPath(f"/World/block/{name}")
        assert not UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0]


def test_a_body_with_muscles_is_clear_and_a_passive_one_is_not(
    stage: Any, scene: Scene, make_frames: Any, tmp_path: Path
) -> None:
    def opacity(of: Any) -> float | None:
        material = UsdShade.Material(of.GetPrimAtPath("/World/Materials/block"))
        given = material.ComputeSurfaceSource()[0].GetInput("opacity")
        return None if not given else float(given.Get())

    clear = opacity(stage)
    assert clear is not None and 0.2 < clear < 0.7
    bare = replace(scene, character=replace(scene.character, muscles=()))
    with StageWriter(tmp_path / "bare.usda", bare) as writer:
        writer.write(next(iter(make_frames(bare))))
    assert opacity(Usd.Stage.Open(str(tmp_path / "bare.usda"))) is None


def test_the_ground_is_tiled_in_two_shades(stage: Any) -> None:
    ground = UsdGeom.Mesh(stage.GetPrimAtPath("/World/Ground"))
    points = np.array(ground.GetPointsAttr().Get())
    faces = np.array(ground.GetFaceVertexIndicesAttr().Get()).reshape(-1, 4)
    assert ground.GetNormalsInterpolation() == "constant"
    np.testing.assert_allclose(ground.GetNormalsAttr().Get(), [[0.0, 0.0, 1.0]], atol=1e-6)
    corners = points[faces]
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    np.testing.assert_allclose(sides, sides[0, 0], rtol=1e-5)
    subsets = UsdShade.MaterialBindingAPI(ground).GetMaterialBindSubsets()
    chosen = [np.array(subset.GetIndicesAttr().Get()) for subset in subsets]
    assert sorted(np.concatenate(chosen).tolist()) == list(range(len(faces)))
    assert abs(len(chosen[0]) - len(chosen[1])) <= 1


def test_our_own_attributes_say_what_they_are(stage: Any) -> None:
    for prim in stage.Traverse():
        for attribute in prim.GetAuthoredAttributes():
            if attribute.GetName() in MEANINGS:
                assert attribute.GetDocumentation() == MEANINGS[attribute.GetName()]
    assert Usd.ModelAPI(stage.GetPrimAtPath("/World/block")).GetAssetName() == "block"


def test_camera_sees_the_body_in_every_frame(stage: Any) -> None:
    camera = UsdGeom.Camera(stage.GetPrimAtPath("/World/Camera"))
    # a film camera of 20.955 mm, counted in tenths of a metre
    assert camera.GetHorizontalApertureAttr().Get() == pytest.approx(0.20955)
    for code in range(6):
        frustum = camera.GetCamera(code).frustum
        view = frustum.ComputeViewMatrix() * frustum.ComputeProjectionMatrix()
        skin = stage.GetPrimAtPath("/World/block/Skin").GetAttribute("points").Get(code)
        assert max(np.abs(np.array(view.Transform(point))).max() for point in skin) < 1.0


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
