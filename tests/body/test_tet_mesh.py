"""What a mesh knows about itself, on the unit cube."""

from __future__ import annotations

from dataclasses import FrozenInstanceError

import numpy as np
import pytest
from numpy.typing import NDArray

from warp_softbody.body.mesh import TetMesh


def test_cube_geometry(cube: TetMesh) -> None:
    np.testing.assert_allclose(cube.volumes, 1.0 / 6.0, rtol=1e-14)
    assert cube.volume == pytest.approx(1.0, rel=1e-14)
    np.testing.assert_array_equal(cube.bounds, [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]])
    assert cube.part_count == 1
    # A Kuhn tet has dihedral angles of 45, 60 and 90 degrees.
    assert cube.smallest_dihedral_angle == pytest.approx(45.0, abs=1e-10)


def test_regular_tet_has_the_best_angle() -> None:
    points = np.array([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
    mesh = TetMesh.from_arrays(points, [[0, 1, 2, 3]])
    assert mesh.smallest_dihedral_angle == pytest.approx(np.degrees(np.arccos(1 / 3)), abs=1e-10)


def test_surface_is_closed_and_outward(cube: TetMesh) -> None:
    assert cube.surface.shape == (12, 3) and cube.surface.dtype == np.int32
    a, b, c = (cube.points[cube.surface[:, i]] for i in range(3))
    # The divergence theorem gives the volume only when every triangle faces out.
    enclosed = np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0
    assert enclosed == pytest.approx(cube.volume, rel=1e-14)
    np.testing.assert_array_equal(np.cross(b - a, c - a).sum(axis=0), 0.0)
    np.testing.assert_array_equal(cube.surface_nodes, np.arange(8))


def test_inner_nodes_are_not_on_the_surface() -> None:
    corners = np.array([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1], [0, 0, 0]])
    mesh = TetMesh.from_arrays(corners, [[0, 1, 2, 4], [0, 1, 3, 4], [0, 2, 3, 4], [1, 2, 3, 4]])
    np.testing.assert_array_equal(mesh.surface_nodes, [0, 1, 2, 3])
    assert len(mesh.surface) == 4


def test_arrays_are_read_only_copies(cube_points: NDArray[np.float64]) -> None:
    mesh = TetMesh.from_arrays(cube_points[[0, 1, 2, 4]], [[0, 1, 2, 3]])
    cube_points[0] = 9.0
    assert mesh.bounds[1, 0] == 1.0
    assert mesh.node_of.tolist() == [0, 1, 2, 3]
    for array in (mesh.points, mesh.tets, mesh.surface, mesh.volumes, mesh.bounds, mesh.node_of):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0
    with pytest.raises(FrozenInstanceError):
        mesh.points = cube_points  # type: ignore[misc]
