"""How far a body sags and sways under its own weight: linear elasticity of its tets."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_array, csc_array
from scipy.sparse.linalg import splu

from warp_softbody.arrays import BoolArray
from warp_softbody.body.mesh import TetMesh
from warp_softbody.body.mesh_geometry import lumped_masses


class Yielding(NamedTuple):
    """Ways of the centre of mass under the body's own weight, m, of a Young's modulus of 1 Pa.

    Attributes:
        sag: down, as it stands.
        sway: aside, by its weight along the level way in which it yields most.
        height: m, of the centre of mass over what it stands on.
    """

    sag: float
    sway: float
    height: float


def yielding(mesh: TetMesh, held: BoolArray, poisson_ratio: float, weight: float) -> Yielding:
    """How a body yields to a weight, N, spread as its mass is, while a mask (n,) of nodes is held.

    Constant strain in each tet: K = V B^T D B (Zienkiewicz and Taylor, The Finite Element Method,
    chapter 9). Way and modulus are inverse to each other, so that one solve tells all.
    """
    stiffness = _stiffness(mesh, poisson_ratio)
    shares = lumped_masses(mesh.tets, mesh.volumes, len(mesh.points))
    shares = shares / shares.sum()
    free = np.repeat(~held, 3)
    loads = (weight * shares[:, None, None] * np.eye(3)).reshape(-1, 3)[free]
    moved = splu(csc_array(stiffness[free][:, free])).solve(loads)
    # of the centre of mass (rows) by the weight along each axis (columns)
    ways = (shares[:, None, None] * np.eye(3)).reshape(-1, 3)[free].T @ moved
    height = float(shares @ mesh.points[:, 2]) - float(mesh.points[held, 2].mean())
    return Yielding(float(ways[2, 2]), float(np.linalg.eigvalsh(ways[:2, :2])[-1]), height)


def _stiffness(mesh: TetMesh, poisson_ratio: float) -> csc_array:
    """Of all nodes, (3n, 3n) N/m, for a Young's modulus of 1 Pa."""
    corners = mesh.points[mesh.tets]
    edges = corners[:, 1:] - corners[:, :1]
    inner = np.linalg.inv(edges).transpose(0, 2, 1)
    slopes = np.concatenate([-inner.sum(axis=1, keepdims=True), inner], axis=1)
    share = 1.0 / (1.0 + poisson_ratio)
    shear, pressure = 0.5 * share, poisson_ratio * share / (1.0 - 2.0 * poisson_ratio)
    products = np.einsum("tai,tbj->tabij", slopes, slopes)
    blocks = pressure * products + shear * products.swapaxes(3, 4)
    blocks += shear * np.trace(products, axis1=3, axis2=4)[..., None, None] * np.eye(3)
    blocks *= mesh.volumes[:, None, None, None, None]
    numbers = 3 * mesh.tets[:, :, None] + np.arange(3)
    rows = np.broadcast_to(numbers[:, :, None, :, None], blocks.shape)
    columns = np.broadcast_to(numbers[:, None, :, None, :], blocks.shape)
    size = 3 * len(mesh.points)
    entries = (blocks.ravel(), (rows.ravel(), columns.ravel()))
    return csc_array(coo_array(entries, shape=(size, size)))
