"""Directions that are given at rest and carried with the body, by a matrix made once."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import scipy.sparse as sp

from warp_softbody.body.mesh import TetMesh


@lru_cache(maxsize=8)
def carrier_of(mesh: TetMesh, directions: bytes) -> sp.csr_array:
    """Matrix (n, n) that takes positions to the directions (n, 3) that each node carries.

    They are turned with the mean deformation gradient of the tets around a node, which is linear
    in the positions.
    """
    forward = np.frombuffer(directions).reshape(-1, 3)
    corners = mesh.points[mesh.tets]
    inverse = np.linalg.inv(corners[:, 1:] - corners[:, :1])
    nodes = mesh.tets.ravel()
    around = np.bincount(nodes, minlength=len(mesh.points))
    # One row of four weights on a tet's corners for each of its corners.
    edges = np.einsum("tci,tij->tcj", forward[mesh.tets], inverse)
    weights = np.concatenate([-edges.sum(axis=2, keepdims=True), edges], axis=2)
    weights /= around[mesh.tets][:, :, None]
    rows, columns = np.repeat(nodes, 4), np.repeat(mesh.tets, 4, axis=0).ravel()
    size = (len(mesh.points), len(mesh.points))
    return sp.csr_array((weights.ravel(), (rows, columns)), shape=size)
