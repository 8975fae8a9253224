"""A character's own skin, with its texture, in stages, other forms and pictures."""

from __future__ import annotations

import zipfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from pxr import Usd, UsdGeom, UsdShade

import warp_softbody as wsb
from tests.support.skins import box_skin, picture, write_obj
from warp_softbody.errors import MeshError
from warp_softbody.stage_exports import (
    StageWriter,
    convert,
    draw_take,
    read_skin,
    read_take,
    validate,
)
from warp_softbody.world.scene import Scene

SIZE = (0.2, 0.1, 0.4)


@pytest.fixture
def dressed(scene: Scene) -> Scene:
    """The block of the other tests with a textured skin."""
    given = box_skin(SIZE)
    skin = replace(given, points=given.points - (0.1, 0.05, 0.0))
    character = scene.character
    body = wsb.Character(name="block", mesh=character.mesh, muscles=character.muscles, skin=skin)
    return wsb.Scene(character=body, ground=scene.ground)


def write(path: Path, scene: Scene, make_frames: Any) -> Path:
    with StageWriter(path, scene) as stage:
        for frame in make_frames(scene):
            stage.write(frame)
    return path


def test_a_stage_holds_the_authored_triangles_and_moves_them(
    dressed: Scene, make_frames: Any, tmp_path: Path
) -> None:
    path = write(tmp_path / "a.usdc", dressed, make_frames)
    assert validate(path) == []
    take, skin = read_take(path), dressed.character.skin
    assert skin is not None and take.skin is not None
    np.testing.assert_allclose(take.skin_rest[take.skin_faces], skin.points[skin.faces], atol=1e-7)
    for frame in make_frames(dressed):
        moved = dressed.character.skin_weights @ frame.positions
        shown = take.skin_points[frame.index][take.skin_faces]
        np.testing.assert_allclose(shown, moved[skin.faces], atol=1e-6)
    assert np.ptp(take.skin_points, axis=0).max() > 1e-3
    np.testing.assert_allclose(
        take.skin.texture_points[take.skin.texture_faces],
        skin.texture_points[skin.texture_faces],
        atol=1e-7,
    )
    np.testing.assert_array_equal(take.skin.face_materials, skin.face_materials)
    assert [m.texture for m in take.skin.materials] == [picture(), b""]
    assert take.skin.materials[1].color == (0.0, 0.0, 1.0)


def test_its_materials_read_their_textures_beside_the_stage(
    dressed: Scene, make_frames: Any, tmp_path: Path
) -> None:
    stage = Usd.Stage.Open(str(write(tmp_path / "a.usdc", dressed, make_frames)))
    skin = UsdGeom.Mesh(stage.GetPrimAtPath("/World/block/Skin"))
    st = UsdGeom.PrimvarsAPI(skin).GetPrimvar("st")
    assert st.GetInterpolation() == "faceVarying" and len(st.ComputeFlattened()) == 36
    subsets = UsdShade.MaterialBindingAPI(skin).GetMaterialBindSubsets()
    assert sum(len(s.GetIndicesAttr().Get()) for s in subsets) == 12
    bound = [UsdShade.MaterialBindingAPI(s).ComputeBoundMaterial()[0] for s in subsets]
    color = bound[0].ComputeSurfaceSource()[0].GetInput("diffuseColor")
    source = UsdShade.Shader(color.GetConnectedSources()[0][0].source.GetPrim())
    asset = source.GetInput("file").Get()
    assert asset.path == "./a_textures/block_0.png"
    assert Path(asset.resolvedPath).read_bytes() == picture()


@pytest.mark.parametrize("ending", [".usdz", ".usda", ".glb"])
def test_other_forms_take_the_texture_along(
    dressed: Scene, make_frames: Any, tmp_path: Path, ending: str
) -> None:
    path = write(tmp_path / "a.usdc", dressed, make_frames)
    (tmp_path / "other").mkdir()
    made = convert(path, tmp_path / "other" / f"b{ending}")
    if ending == ".glb":
        found = wsb.Skin.read(made)
        assert found.textured and len(found.faces) == 12
        assert any(material.texture for material in found.materials)
        return
    again = read_take(made)
    assert again.skin is not None and again.skin.materials[0].texture == picture()
    if ending == ".usdz":
        with zipfile.ZipFile(made) as archive:
            assert "a_textures/block_0.png" in archive.namelist()


def test_an_archive_is_written_at_once(dressed: Scene, make_frames: Any, tmp_path: Path) -> None:
    path = write(tmp_path / "a.usdz", dressed, make_frames)
    assert [entry.name for entry in tmp_path.iterdir()] == ["a.usdz"]
    take = read_take(path)
    assert take.skin is not None and take.skin.materials[0].texture == picture()
    assert validate(path) == []
    # so that the same take is the same file whenever it is written
    with zipfile.ZipFile(path) as archive:
        dates = {entry.date_time for entry in archive.infolist()}
    assert dates == {(1980, 1, 1, 0, 0, 0)}


def test_a_picture_shows_the_texture(dressed: Scene, make_frames: Any, tmp_path: Path) -> None:
    """All four colours of the picture are seen, and not without the skin."""
    path = write(tmp_path / "a.usdc", dressed, make_frames)
    image = np.asarray(Image.open(draw_take(tmp_path / "a.png", path, count=1, captions=False)))
    image = image.astype(int)
    red, green, blue = image[..., 0], image[..., 1], image[..., 2]
    assert ((red > 2 * green) & (red > 2 * blue)).sum() > 50
    assert ((green > 2 * red) & (green > 2 * blue)).sum() > 50
    assert ((red > 2 * blue) & (green > 2 * blue)).sum() > 50


def test_a_skin_out_of_a_usd_file(dressed: Scene, make_frames: Any, tmp_path: Path) -> None:
    """Out of a stage of ours, which any program could have written; z up or y up, m or cm."""
    path = write(tmp_path / "a.usda", dressed, make_frames)
    skin = dressed.character.skin
    assert skin is not None
    stage = Usd.Stage.Open(str(path))
    stage.RemovePrim("/World/Ground")
    for up, unit in (("Z", 1.0), ("Y", 0.01)):
        UsdGeom.SetStageUpAxis(stage, up)
        UsdGeom.SetStageMetersPerUnit(stage, unit)
        stage.Export(str(tmp_path / "b.usdc"))
        found = read_skin(tmp_path / "b.usdc")
        assert len(found.points) == 8 and found.textured
        points = found.points / unit
        if up == "Y":
            points = np.stack([points[:, 0], points[:, 2], -points[:, 1]], axis=1)
        # the first frame is the pose at rest
        np.testing.assert_allclose(points[found.faces], skin.points[skin.faces], atol=1e-6)
        textures = {m.name.rpartition("_")[2]: m.texture for m in found.materials}
        assert textures == {"sides": picture(), "ends": b""}


def test_usd_files_without_a_skin_are_one_sentence(tmp_path: Path) -> None:
    (tmp_path / "a.usda").write_text('#usda 1.0\ndef Xform "W" {}\n')
    (tmp_path / "b.usdc").write_bytes(b"PXR-USDC" + bytes(80))
    for name, sentence in (("a.usda", "holds no mesh"), ("b.usdc", "b.usdc"), ("c.usd", "c.usd")):
        with pytest.raises(MeshError) as refused:
            read_skin(tmp_path / name)
        assert sentence in str(refused.value) and "\n" not in str(refused.value)
    assert read_skin(write_obj(tmp_path, SIZE)).textured
