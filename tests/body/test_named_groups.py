"""Numbers and named groups of a file reach the character."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest

from warp_softbody.body.character import Character
from warp_softbody.body.mesh import TetMesh
from warp_softbody.body.mesh_formats.groups import named_groups
from warp_softbody.errors import MeshWarning
from warp_softbody.world.joined_bodies import placed


@pytest.fixture
def path(cube: TetMesh, tmp_path: Path) -> Path:
    """The cube in a Gmsh file behind an isolated point, with groups of tets and of triangles."""
    points = np.concatenate([[[9.0, 9.0, 9.0]], cube.points])
    low = cube.surface[(cube.points[cube.surface][:, :, 2] == 0.0).all(axis=1)]
    mesh = meshio.Mesh(
        points,
        [("tetra", cube.tets + 1), ("triangle", low + 1)],
        cell_data={
            "gmsh:physical": [np.array([1, 1, 1, 2, 2, 2]), np.full(len(low), 3)],
            "gmsh:geometrical": [np.array([1, 1, 1, 2, 2, 2]), np.full(len(low), 3)],
        },
        field_data={"left": np.array([1, 3]), "right": np.array([2, 3]), "floor": np.array([3, 2])},
    )
    mesh.write(tmp_path / "cube.msh", file_format="gmsh22", binary=False)
    return tmp_path / "cube.msh"


def test_groups_become_regions_of_the_character(cube: TetMesh, path: Path) -> None:
    with pytest.warns(MeshWarning, match="1 of 9 points are in no tet") as told:
        mesh = TetMesh.read(path)
    # the triangles are not left out: they are the floor
    assert len(told) == 1
    assert set(mesh.regions) == {"left", "right", "floor"}
    np.testing.assert_array_equal(mesh.regions["floor"], [0, 1, 2, 3])
    np.testing.assert_array_equal(mesh.regions["left"], np.unique(cube.tets[:3]))
    body = Character(name="cube", mesh=mesh, regions={"left": np.array([5], np.int32)})
    np.testing.assert_array_equal(body.region("floor"), [0, 1, 2, 3])
    np.testing.assert_array_equal(body.region("left"), [5])


def test_fixed_by_the_numbers_of_the_file(path: Path) -> None:
    with pytest.warns(MeshWarning):
        mesh = TetMesh.read(path)
    on_floor = np.flatnonzero(meshio.read(path).points[:, 2] == 0.0)
    body = Character(name="cube", mesh=mesh, fixed=mesh.nodes_of(on_floor))
    np.testing.assert_array_equal(mesh.points[body.fixed][:, 2], 0.0)
    assert len(body.fixed) == 4


def test_sets_of_abaqus_become_regions(cube: TetMesh, tmp_path: Path) -> None:
    sets = {"top": np.array([4, 5, 6, 7])}
    meshio.Mesh(cube.points, [("tetra", cube.tets)], point_sets=sets).write(tmp_path / "cube.inp")
    np.testing.assert_array_equal(TetMesh.read(tmp_path / "cube.inp").regions["top"], [4, 5, 6, 7])


def test_a_body_that_is_placed_keeps_numbers_and_groups(path: Path) -> None:
    with pytest.warns(MeshWarning):
        mesh = TetMesh.read(path)
    moved = placed(Character(name="cube", mesh=mesh), translation=(1.0, 2.0, 3.0)).mesh
    np.testing.assert_array_equal(moved.nodes_of([1, 8]), [0, 7])
    assert set(moved.regions) == set(mesh.regions)


def test_groups_of_flac3d_count_all_cells(cube: TetMesh, tmp_path: Path) -> None:
    lines = [f"G {k} {x} {y} {z}" for k, (x, y, z) in enumerate(cube.points.tolist(), 1)]
    lines += [f"Z T4 {k} " + " ".join(map(str, t)) for k, t in enumerate(cube.tets + 1, 1)]
    floor = cube.surface[(cube.points[cube.surface][:, :, 2] == 0.0).all(axis=1)]
    lines += [f"F T3 {k} " + " ".join(map(str, t)) for k, t in enumerate(floor + 1, 1)]
    lines += ['ZGROUP "rock" SLOT 1', "4 5 6", 'FGROUP "floor" SLOT 1', "1 2"]
    (tmp_path / "cube.f3grid").write_text("\n".join(lines) + "\n")
    mesh = TetMesh.read(tmp_path / "cube.f3grid")
    np.testing.assert_array_equal(mesh.regions["zone:rock:1"], np.unique(cube.tets[3:]))
    np.testing.assert_array_equal(mesh.regions["face:floor:1"], [0, 1, 2, 3])


def test_a_group_of_what_is_not_there_is_left_out_and_told(cube: TetMesh, tmp_path: Path) -> None:
    sets = {"top": np.array([4, 5])}
    meshio.Mesh(cube.points, [("tetra", cube.tets)], point_sets=sets).write(tmp_path / "cube.inp")
    mesh = meshio.read(tmp_path / "cube.inp")
    mesh.point_sets["top"] = np.array([4, 99])
    groups, _, broken = named_groups(mesh, "abaqus")
    assert groups == {} and broken == ["its group 'top' names what is not in it and is left out"]
