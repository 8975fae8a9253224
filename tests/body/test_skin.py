"""Skins out of files, and how tets carry them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

import warp_softbody as wsb
from tests.support.bodies import box
from tests.support.skins import box_skin, picture, write_obj
from warp_softbody.body.skin_binding import bind
from warp_softbody.errors import InputError, MeshError, MeshWarning

SIZE = (0.3, 0.2, 0.4)


def test_an_obj_brings_texture_and_materials(tmp_path: Path) -> None:
    found, wanted = wsb.Skin.read(write_obj(tmp_path, SIZE)), box_skin(SIZE)
    np.testing.assert_allclose(found.points, wanted.points)
    np.testing.assert_array_equal(found.faces, wanted.faces)
    np.testing.assert_array_equal(found.face_materials, wanted.face_materials)
    places = found.texture_points[found.texture_faces]
    np.testing.assert_allclose(places, wanted.texture_points[wanted.texture_faces])
    assert [m.name for m in found.materials] == ["sides", "ends"]
    assert found.materials[0].texture == picture() and found.materials[1].roughness == 0.9
    assert found.materials[1].color == (0.0, 0.0, 1.0)


def test_a_ply_brings_its_texture(tmp_path: Path) -> None:
    (tmp_path / "a.png").write_bytes(picture())
    (tmp_path / "a.ply").write_text(
        "ply\nformat ascii 1.0\ncomment TextureFile a.png\nelement vertex 4\nproperty float x\n"
        "property float y\nproperty float z\nproperty float s\nproperty float t\nelement face 1\n"
        "property list uchar int vertex_indices\nend_header\n"
        "0 0 0 0 0\n1 0 0 1 0\n1 0 1 1 1\n0 0 1 0 1\n4 0 1 2 3\n"
    )
    found = wsb.Skin.read(tmp_path / "a.ply")
    assert found.faces.tolist() == [[0, 1, 2], [0, 2, 3]]
    assert found.texture_points[found.texture_faces[1]].tolist() == [[0, 0], [1, 1], [0, 1]]
    assert found.materials[0].texture == picture()


def test_a_glb_of_another_program_brings_its_texture(tmp_path: Path) -> None:
    """Trimesh writes it, y up; the points that a texture's seam has doubled become one again."""
    from PIL import Image

    wanted = box_skin(SIZE)
    corners = wanted.points[wanted.faces.reshape(-1)]
    (tmp_path / "a.png").write_bytes(picture())
    visual: Any = trimesh.visual
    material = visual.material.PBRMaterial(
        name="paint", baseColorTexture=Image.open(tmp_path / "a.png"), roughnessFactor=0.25
    )
    places = wanted.texture_points[wanted.texture_faces.reshape(-1)]
    mesh = trimesh.Trimesh(
        np.stack([corners[:, 0], corners[:, 2], -corners[:, 1]], axis=1),
        np.arange(36).reshape(-1, 3),
        visual=visual.TextureVisuals(uv=places, material=material),
        process=False,
    )
    mesh.export(tmp_path / "a.glb")
    found = wsb.Skin.read(tmp_path / "a.glb")
    assert len(found.points) == 8 and len(found.faces) == 12
    np.testing.assert_allclose(found.points[found.faces], wanted.points[wanted.faces], atol=1e-6)
    np.testing.assert_allclose(
        found.texture_points[found.texture_faces],
        wanted.texture_points[wanted.texture_faces],
        atol=1e-6,
    )
    assert found.materials[0].texture.startswith(b"\x89PNG")
    assert found.materials[0].roughness == 0.25


