"""The step's matrix at the rest shape, on the host: what coarse levels are made of."""

from __future__ import annotations

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.body.mesh import TetMesh
from warp_softbody.body.mesh_geometry import inverse_edges
from warp_softbody.linear.block_sparsity import Topology


def rest_gradients(mesh: TetMesh) -> FloatArray:
    """Rest gradients of the shape functions, (m, 4, 3) 1/m."""
    inverse = inverse_edges(mesh.points, mesh.tets)
    return np.concatenate([-inverse.sum(axis=1, keepdims=True), inverse], axis=1)


def rest_matrix(
    mesh: TetMesh,
    topology: Topology,
    masses: FloatArray,
    lame: FloatArray,
    volumes: FloatArray | None = None,
) -> FloatArray:
    """Lumped masses (n,) and the stiffness of mu and lambda (e, 2) of each edge, at rest.

    ``volumes`` (m,) m^3 are those of `Scene.elastic_volumes`, else the mesh's own. As blocks
    (blocks, 3, 3) of the pattern.
    """
    weights = np.sqrt(mesh.volumes if volumes is None else volumes)
    gradients = (rest_gradients(mesh) * weights[:, None, None]).reshape(-1, 3)
    edge_of = np.repeat(np.arange(len(topology.edge_slots)), np.diff(topology.edge_start))
    low, high = gradients[topology.edge_corners[:, 0]], gradients[topology.edge_corners[:, 1]]
    outer = np.stack(
        [
            np.bincount(edge_of, low[:, i] * high[:, j], len(topology.edge_slots))
            for i in range(3)
            for j in range(3)
        ],
        axis=1,
    ).reshape(-1, 3, 3)
    trace = np.trace(outer, axis1=1, axis2=2)[:, None, None] * np.eye(3)
    mu, lam = lame.T[:, :, None, None]
    block = lam * outer + mu * (outer.transpose(0, 2, 1) + trace)
    values = np.zeros((len(topology.column), 3, 3))
    values[topology.edge_slots[:, 0]] = block
    values[topology.edge_slots[:, 1]] = block.transpose(0, 2, 1)
    # a translation is in the null space of K, so its rows sum to nothing
    sums = np.add.reduceat(values, topology.row_start[:-1], axis=0)
    values[topology.diagonal_slot] = masses[:, None, None] * np.eye(3) - sums
    return values
