"""Which surfaces are taken, and each sentence with which others are refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from warp_softbody.body.meshing import load_surface
from warp_softbody.body.meshing.crossings import crossing_triangles
from warp_softbody.errors import MeshError, MeshWarning


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
    place = r"one of them at \(-0\.5, -0\.25, 0\) m"
    with pytest.raises(MeshError, match=f"the surface is not closed: it has 3 open edges, {place}"):
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
    sentence = r"1 of 12 triangles are turned: .* disagree about which side is outside, one of"
    with pytest.raises(MeshError, match=sentence + r" them at \(-0\.5, -0\.0833333, 0\.05\) m"):
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
    sentence = r"1 edges are shared by more than two triangles, one of them at \(0\.5, 0\.5, 0\)"
    with pytest.raises(MeshError, match=sentence):
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


def test_crossing_triangles_are_counted_and_one_place_told(box: trimesh.Trimesh) -> None:
    points = box.vertices.copy()
    # a corner is pulled through the opposite side, x = 0.5
    points[0] = (0.9, 0.1, 0.0)
    told = r"surface: \d+ of its triangles cross each other, two of them at \(0\.5, .*\) m"
    with pytest.warns(MeshWarning, match=told):
        surface = load_surface(trimesh.Trimesh(points, box.faces, process=False))
    assert "cross each other" in surface.crossing


def test_parts_that_cross_are_told_as_such(box: trimesh.Trimesh) -> None:
    other = box.copy()
    other.apply_translation((0.4, 0.2, 0.1))
    sentence = r"2 separate parts, .* triangles cross each other, two of them at"
    with pytest.raises(MeshError, match=sentence):
        load_surface(joined(box, other))


def test_a_whole_surface_crosses_nowhere() -> None:
    points, faces = trimesh.creation.icosphere(3).vertices, trimesh.creation.icosphere(3).faces
    pairs, _ = crossing_triangles(np.asarray(points), np.asarray(faces, dtype=np.int64))
    assert len(pairs) == 0


def test_every_crossing_of_two_tets_is_found() -> None:
    tet = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    sides = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    points = np.concatenate([tet, tet + np.array([0.1, 0.15, 0.2])])
    pairs, places = crossing_triangles(points, np.concatenate([sides, sides + 4]))
    found = {tuple(sorted(pair)) for pair in pairs.tolist()}
    # the corner of the second tet lies inside the first: its three sides leave by the slanted one
    assert found == {(3, 4), (3, 5), (3, 6)}
    np.testing.assert_allclose(places.sum(axis=1), 1.0, atol=1e-12)


@pytest.mark.parametrize("scale", [1e-9, 1e-6, 4e-4, 1e4])
def test_small_and_large_surfaces_are_one_surface_scaled(scale: float) -> None:
    ball = trimesh.creation.icosphere(2)
    surface = load_surface(trimesh.Trimesh(scale * ball.vertices, ball.faces, process=False))
    assert surface.points.shape == (162, 3) and surface.faces.shape == (320, 3)
    assert surface.volume == pytest.approx(scale**3 * ball.volume, rel=1e-9)
    with pytest.raises(MeshError, match="it has 3 open edges"):
        load_surface(trimesh.Trimesh(scale * ball.vertices, ball.faces[1:], process=False))


def test_a_thin_wire_is_closed() -> None:
    rod = trimesh.creation.cylinder(radius=1.0, height=1.0, sections=8)
    points = rod.vertices * np.array([1e-6, 1e-6, 1.0])
    wire = load_surface(trimesh.Trimesh(points, rod.faces, process=False))
    assert wire.volume == pytest.approx(1e-12 * rod.volume, rel=1e-9)
    assert wire.thickness == pytest.approx(1e-6, rel=0.1)


def test_a_surface_that_touches_itself_is_told() -> None:
    ball = trimesh.creation.icosphere(1)
    points = ball.vertices.copy()
    points[20] = points[33]
    with pytest.warns(MeshWarning, match=r"it touches itself at 1 points, one of them at \("):
        load_surface(trimesh.Trimesh(points, ball.faces, process=False))


def test_what_is_left_out_is_told(box: trimesh.Trimesh) -> None:
    points = np.concatenate([box.vertices, [[0.0, 0.0, 0.0]]])
    faces = np.concatenate([box.faces, box.faces[:2], [[0, 1, 1]]])
    told = "1 points that no triangle uses, 1 triangles without area, 2 triangles that stand twice"
    with pytest.warns(MeshWarning, match=f"surface: {told} are left out"):
        surface = load_surface(trimesh.Trimesh(points, faces, process=False))
    assert surface.points.shape == (8, 3) and surface.faces.shape == (12, 3)


def test_one_sided_surface_has_no_outside() -> None:
    # the projective plane of six points: closed, every edge used twice, but one-sided
    faces = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5], [0, 5, 1]]
    faces += [[1, 2, 4], [2, 3, 5], [3, 4, 1], [4, 5, 2], [5, 1, 3]]
    points = np.random.default_rng(1).uniform(size=(6, 3))
    with pytest.raises(MeshError, match="the surface is one-sided"):
        load_surface(trimesh.Trimesh(points, faces, process=False))


def test_a_fan_of_thousands_is_no_matter_of_memory() -> None:
    """Two cones that cross: with too many pairs near each other, nothing is looked for."""
    cone = trimesh.creation.cone(1.0, 1.0, sections=200)
    other = cone.copy()
    other.apply_translation((0.1, 0.2, 0.3))
    both = joined(cone, other)
    points, faces = np.asarray(both.vertices), np.asarray(both.faces, dtype=np.int64)
    assert len(crossing_triangles(points, faces)[0]) > 100
    assert len(crossing_triangles(points, faces, most_pairs=1000)[0]) == 0
