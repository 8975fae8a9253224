"""What `from_arrays` repairs, and each sentence with which it refuses."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray

from warp_softbody.body.close_points import first_of_close
from warp_softbody.body.mesh import TetMesh
from warp_softbody.errors import MeshError, MeshWarning

CORNER = [[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
FLAT = [[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]


def test_orientation_is_repaired(
    cube: TetMesh, cube_points: NDArray[np.float64], cube_tets: NDArray[np.int32]
) -> None:
    mixed = cube_tets.copy()
    mixed[::2] = mixed[::2][:, [1, 0, 2, 3]]
    mesh = TetMesh.from_arrays(cube_points, mixed)
    assert (mesh.volumes > 0.0).all()
    assert mesh.volume == pytest.approx(cube.volume, rel=1e-14)


def test_duplicate_points_are_merged(
    cube_points: NDArray[np.float64], cube_tets: NDArray[np.int32]
) -> None:
    soup = cube_points[cube_tets].reshape(-1, 3)
    soup = soup + np.random.default_rng(0).uniform(-1e-10, 1e-10, soup.shape)
    with pytest.warns(MeshWarning, match="arrays: 16 of 24 points were merged with others"):
        mesh = TetMesh.from_arrays(soup, np.arange(len(soup)).reshape(-1, 4))
    assert mesh.points.shape == (8, 3)
    assert mesh.part_count == 1 and len(mesh.surface) == 12


def test_unused_points_are_dropped_in_order() -> None:
    points = np.array([[9.0, 9, 9], *CORNER[:2], [8.0, 8, 8], *CORNER[2:]])
    with pytest.warns(MeshWarning, match="arrays: 2 of 6 points are in no tet and were dropped"):
        mesh = TetMesh.from_arrays(points, [[1, 2, 4, 5]])
    np.testing.assert_array_equal(mesh.points, CORNER)
    np.testing.assert_array_equal(mesh.tets, [[0, 1, 2, 3]])


def test_byte_order_becomes_native() -> None:
    mesh = TetMesh.from_arrays(np.array(CORNER, ">f8"), np.array([[0, 1, 2, 3]], ">i8"))
    assert mesh.points.dtype == np.float64 and mesh.points.dtype.isnative
    assert mesh.tets.dtype == np.int32 and mesh.tets.dtype.isnative


@pytest.mark.parametrize(
    ("points", "tets", "sentence"),
    [
        ("words", [[0, 1, 2, 3]], "points are not numbers"),
        ([[*"123"]] * 4, [[0, 1, 2, 3]], "points are not numbers, but of the type <U1"),
        (np.ones((4, 3), bool), [[0, 1, 2, 3]], "points are not numbers, but of the type bool"),
        (np.ones((4, 3), complex), [[0, 1, 2, 3]], "points are not numbers, but of the type compl"),
        ([*CORNER[:3], [0, 1e300, 1]], [[0, 1, 2, 3]], "point 3 lies too far from the origin"),
        (np.zeros((4, 2)), [[0, 1, 2, 3]], r"points must have shape \(n, 3\), got \(4, 2\)"),
        ([*CORNER[:3], [0, np.nan, 1]], [[0, 1, 2, 3]], r"point 3 is not finite: \[0.0, nan, 1.0"),
        ([*CORNER[:3], [0, np.inf, 1]], [[0, 1, 2, 3]], "point 3 is not finite"),
        (CORNER, [], "the mesh is empty: it has no tets"),
        (CORNER, np.zeros((0, 4), dtype=int), "the mesh is empty"),
        (CORNER, [[0, 1, 2]], r"tets must have shape \(m, 4\), got \(1, 3\)"),
        (CORNER, [[0, 1, 2, 3], [0, 1]], "tets are not an array"),
        (CORNER, [[0.0, 1.0, 2.0, 3.0]], "tets must hold integers, got dtype float64"),
        (CORNER, [[0, 1, 2, 1.7]], "tets must hold integers, got dtype float64"),
        (CORNER, np.ones((1, 4), bool), "tets must hold integers, got dtype bool"),
        (CORNER, [[0, 1, 2, 2**70]], "tets must hold integers, got dtype object"),
        (CORNER, [[0, 1, 2, 2**32 + 3]], "tets hold point index 4294967299, which is out of range"),
        (CORNER, [[0, 1, 2, -1]], "tets hold point index -1, which is out of range"),
        (CORNER, [[0, 1, 2, 2**40]], "tets hold point index 1099511627776, which is out of range"),
        (CORNER, [[0, 1, 2, 4]], "tets hold point index 4, but there are 4 points"),
        (CORNER, [[0, 1, 2, 2]], "tet 0 has no volume: two of its corners are one point"),
        (FLAT, [[0, 1, 2, 3]], "tet 0 has no volume .* lie in one plane"),
        ([*CORNER, [0.1, 0.1, 0.5]], [[0, 1, 2, 3], [0, 1, 2, 4]], "tets 0 and 1 overlap"),
        (
            [*CORNER, [0, 0, -1], [0, 0, 2]],
            [[0, 1, 2, 3], [0, 1, 2, 4], [0, 1, 2, 5]],
            "1 faces are shared by more than two tets",
        ),
    ],
)
def test_refusals(points: ArrayLike, tets: ArrayLike, sentence: str) -> None:
    with pytest.raises(MeshError, match=f"^here: .*{sentence}") as caught:
        TetMesh.from_arrays(points, tets, source="here")
    assert "\n" not in str(caught.value)


def test_parts_only_when_allowed(
    cube_points: NDArray[np.float64], cube_tets: NDArray[np.int32]
) -> None:
    points = np.concatenate([cube_points, cube_points + 5.0])
    tets = np.concatenate([cube_tets, cube_tets + 8])
    with pytest.raises(MeshError, match=r"2 separate parts.*allow_parts=True"):
        TetMesh.from_arrays(points, tets)
    assert TetMesh.from_arrays(points, tets, allow_parts=True).part_count == 2


def test_cubes_that_share_only_an_edge_are_two_parts(
    cube_points: NDArray[np.float64], cube_tets: NDArray[np.int32]
) -> None:
    points = np.concatenate([cube_points, cube_points + np.array([1.0, 1.0, 0.0])])
    tets = np.concatenate([cube_tets, cube_tets + 8])
    with pytest.raises(MeshError, match="2 separate parts"):
        TetMesh.from_arrays(points, tets)


def test_many_points_at_one_place_cost_no_pairs(cube: TetMesh) -> None:
    heap = np.concatenate([np.full((20_000, 3), 0.3), cube.points])
    with pytest.warns(MeshWarning, match="20000 of 20008 points are in no tet"):
        mesh = TetMesh.from_arrays(heap, cube.tets + 20_000)
    np.testing.assert_array_equal(mesh.points, cube.points)
    # every pair of them would be 2e8 pairs
    np.testing.assert_array_equal(first_of_close(heap[:20_000], 1e-9), 0)


def test_close_points_are_those_within_the_tolerance() -> None:
    rng = np.random.default_rng(2)
    grid = np.array([[x, y, z] for x in range(5) for y in range(5) for z in range(5)], dtype=float)
    copies = np.concatenate([grid, grid + rng.uniform(-1e-4, 1e-4, grid.shape)])
    np.testing.assert_array_equal(first_of_close(copies, 1e-3), np.tile(np.arange(125), 2))
    np.testing.assert_array_equal(first_of_close(copies, 1e-7), np.arange(250))


@pytest.mark.parametrize("scale", [1e-6, 4e-4, 1e3])
def test_small_and_large_bodies_are_one_body_scaled(cube: TetMesh, scale: float) -> None:
    mesh = TetMesh.from_arrays(scale * cube.points, cube.tets)
    np.testing.assert_array_equal(mesh.tets, cube.tets)
    assert mesh.volume == pytest.approx(scale**3 * cube.volume, rel=1e-12)
    with pytest.raises(MeshError, match="lie in one plane"):
        TetMesh.from_arrays(scale * np.array(FLAT), [[0, 1, 2, 3]])


@pytest.fixture
def shifted(cube: TetMesh) -> TetMesh:
    """The cube behind an unused point, with a copy of its corner 3 used by one tet."""
    points = np.concatenate([[[9.0, 9.0, 9.0]], cube.points, cube.points[3:4]])
    tets = cube.tets + 1
    tets[0][tets[0] == 4] = 9
    with pytest.warns(MeshWarning):
        return TetMesh.from_arrays(points, tets)


def test_numbers_of_the_array_lead_to_nodes(cube: TetMesh, shifted: TetMesh) -> None:
    np.testing.assert_array_equal(shifted.points, cube.points)
    np.testing.assert_array_equal(shifted.node_of, [-1, 0, 1, 2, 3, 4, 5, 6, 7, 3])
    np.testing.assert_array_equal(shifted.file_nodes, np.arange(1, 9))
    np.testing.assert_array_equal(shifted.nodes_of([9, 1, 4]), [3, 0, 3])
    np.testing.assert_array_equal(cube.file_nodes, np.arange(8))


@pytest.mark.parametrize(
    ("numbers", "sentence"),
    [
        ([0], "point 0 is in no tet"),
        ([10], "number 10 of a point is out of range: 10 were given"),
        ([-1], "number -1 of a point is out of range"),
        ([2**32 + 3], "number 4294967299 of a point is out of range"),
        ([[1], [2, 3]], "numbers of points are not an array"),
        ([1.7], "numbers of points must be integers, got dtype float64"),
        ([True, False], "numbers of points must be integers, got dtype bool"),
    ],
)
def test_numbers_that_lead_to_no_node(shifted: TetMesh, numbers: ArrayLike, sentence: str) -> None:
    with pytest.raises(MeshError, match=sentence):
        shifted.nodes_of(numbers)
