"""The `mesh` subcommand, called as the command line calls it."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import meshio
import numpy as np
import pytest
import trimesh

from warp_softbody.body.mesh import TetMesh
from warp_softbody.cli.mesh_command import add_parser
from warp_softbody.errors import InputError, MeshError, OutputError


def call(*arguments: object) -> int:
    """Parse and run one command line."""
    parser = argparse.ArgumentParser()
    add_parser(parser.add_subparsers())
    args = parser.parse_args(["mesh", *map(str, arguments)])
    return int(args.handler(args))


def test_surface_to_tets(
    box: trimesh.Trimesh, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    box.export(tmp_path / "box.stl")
    assert call(tmp_path / "box.stl", "-o", tmp_path / "box.vtu", "--size", 0.25) == 0
    first, second = capsys.readouterr().out.splitlines()
    mesh = TetMesh.read(tmp_path / "box.vtu")
    assert first == f"{len(mesh.points)} points, {len(mesh.tets)} tets, 1 part"
    assert "of the surface's)" in second and "smallest dihedral angle" in second


def test_json_summary(cube: TetMesh, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    cube.write(tmp_path / "cube.msh")
    assert call(tmp_path / "cube.msh", "-o", tmp_path / "cube.vtu", "--json") == 0
    summary = json.loads(capsys.readouterr().out)
    assert (summary["points"], summary["tets"], summary["parts"]) == (8, 6, 1)
    assert summary["volume"] == pytest.approx(1.0)
    assert summary["surface_volume"] is None
    assert summary["smallest_dihedral_angle"] == pytest.approx(45.0)


def test_quiet_conversion(
    cube: TetMesh, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    cube.write(tmp_path / "cube.vtk")
    assert call(tmp_path / "cube.vtk", "-o", tmp_path / "cube.mesh", "--quiet") == 0
    assert capsys.readouterr() == ("", "")
    assert TetMesh.read(tmp_path / "cube.mesh").volume == pytest.approx(1.0)


def test_output_is_checked_before_the_work(box: trimesh.Trimesh, tmp_path: Path) -> None:
    box.export(tmp_path / "box.stl")
    with pytest.raises(OutputError, match="there is no folder"):
        call(tmp_path / "box.stl", "-o", tmp_path / "absent" / "box.vtu")
    assert [entry.name for entry in tmp_path.iterdir()] == ["box.stl"]


def test_refused_input_leaves_nothing(tmp_path: Path) -> None:
    with pytest.raises(MeshError, match="there is no such file"):
        call(tmp_path / "absent.stl", "-o", tmp_path / "out.vtu")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("option", [("--mesher", "tetgen"), ("--size", "0.1")])
def test_mesher_options_are_for_surfaces(
    cube: TetMesh, tmp_path: Path, option: tuple[str, str]
) -> None:
    cube.write(tmp_path / "cube.vtu")
    with pytest.raises(InputError, match=f"{option[0]} is for surfaces"):
        call(tmp_path / "cube.vtu", "-o", tmp_path / "out.vtu", *option)


def test_what_is_left_out_is_one_line_each(
    cube: TetMesh, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sets = {"top": np.array([4, 5, 6, 7])}
    cells = [("tetra", cube.tets), ("line", [[0, 1]])]
    meshio.Mesh(cube.points, cells, point_sets=sets).write(tmp_path / "cube.inp")
    assert call(tmp_path / "cube.inp", "-o", tmp_path / "cube.vtu", "--json") == 0
    out, err = capsys.readouterr()
    assert json.loads(out)["regions"] == {"top": 4}
    assert err.splitlines() == [
        f"warp-softbody: {tmp_path / 'cube.inp'}: its 1 line cells are left out, because tets "
        f"alone are taken",
        f"warp-softbody: {tmp_path / 'cube.vtu'}: the regions top are not written",
    ]
