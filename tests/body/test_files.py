"""Reading and writing tet files: round trips, refusals, and nothing half-written."""

from __future__ import annotations

import errno
from pathlib import Path

import meshio
import numpy as np
import pytest

from warp_softbody.body.mesh import TetMesh
from warp_softbody.body.mesh_files import WRITABLE
from warp_softbody.errors import InputError, MeshError, MeshWarning, OutputError


@pytest.mark.parametrize("extension", WRITABLE)
def test_round_trip(cube: TetMesh, tmp_path: Path, extension: str) -> None:
    skewed = TetMesh.from_arrays(cube.points @ np.diag([1 / 3, 0.7, np.pi]), cube.tets)
    path = tmp_path / f"body{extension}"
    skewed.write(path)
    back = TetMesh.read(str(path))
    np.testing.assert_allclose(back.points, skewed.points, rtol=1e-15)
    np.testing.assert_array_equal(back.tets, skewed.tets)
    assert back.points.dtype.isnative and back.tets.dtype.isnative
    assert [entry.name for entry in tmp_path.iterdir()] == [path.name]


def test_surface_cells_beside_tets_are_told(cube: TetMesh, tmp_path: Path) -> None:
    cells = [("triangle", cube.surface), ("tetra", cube.tets[:3]), ("tetra", cube.tets[3:])]
    meshio.Mesh(cube.points, cells).write(tmp_path / "both.vtu")
    with pytest.warns(MeshWarning, match=r"both\.vtu: its 12 triangle cells are left out"):
        mesh = TetMesh.read(tmp_path / "both.vtu")
    np.testing.assert_array_equal(mesh.tets, cube.tets)


@pytest.mark.parametrize(
    ("name", "text", "sentence"),
    [
        ("absent.vtu", None, "there is no such file"),
        ("body.xyz", "0 0 0", "no mesh format is known for the extension '.xyz'"),
        ("body", "0 0 0", "no mesh format is known for the extension ''"),
        ("broken.msh", "garbage", "cannot be read as a .msh mesh"),
        ("broken.vtu", "<VTKFile", "cannot be read as a .vtu mesh"),
        ("empty.vtk", "", "cannot be read as a .vtk mesh"),
        ("broken.mesh", "MeshVersionFormatted x", "cannot be read as a .mesh mesh"),
    ],
)
def test_unreadable_files(
    tmp_path: Path,
    capfd: pytest.CaptureFixture[str],
    name: str,
    text: str | None,
    sentence: str,
) -> None:
    path = tmp_path / name
    if text is not None:
        path.write_text(text)
    with pytest.raises(MeshError, match=sentence) as caught:
        TetMesh.read(path)
    assert str(caught.value).startswith(str(path)) and "\n" not in str(caught.value)
    assert capfd.readouterr() == ("", "")


def test_folder_is_no_file(tmp_path: Path) -> None:
    with pytest.raises(MeshError, match="there is no such file"):
        TetMesh.read(tmp_path)


def test_file_without_tets(cube: TetMesh, tmp_path: Path) -> None:
    meshio.Mesh(cube.points, [("triangle", cube.surface)]).write(tmp_path / "skin.vtu")
    with pytest.raises(MeshError, match=r"it holds no tets \(found: triangle\)"):
        TetMesh.read(tmp_path / "skin.vtu")


def test_file_with_other_solids(cube: TetMesh, tmp_path: Path) -> None:
    cells = [("tetra", cube.tets), ("hexahedron", [[0, 1, 3, 2, 4, 5, 7, 6]])]
    meshio.Mesh(cube.points, cells).write(tmp_path / "mixed.vtu")
    with pytest.raises(MeshError, match="only linear tets are taken, but it holds hexahedron"):
        TetMesh.read(tmp_path / "mixed.vtu")


def test_quadratic_cells_beside_tets_do_not_vanish(cube: TetMesh, tmp_path: Path) -> None:
    points = np.concatenate([cube.points, np.random.default_rng(0).uniform(2, 3, (20, 3))])
    cells = [("tetra", cube.tets), ("hexahedron20", [np.arange(8, 28)])]
    meshio.Mesh(points, cells).write(tmp_path / "mixed.vtk")
    with pytest.raises(MeshError, match="only linear tets are taken, but it holds hexahedron20"):
        TetMesh.read(tmp_path / "mixed.vtk")


def test_a_surface_file_holds_no_tets(tmp_path: Path) -> None:
    (tmp_path / "skin.stl").write_bytes(bytes(84))
    with pytest.raises(MeshError, match=r"a surface holds no tets; TetMesh\.from_surface"):
        TetMesh.read(tmp_path / "skin.stl")


def test_file_name_stands_in_sentences_about_its_arrays(cube: TetMesh, tmp_path: Path) -> None:
    points = cube.points.copy()
    points[4] = np.nan
    meshio.Mesh(points, [("tetra", cube.tets)]).write(tmp_path / "nan.vtu")
    with pytest.raises(MeshError, match=r"nan\.vtu: point 4 is not finite"):
        TetMesh.read(tmp_path / "nan.vtu")


def test_unknown_output_extension(cube: TetMesh, tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"extension '.xyz'; take one of \.vtu"):
        cube.write(tmp_path / "body.xyz")
    assert not list(tmp_path.iterdir())


def test_output_folder_must_exist(cube: TetMesh, tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="there is no folder"):
        cube.write(tmp_path / "absent" / "body.vtu")
    (tmp_path / "file").touch()
    with pytest.raises(OutputError, match="file is a file and no folder"):
        cube.write(tmp_path / "file" / "body.vtu")
    (tmp_path / "folder.vtu").mkdir()
    with pytest.raises(OutputError, match="it is a folder"):
        cube.write(tmp_path / "folder.vtu")


def test_what_is_no_path(cube: TetMesh) -> None:
    with pytest.raises(InputError, match=r"path of TetMesh.read must be the path of a file, not 5"):
        TetMesh.read(5)  # type: ignore[arg-type]
    with pytest.raises(InputError, match=r"path of TetMesh.write must be the path of a file"):
        cube.write(None)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="a path that the file system can hold"):
        cube.write("a\0b.vtu")
    with pytest.raises(InputError, match="too long for the file system"):
        cube.write("x" * 300 + ".vtu")
    with pytest.raises(InputError, match=r"must be a file or a trimesh.Trimesh, not 5"):
        TetMesh.from_surface(5)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="too long for the file system"):
        TetMesh.read("x" * 5000 + ".vtu")


def test_a_new_file_has_the_rights_of_any(cube: TetMesh, tmp_path: Path) -> None:
    (tmp_path / "any").touch()
    cube.write(tmp_path / "body.vtu")
    modes = {entry.stat().st_mode for entry in tmp_path.iterdir()}
    assert len(modes) == 1


def test_full_disk_keeps_the_old_file(
    cube: TetMesh, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "body.vtu"
    path.write_text("old")

    def write_half(self: meshio.Mesh, target: Path) -> None:
        Path(target).write_text("half")
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(meshio.Mesh, "write", write_half)
    with pytest.raises(OutputError, match=r"body\.vtu: cannot be written: No space left on device"):
        cube.write(path)
    assert [entry.name for entry in tmp_path.iterdir()] == ["body.vtu"]
    assert path.read_text() == "old"
