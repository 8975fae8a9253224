"""Which surfaces are taken, and each sentence with which others are refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from warp_softbody.errors import MeshError
from warp_softbody.meshing import load_surface


@pytest.mark.parametrize("extension", [".stl", ".obj", ".ply", ".off"])
def test_files_are_read_as_one_closed_surface(
    box: trimesh.Trimesh, tmp_path: Path, extension: str
) -> None:
    box.export(tmp_path / f"box{extension}")
    surface = load_surface(tmp_path / f"box{extension}")
    assert surface.points.shape == (8, 3) and surface.faces.shape == (12, 3)
    assert surface.volume == pytest.approx(0.15, rel=1e-6)
    assert surface.diagonal == pytest.approx(np.linalg.norm([1.0, 0.5, 0.3]), rel=1e-6)


def test_obj_with_texture_seams_is_closed(tmp_path: Path) -> None:
    lines = ["v 0 0 0", "v 1 0 0", "v 0 1 0", "v 0 0 1"]
    lines += [f"vt {i / 12} {i / 7}" for i in range(12)]
    faces = [(1, 3, 2), (1, 2, 4), (2, 3, 4), (1, 4, 3)]
    for f, face in enumerate(faces):
        lines.append("f " + " ".join(f"{v}/{3 * f + c + 1}" for c, v in enumerate(face)))
    (tmp_path / "seams.obj").write_text("\n".join(lines))
    surface = load_surface(tmp_path / "seams.obj")
    assert len(surface.points) == 4
    assert surface.volume == pytest.approx(1 / 6)


def test_inside_out_surface_is_turned(box: trimesh.Trimesh) -> None:
    box.invert()
    assert load_surface(box).volume == pytest.approx(0.15)


def test_surface_of_the_caller_is_left_alone(box: trimesh.Trimesh) -> None:
    soup = trimesh.Trimesh(
        box.triangles.reshape(-1, 3), np.arange(36).reshape(-1, 3), process=False
    )
    assert len(load_surface(soup).points) == 8
    assert len(soup.vertices) == 36


def test_open_surface(box: trimesh.Trimesh) -> None:
    with_hole = trimesh.Trimesh(box.vertices, box.faces[1:], process=False)
    with pytest.raises(MeshError, match="surface: the surface is not closed: it has 3 open edges"):
        load_surface(with_hole)


def test_points_that_are_not_finite(box: trimesh.Trimesh, tmp_path: Path) -> None:
    points = box.vertices.copy()
    points[3, 0] = np.nan
    trimesh.Trimesh(points, box.faces, process=False).export(tmp_path / "nan.ply")
    with pytest.raises(MeshError, match=r"nan\.ply: point 3 is not finite: \[nan"):
        load_surface(tmp_path / "nan.ply")


def joined(first: trimesh.Trimesh, second: trimesh.Trimesh) -> trimesh.Trimesh:
    """Both surfaces as one."""
    faces = np.concatenate([first.faces, second.faces + len(first.vertices)])
    points = np.concatenate([first.vertices, second.vertices])
    return trimesh.Trimesh(points, faces, process=False)


def test_two_parts(box: trimesh.Trimesh) -> None:
    other = box.copy()
    other.apply_translation((3.0, 0.0, 0.0))
    with pytest.raises(MeshError, match="2 separate parts, but a body is one part"):
        load_surface(joined(box, other))


def test_triangles_that_disagree(box: trimesh.Trimesh) -> None:
    faces = box.faces.copy()
    faces[0] = faces[0][::-1]
    with pytest.raises(MeshError, match="disagree about which side is outside"):
        load_surface(trimesh.Trimesh(box.vertices, faces, process=False))


def test_no_volume() -> None:
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    folded = trimesh.Trimesh(square, [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]], process=False)
    with pytest.raises(MeshError, match="encloses no volume"):
        load_surface(folded)


def test_crowded_edge() -> None:
    first = trimesh.creation.box((1.0, 1.0, 1.0))
    second = first.copy()
    second.apply_translation((1.0, 1.0, 0.0))
    with pytest.raises(MeshError, match="1 edges are shared by more than two triangles"):
        load_surface(joined(first, second))


@pytest.mark.parametrize(
    ("name", "text", "sentence"),
    [
        ("absent.stl", None, "there is no such file"),
        ("body.gltf", "{}", "no surface format is known for the extension '.gltf'"),
        ("broken.ply", "ply garbage", "cannot be read as a .ply surface"),
        ("empty.obj", "", r"empty\.obj: "),
        ("points.obj", "v 0 0 0\nv 1 0 0\n", r"points\.obj: "),
        ("empty.stl", "", r"empty\.stl: "),
    ],
)
def test_unusable_files(tmp_path: Path, name: str, text: str | None, sentence: str) -> None:
    path = tmp_path / name
    if text is not None:
        path.write_text(text)
    with pytest.raises(MeshError, match=sentence) as caught:
        load_surface(path)
    assert str(caught.value).startswith(str(path)) and "\n" not in str(caught.value)
