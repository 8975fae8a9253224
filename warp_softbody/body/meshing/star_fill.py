"""Tets within a closed surface out of which one point sees all triangles: one for each triangle.

Their surface is the given one, to the last bit. They are meant for bodies that do not deform.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
from scipy.optimize import linprog

from warp_softbody.arrays import FloatArray
from warp_softbody.body.mesh import TetMesh
from warp_softbody.body.meshing.surface import Surface, load_surface

if TYPE_CHECKING:
    import trimesh

LEAST_SIGHT = 1e-3
"""Part of the box's diagonal that the point must be behind the plane of every triangle."""


def rigid_mesh(surface: str | Path | trimesh.Trimesh) -> TetMesh:
    """Tets of a closed surface, for a body that does not deform.

    Where no point sees all of its triangles, fTetWild fills it and its surface is close to, but not
    that given.

    Raises:
        MeshError: the surface is unusable, as for `TetMesh.from_surface`.
    """
    loaded = load_surface(surface)
    center = _seeing_all(loaded)
    if center is None:
        return TetMesh.from_surface(surface)
    points = np.concatenate([loaded.points, center[None]])
    last = np.full(len(loaded.faces), len(loaded.points))
    # outward triangles seen from within turn clockwise
    tets = np.column_stack([loaded.faces[:, [0, 2, 1]], last])
    return TetMesh.from_arrays(points, tets.astype(np.int32))


def _seeing_all(surface: Surface) -> FloatArray | None:
    """The point farthest behind the planes of all triangles; None where none is behind all."""
    corners = surface.points[surface.faces]
    normals: npt.NDArray[np.float64] = np.cross(
        corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    )
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    # the largest r with n . p + r <= n . a for every triangle through a
    rows = np.column_stack([normals, np.ones(len(normals))])
    sides = np.einsum("ij,ij->i", normals, corners[:, 0])
    found = linprog(
        (0.0, 0.0, 0.0, -1.0), A_ub=rows, b_ub=sides, bounds=[(None, None)] * 3 + [(0.0, None)]
    )
    place = np.asarray(found.x)
    if not found.success or place[3] < LEAST_SIGHT * surface.diagonal:
        return None
    return place[:3]
