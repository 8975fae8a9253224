"""Repairs of meshes and readers of surface files, on generated meshes and small files."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.support.bodies import box
from warp_softbody.body.mesh_checks import clean_arrays
from warp_softbody.body.mesh_formats.contents import ReadingFailed
from warp_softbody.body.mesh_formats.surface_files import READERS, read_surface
from warp_softbody.body.mesh_geometry import tet_volumes

CUBE = box((1, 2, 2))
POINTS = len(CUBE.points)
coordinates = st.floats(-1e6, 1e6)
points_of_files = st.lists(st.tuples(coordinates, coordinates, coordinates), min_size=3, max_size=8)


@given(st.permutations(range(POINTS)), st.lists(st.booleans(), min_size=1), st.integers(0, 5))
def test_a_mesh_written_in_any_order_is_the_same_body(
    order: list[int], turned: list[bool], spare: int
) -> None:
    """Points in another order, tets inside out, points that no tet uses."""
    number = np.argsort(order)
    points = np.concatenate([CUBE.points[order], np.full((spare, 3), 7.0)])
    tets = number[CUBE.tets]
    flip = np.resize(turned, len(tets))
    tets[flip] = tets[flip][:, [1, 0, 2, 3]]
    clean = clean_arrays(points, tets, source="it", allow_parts=False)
    assert len(clean.points) == POINTS and len(clean.notes) == bool(spare)
    np.testing.assert_array_equal(clean.points[clean.node_of[:POINTS]], points[:POINTS])
    assert (clean.node_of[POINTS:] == -1).all()
    volumes = tet_volumes(clean.points, clean.tets)
    np.testing.assert_allclose(volumes, tet_volumes(CUBE.points, CUBE.tets), rtol=1e-13)


@given(st.lists(st.integers(0, len(CUBE.tets) - 1), min_size=1, max_size=4, unique=True))
def test_tets_with_points_of_their_own_are_joined(apart: list[int]) -> None:
    """As files have them that repeat the points of each cell."""
    points, tets = CUBE.points.copy(), CUBE.tets.copy()
    for tet in apart:
        points, tets[tet] = np.concatenate([points, points[tets[tet]]]), len(points) + np.arange(4)
    clean = clean_arrays(points, tets, source="it", allow_parts=False)
    assert len(clean.points) == POINTS
    np.testing.assert_array_equal(clean.points[clean.tets], points[tets])


def write(kind: str, points: Sequence[tuple[float, ...]], faces: Sequence[list[int]]) -> str:
    """A surface file of a format that is text."""
    lines = [" ".join(map(repr, point)) for point in points]
    counted = [" ".join(map(str, [len(face), *face])) for face in faces]
    if kind == ".off":
        return "\n".join(["OFF", f"{len(points)} {len(faces)} 0", *lines, *counted, ""])
    if kind == ".obj":
        corners = [" ".join(str(corner + 1) for corner in face) for face in faces]
        return "\n".join([*(f"v {line}" for line in lines), *(f"f {c}" for c in corners), ""])
    header = ["ply", "format ascii 1.0", f"element vertex {len(points)}"]
    header += [f"property double {axis}" for axis in "xyz"]
    header += [f"element face {len(faces)}", "property list uchar int vertex_indices"]
    return "\n".join([*header, "end_header", *lines, *counted, ""])


@st.composite
def surfaces(draw: st.DrawFn) -> tuple[list[tuple[float, float, float]], list[list[int]]]:
    points = draw(points_of_files)
    corner = st.integers(0, len(points) - 1)
    faces = draw(st.lists(st.lists(corner, min_size=3, max_size=5), min_size=1, max_size=6))
    return points, faces


def read(kind: str, contents: bytes) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"surface{kind}"
        path.write_bytes(contents)
        found = read_surface(path)
    return found.points, found.faces


@pytest.mark.parametrize("kind", [".off", ".obj", ".ply"])
@given(surfaces())
def test_what_is_written_is_read(
    kind: str, surface: tuple[list[tuple[float, float, float]], list[list[int]]]
) -> None:
    points, faces = surface
    found, triangles = read(kind, write(kind, points, faces).encode())
    np.testing.assert_array_equal(found, points)
    fans = [[face[0], face[k], face[k + 1]] for face in faces for k in range(1, len(face) - 1)]
    assert triangles.tolist() == fans


@pytest.mark.parametrize("kind", [".off", ".ply"])
@given(surfaces(), st.data())
def test_a_file_that_ends_early_is_refused(
    kind: str,
    surface: tuple[list[tuple[float, float, float]], list[list[int]]],
    data: st.DataObject,
) -> None:
    lines = write(kind, *surface).splitlines()
    kept = data.draw(st.integers(0, len(lines) - 1))
    with pytest.raises(ReadingFailed):
        read(kind, "\n".join(lines[:kept]).encode())


@pytest.mark.parametrize("kind", sorted(READERS))
@given(st.one_of(st.binary(max_size=200), st.text(max_size=200).map(str.encode)), st.booleans())
def test_any_bytes_are_read_or_refused(kind: str, noise: bytes, behind: bool) -> None:
    """Also behind the start of a good file; what is read has corners that exist."""
    start = write(kind if kind != ".stl" else ".off", [(0.0, 0.0, 0.0)] * 3, [[0, 1, 2]])
    try:
        points, triangles = read(kind, start.encode() + noise if behind else noise)
    except ReadingFailed as failure:
        assert len(str(failure).splitlines()) <= 1
        return
    assert triangles.size == 0 or 0 <= triangles.min() <= triangles.max() < len(points)