@pytest.mark.parametrize(
    ("name", "text", "sentence"),
    [
        ("none.obj", None, "No such file"),
        ("a.stl", "solid", "a skin is read from .obj, .ply, .glb"),
        ("a.usdc", "", "stage_exports.read_skin"),
        ("a.obj", "v 0 0 0\nf 1 2 3\n", "line 2 has point 2 of 1"),
        ("a.obj", "v 0 0 0\nv 1 0 0\nf 1 2\n", "the face of line 3 has 2 corners"),
        ("a.obj", "v 0 0 x\n", "could not convert"),
        ("a.obj", "v 0 0 0\n", "must not be empty"),
        ("a.obj", "v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n", "finite"),
        ("a.ply", "ply\n", "no header"),
        ("a.glb", "glTF", "cannot be read as a .glb skin"),
    ],
)
def test_files_that_are_none_are_one_sentence(
    tmp_path: Path, name: str, text: str | None, sentence: str
) -> None:
    if text is not None:
        (tmp_path / name).write_text(text)
    with pytest.raises(MeshError) as refused:
        wsb.Skin.read(tmp_path / name)
    assert sentence in str(refused.value) and "\n" not in str(refused.value)
    assert str(tmp_path / name) in str(refused.value)


def test_what_a_file_names_and_has_not_is_told(tmp_path: Path) -> None:
    path = write_obj(tmp_path, SIZE)
    (tmp_path / "box.png").unlink()
    with pytest.warns(MeshWarning, match=r"the texture 'box.png' cannot be read"):
        assert not wsb.Skin.read(path).materials[0].texture
    (tmp_path / "box.mtl").unlink()
    with pytest.warns(MeshWarning) as told:
        wsb.Skin.read(path)
    assert any("the file of materials 'box.mtl'" in str(one.message) for one in told)


def test_a_skin_moves_with_the_tets_inside_and_a_little_outside() -> None:
    """Any affine motion of the tets is that of the skin, to rounding."""
    mesh = box((3, 2, 4), SIZE)
    sphere = trimesh.creation.icosphere(3, 1.0).vertices
    points = np.array(SIZE) * (0.5 + 0.55 * sphere)
    assert (points < 0.0).any()
    weights = bind(mesh, points, "skin").toarray()
    np.testing.assert_allclose(weights @ mesh.points, points, atol=1e-12)
    turn = np.random.default_rng(1).normal(size=(3, 3))
    moved = mesh.points @ turn + 1.0
    np.testing.assert_allclose(weights @ moved, points @ turn + 1.0, atol=1e-12)


def test_a_point_inside_is_carried_by_its_own_tet() -> None:
    """Also one of a large tet, whose middle is further than those of many small ones."""
    rng = np.random.default_rng(2)
    large = np.array([(0.0, 0, 0), (10, 0, 0), (0, 10, 0), (0, 0, 10)])
    cells = box((4, 4, 4), (0.5, 0.5, 0.5))
    small = cells.points + np.array([-0.5, 0.0, 0.0])
    tets = np.concatenate([[[0, 1, 2, 3]], cells.tets + 4]).astype(np.int32)
    mesh = wsb.TetMesh(np.concatenate([large, small]), tets)
    inner = rng.dirichlet(np.ones(4), 200) @ large
    places = np.concatenate([inner, inner * 0.01 - (0.4, -0.1, -0.1)])
    weights = bind(mesh, places, "skin").toarray()
    assert weights.min() > -1e-9
    assert (weights[:200, 4:] == 0.0).all() and (weights[200:, :4] == 0.0).all()


def test_a_skin_elsewhere_is_refused() -> None:
    block = box((1, 1, 1), SIZE)
    mesh = wsb.TetMesh(block.points + 5.0, block.tets)
    character = wsb.Character(name="b", mesh=mesh, skin=box_skin(SIZE))
    with pytest.raises(InputError, match=r"skin of 'b': point .* m outside the tets; at most"):
        _ = character.skin_weights


def test_a_textured_surface_keeps_its_texture_when_it_is_filled(tmp_path: Path) -> None:
    mesh = wsb.TetMesh.from_surface(write_obj(tmp_path, SIZE), size=0.15)
    assert mesh.skin == box_skin(SIZE)
    character = wsb.Character(name="b", mesh=mesh)
    assert character.skin == mesh.skin
    moved = wsb.placed(character, translation=(1.0, 0.0, 0.0), degrees=90.0)
    assert moved.skin is not None and moved.mesh.skin is None
    carried = moved.skin_weights.toarray() @ moved.mesh.points
    np.testing.assert_allclose(carried, moved.skin.points, atol=1e-9)
    other = wsb.Body(character=wsb.Character(name="c", mesh=mesh))
    assert wsb.Scene(character=moved, others=(other,)).whole.skin is None
