"""Strict readers of surface files: forms that are taken, and each sentence of the others."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from warp_softbody.body.meshing import load_surface
from warp_softbody.errors import MeshError

CORNERS = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n"
PLY = "ply\nformat ascii 1.0\ncomment none\nelement vertex 4\n"
PLY += "property float x\nproperty float y\nproperty float z\nelement face 4\n"
PLY += "property list uchar int vertex_indices\nend_header\n"
FACES = "3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n"
OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"


def volume_of(path: Path, text: str) -> float:
    path.write_text(text)
    return load_surface(path).volume


def test_polygons_and_counting_back(tmp_path: Path) -> None:
    pyramid = "v 0 0 0\nv 1 0 0 1.0\nv 1 1 0\nv 0 1 0 0.5 0.5 0.5\nv 0 0 1 # tip\nvn 0 0 1\n"
    faces = "g a\ns off\nf 4/1/1 3//1 \\\n 2 1\nf 1 2 5\nf 2 3 -1\nf 3 4 5\nf -2 1 -1\n"
    assert volume_of(tmp_path / "p.obj", pyramid + faces) == pytest.approx(1.0 / 3.0)
    square = "COFF\n# comment\n5 5 0\n0 0 0 255 0 0\n1 0 0 0 0 0\n1 1 0 0 0 0\n0 1 0 0 0 0\n"
    square += "0 0 1 0 0 0\n4 3 2 1 0 0.5 0.5 0.5\n3 0 1 4\n3 1 2 4\n3 2 3 4\n3 3 0 4\n"
    assert volume_of(tmp_path / "p.off", square) == pytest.approx(1.0 / 3.0)


@pytest.mark.parametrize("order", ["little", "big"])
def test_binary_ply_of_both_byte_orders(tmp_path: Path, order: str) -> None:
    mark = {"little": "<", "big": ">"}[order]
    header = PLY.replace("ascii", f"binary_{order}_endian").replace(
        "end_header", "property uchar flag\nelement edge 1\nproperty int a\nend_header"
    )
    points = np.array(CORNERS.split(), dtype=mark + "f4").tobytes()
    faces = b"".join(
        b"\x03" + np.array(line.split()[1:], dtype=mark + "i4").tobytes() + b"\x07"
        for line in FACES.splitlines()
    )
    path = tmp_path / "body.ply"
    path.write_bytes(header.encode() + points + faces + bytes(4))
    assert load_surface(path).volume == pytest.approx(1.0 / 6.0)
    path.write_bytes(header.encode() + points + faces + bytes(5))
    with pytest.raises(MeshError, match="1 bytes follow what it declares"):
        load_surface(path)
    path.write_bytes(header.encode() + points + faces)
    with pytest.raises(MeshError, match="it ends before all that it declares"):
        load_surface(path)


def test_binary_stl_that_begins_as_text(tmp_path: Path) -> None:
    path = tmp_path / "body.stl"
    trimesh.creation.box((1.0, 1.0, 1.0)).export(path)
    data = path.read_bytes()
    path.write_bytes(b"solid  " + data[7:])
    assert load_surface(path).volume == pytest.approx(1.0)
    path.write_bytes(data + b"more")
    with pytest.raises(MeshError, match="it has 688 bytes, but 684 with the 12 triangles"):
        load_surface(path)


@pytest.mark.parametrize(
    ("name", "text", "sentence"),
    [
        ("a.ply", PLY + CORNERS + FACES.replace("0 2 1", "0 2 -1"), "a face has point -1, but"),
        ("a.ply", PLY + CORNERS + FACES.replace("0 2 1", "0 2 5000"), "a face has point 5000"),
        ("a.ply", PLY + CORNERS + FACES.replace("0 2 1", "0 2 nan"), "invalid literal"),
        ("a.ply", PLY + CORNERS + FACES + "0 0 0", "it declares 8 points, .* but has 9"),
        ("a.ply", PLY + CORNERS, "it declares 8 points, faces and others, but has 4"),
        ("a.ply", PLY.replace(" y", " w") + CORNERS + FACES, "has no property 'y'"),
        ("a.ply", PLY.replace("vertex 4", "vertex -4") + CORNERS + FACES, "a negative count"),
        ("a.obj", OBJ + "f 1 3 0\n", "line 5 has point 0, but points are counted from 1"),
        ("a.obj", OBJ + "f 1 3 9\n", "a face has point 8, but there are points 0 to 3"),
        ("a.obj", OBJ + "f 1 3\n", "face 0 has 2 corners"),
        ("a.obj", OBJ + "surf 0 1\n", "line 5 begins with 'surf', which is not known"),
        ("a.obj", "v 0 0\n", "the point of line 1 has 2 numbers"),
        ("a.off", f"OFF\n4 4 0\n{CORNERS}{FACES}3 0 1 2\n", "has 9 lines for them"),
        ("a.off", f"OFF\n4 4 0\n{CORNERS}{FACES.replace('3 0 2 1', '3 0 2')}", "has not 3 corners"),
        ("a.off", "OFF BINARY\n", "a binary OFF is not taken"),
        ("a.stl", "solid x\nfacet normal 0 0 1\n", "it ends without endsolid"),
        ("a.stl", "solid x\nfacet normal 0 0 1\nendsolid", "it ends within a triangle"),
        ("a.stl", "\0" * 90, "it has 90 bytes, but 84 with the 0 triangles that it declares"),
    ],
)
def test_refusals(tmp_path: Path, name: str, text: str, sentence: str) -> None:
    path = tmp_path / name
    path.write_text(text)
    start = rf"a\.\w+: cannot be read as a \{path.suffix} surface: "
    with pytest.raises(MeshError, match=f"{start}.*{sentence}"):
        load_surface(path)
