"""Files that keep a reader busy, block it or ask for all memory end in a sentence."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import meshio
import pytest

from warp_softbody.body.mesh import TetMesh
from warp_softbody.body.mesh_files import read_tets
from warp_softbody.body.mesh_formats.child import READER, ReadingProcess
from warp_softbody.body.meshing import load_surface
from warp_softbody.errors import MeshError

CUT_ANSYS = """(2 3)
(10 (0 1 4 0))
(12 (0 1 1 0))
(10 (1 1 4 1 3)(
0 0 0
1 0 0
0 1 0
0 0 1
))
(12 (1 1 1 1 2)(
1 2 3 4
))
(0 "a comment that does not end"
"""

CUT_TECPLOT = """TITLE = "x"
VARIABLES = "X", "Y", "Z"
ZONE NODES = 4, ELEMENTS = 1,
DATAPACKING = BLOCK, ZONETYPE = FETETRAHEDRON
0.0 0.0 0.0
"""


@pytest.fixture
def impatient() -> Iterator[ReadingProcess]:
    """A reading process with less time to wait for each file."""
    process = ReadingProcess(waiting=0.5)
    yield process
    process.end()


@pytest.mark.parametrize(
    ("name", "text"),
    [("cut.msh", CUT_ANSYS), ("cut.tec", CUT_TECPLOT)],
)
def test_endless_readers_are_ended(
    cube: TetMesh, tmp_path: Path, name: str, text: str, impatient: ReadingProcess
) -> None:
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(MeshError, match=r"its reader did not finish in") as caught:
        read_tets(path, impatient)
    assert str(caught.value).startswith(f"{path}: cannot be read as a {path.suffix} mesh: ")
    # and the next file is read as ever
    cube.write(tmp_path / "good.vtu")
    assert len(read_tets(tmp_path / "good.vtu", impatient).tets) == 6


def test_a_side_file_that_blocks_is_given_up(tmp_path: Path, impatient: ReadingProcess) -> None:
    (tmp_path / "body.ele").write_text("1 4 0\n1 1 2 3 4\n")
    os.mkfifo(tmp_path / "body.node")
    with pytest.raises(MeshError, match=r"body\.ele: .*: its reader did not finish in time"):
        read_tets(tmp_path / "body.ele", impatient)
    assert impatient.number is None


def test_a_demand_for_all_memory_is_refused(tmp_path: Path) -> None:
    count = 10**11
    text = "# vtk DataFile Version 3.0\nt\nBINARY\nDATASET UNSTRUCTURED_GRID\n"
    (tmp_path / "huge.vtk").write_text(f"{text}POINTS {count} double\n")
    with pytest.raises(MeshError, match=r"huge\.vtk: cannot be read"):
        TetMesh.read(tmp_path / "huge.vtk")


def test_a_pipe_is_no_file(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.vtu")
    with pytest.raises(MeshError, match="there is no such file"):
        TetMesh.read(tmp_path / "pipe.vtu")


def test_material_files_are_not_opened(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.mtl")
    lines = ["mtllib pipe.mtl", "usemtl a", "v 0 0 0", "v 1 0 0", "v 0 1 0", "v 0 0 1"]
    lines += ["f 1 3 2", "f 1 2 4", "f 2 3 4", "f 1 4 3"]
    (tmp_path / "body.obj").write_text("\n".join(lines))
    assert load_surface(tmp_path / "body.obj").volume == pytest.approx(1.0 / 6.0)


def test_the_reading_process_is_kept_and_started_anew(cube: TetMesh, tmp_path: Path) -> None:
    cube.write(tmp_path / "good.msh")
    TetMesh.read(tmp_path / "good.msh")
    first = READER.number
    TetMesh.read(tmp_path / "good.msh")
    assert first is not None and READER.number == first
    os.kill(first, signal.SIGKILL)
    assert len(TetMesh.read(tmp_path / "good.msh").tets) == 6
    assert READER.number != first


def test_a_fork_has_a_reading_process_of_its_own(cube: TetMesh, tmp_path: Path) -> None:
    cube.write(tmp_path / "good.vtu")
    TetMesh.read(tmp_path / "good.vtu")
    fork = os.fork()
    if fork == 0:
        found = 1
        try:
            found = int(len(TetMesh.read(tmp_path / "good.vtu").tets) != 6)
            READER.end()
        finally:
            os._exit(found)
    assert os.waitstatus_to_exitcode(os.waitpid(fork, 0)[1]) == 0
    assert len(TetMesh.read(tmp_path / "good.vtu").tets) == 6


def test_a_missing_package_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "body.e").write_bytes(b"CDF\x01")
    with pytest.raises(MeshError, match=r"body\.e: cannot be read as a \.e mesh: ") as caught:
        TetMesh.read(tmp_path / "body.e")
    assert "No module named" not in str(caught.value)


@pytest.mark.parametrize("name", ["empty.node", "empty.ele", "empty.avs"])
def test_empty_files(tmp_path: Path, name: str) -> None:
    for suffix in (".node", ".ele", ".avs"):
        (tmp_path / f"empty{suffix}").write_text("# only a comment\n")
    with pytest.raises(MeshError, match="it holds no line but comments"):
        TetMesh.read(tmp_path / name)


def test_a_side_file_that_is_missing_is_named(tmp_path: Path) -> None:
    (tmp_path / "body.ele").write_text("1 4 0\n1 1 2 3 4\n")
    with pytest.raises(MeshError, match=r"body\.node: No such file or directory"):
        TetMesh.read(tmp_path / "body.ele")


def test_other_files_are_read_only_where_asked_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "other.inp")
    (tmp_path / "body.inp").write_text("*NODE\n1,0,0,0\n*INCLUDE, INPUT=other.inp\n")
    with pytest.raises(MeshError, match=r"\*INCLUDE of another file is not taken"):
        TetMesh.read(tmp_path / "body.inp")


def test_files_with_a_longer_name_are_not_read_with_it(cube: TetMesh, tmp_path: Path) -> None:
    meshio.Mesh(cube.points, [("tetra", cube.tets)]).write(tmp_path / "body.xml")
    os.mkfifo(tmp_path / "body_more.xml")
    assert len(TetMesh.read(tmp_path / "body.xml").tets) == 6
