"""A file that lost a line or a number is refused or told, in every format."""

from __future__ import annotations

import re
import warnings
from pathlib import Path

import meshio
import numpy as np
import pytest

from benchmarks.fuzz.formats import KINDS, Kind, make_body, write_body
from warp_softbody.body.mesh import TetMesh
from warp_softbody.body.meshing import load_surface
from warp_softbody.errors import MeshError, MeshWarning

by_name = {kind.name: kind for kind in KINDS}


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_the_whole_body_is_read_without_a_word(kind: Kind, tmp_path: Path) -> None:
    write_body(kind, tmp_path / "whole")
    body = make_body()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        if kind.surface:
            surface = load_surface(tmp_path / "whole" / kind.file)
            assert (len(surface.points), len(surface.faces)) == kind.sizes
            assert surface.volume == pytest.approx(body.volume, rel=1e-6)
        else:
            mesh = TetMesh.read(tmp_path / "whole" / kind.file)
            np.testing.assert_allclose(mesh.points, body.points, atol=1e-7)
            np.testing.assert_array_equal(mesh.tets, body.tets)


# One tet of the body, the twelfth where tets are numbered; of VTK the type of one.
LINES = {
    "abaqus": r"^12,.*\n",
    "ansys_text": r"^d e 17 1a\n",
    "avs": r"^12 .*tet.*\n",
    "dolfin": r"^.*<tetrahedron index=\"12\".*\n",
    "flac3d_text": r"^Z T4 12 .*\n",
    "gmsh22_text": r"^12 4 .*\n",
    "mdpa": r"^\s*12\s+0\s.*\n",
    "medit_text": r"^14 15 24 27 1\n",
    "nastran": r"^CTETRA  12 .*\n",
    "permas": r"^12 \d+ \d+ \d+ \d+ *\n",
    "su2": r"^10 .*\n",
    "tetgen_ele": r"^12 .*\n",
    "vtk42_text": r"^10\n",
    "vtk51_text": r"^10\n",
    "vtu_text": r"^10\n",
}


@pytest.mark.parametrize("name", LINES)
def test_a_missing_tet_is_refused_or_told(name: str, tmp_path: Path) -> None:
    kind = by_name[name]
    write_body(kind, tmp_path / "cut")
    path = tmp_path / "cut" / kind.file
    text = path.read_text()
    shorter = re.sub(LINES[name], "", text, count=1, flags=re.MULTILINE)
    assert len(shorter) < len(text)
    path.write_text(shorter)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        try:
            mesh = TetMesh.read(path)
        except MeshError as error:
            assert str(error).startswith(str(path)) and "\n" not in str(error)
        else:
            assert len(mesh.tets) == 47
            sentence = f"{path}: the numbers of its 47 cells leave out 1, the first of them 12: "
            assert str(told[0].message).startswith(sentence)


def test_the_first_tet_may_be_missing_too(tmp_path: Path) -> None:
    kind = by_name["flac3d_text"]
    write_body(kind, tmp_path / "cut")
    path = tmp_path / "cut" / kind.file
    path.write_text(re.sub(r"^Z T4 1 .*\n", "", path.read_text(), flags=re.MULTILINE))
    with pytest.warns(MeshWarning, match="the numbers of its cells begin at 2: see whether"):
        TetMesh.read(path)


def test_a_type_of_cell_that_nobody_knows_is_no_tet_less(tmp_path: Path) -> None:
    kind = by_name["vtk51_text"]
    write_body(kind, tmp_path / "other")
    path = tmp_path / "other" / kind.file
    path.write_text(path.read_text().replace("CELL_TYPES 48\n10", "CELL_TYPES 48\n84"))
    with pytest.raises(MeshError, match="it declares 48 cells, but 47 can be read"):
        TetMesh.read(path)


def test_a_second_list_of_points_is_not_taken_for_the_first(tmp_path: Path) -> None:
    kind = by_name["abaqus"]
    write_body(kind, tmp_path / "two")
    path = tmp_path / "two" / kind.file
    lines = path.read_text().splitlines(keepends=True)
    at = next(k for k, line in enumerate(lines) if line.startswith("*ELEMENT"))
    path.write_text("".join([*lines[:at], "*NODE\n", *lines[at - 1 :]]))
    with pytest.raises(MeshError, match=r"cannot be read as a \.inp mesh"):
        TetMesh.read(path)


def test_flat_cells_beside_tets_leave_no_gap_in_the_numbers(tmp_path: Path) -> None:
    body = make_body()
    cells = [("tetra", body.tets[:20]), ("triangle", body.surface), ("tetra", body.tets[20:])]
    for name in ("s.bdf", "s.inp", "s.msh", "s.mdpa", "s.vol", "s.dato", "s.mesh", "s.avs"):
        meshio.Mesh(body.points, cells).write(tmp_path / name)
        with pytest.warns(MeshWarning, match="its 48 triangle cells are left out") as told:
            mesh = TetMesh.read(tmp_path / name)
        assert len(told) == 1 and len(mesh.tets) == 48


def test_abaqus_as_programs_write_it(tmp_path: Path) -> None:
    body = make_body()
    lines = ["*Heading", " a model", "** comment", "*Part, name=P", "*Node, nset=ALL"]
    lines += [f" {10 * k + 10}, {x}, {y}, {z}" for k, (x, y, z) in enumerate(body.points.tolist())]
    for name, first in (("low", 0), ("high", 24)):
        lines.append(f"*Element, type=C3D4, elset={name}")
        for number, tet in enumerate(10 * body.tets[first : first + 24] + 10, first + 1):
            lines.append(f"{number}, " + ", ".join(map(str, tet)) + ",")
    lines += ["*Nset, nset=foot", "10, 20, 30", "*NODE PRINT", "U", "*End Part", ""]
    (tmp_path / "s.inp").write_text("\n".join(lines))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        mesh = TetMesh.read(tmp_path / "s.inp")
    assert {name: len(nodes) for name, nodes in mesh.regions.items()} == {
        "foot": 3,
        "low": 18,
        "high": 18,
    }


@pytest.mark.parametrize("name", ["abaqus", "flac3d_text", "permas", "mdpa", "nastran"])
def test_a_file_that_was_cut_off_is_refused_or_told(name: str, tmp_path: Path) -> None:
    kind = by_name[name]
    write_body(kind, tmp_path / "cut")
    path = tmp_path / "cut" / kind.file
    text = path.read_text()
    last = max(text.rfind(tet) for tet in ("48,14,24,23,27", "48 14 24 23 27", "48              1"))
    path.write_text(text[: last - 3] if last > 0 else text[: int(0.8 * len(text))])
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        try:
            TetMesh.read(path)
        except MeshError as error:
            assert str(error).startswith(f"{path}: cannot be read as a {path.suffix} mesh: ")
        else:
            assert any("its last line has no end" in str(one.message) for one in told)
