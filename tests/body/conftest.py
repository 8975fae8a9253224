"""Meshes that the tests of this folder share, as fixtures."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
import trimesh

from warp_softbody.body.mesh import TetMesh

# The six Kuhn tets of the unit cube: paths from corner 0 to corner 7 along its edges.
KUHN = [[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]]


@pytest.fixture
def cube_points() -> npt.NDArray[np.float64]:
    """Corners (8, 3) of the unit cube."""
    return np.array([[x, y, z] for z in (0.0, 1.0) for y in (0.0, 1.0) for x in (0.0, 1.0)])


@pytest.fixture
def cube_tets() -> npt.NDArray[np.int32]:
    """Six tets (6, 4) that fill the unit cube."""
    return np.array(KUHN, dtype=np.int32)


@pytest.fixture
def cube(cube_points: npt.NDArray[np.float64], cube_tets: npt.NDArray[np.int32]) -> TetMesh:
    """The unit cube."""
    return TetMesh.from_arrays(cube_points, cube_tets)


@pytest.fixture
def box() -> trimesh.Trimesh:
    """Closed surface of a 1 x 0.5 x 0.3 m box."""
    surface: trimesh.Trimesh = trimesh.creation.box((1.0, 0.5, 0.3))
    return surface
