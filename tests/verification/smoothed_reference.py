"""Smoothed tets once more, in NumPy and SciPy and by another road, to compare the kernels with.

Groups of tets, those around an edge and those around a node, hold the averages: a sparse matrix of
volume shares takes tets to groups, and its transpose takes the groups' stresses back.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from scipy.sparse import block_diag, coo_array, csr_array, diags_array, kron

from tests.verification import reference
from tests.verification.accuracy import strain_matrices
from warp_softbody.arrays import FloatArray
from warp_softbody.body.material import Material
from warp_softbody.body.mesh import TetMesh


@dataclass(frozen=True)
class Groups:
    """Tets that share an edge, or a node.

    Attributes:
        volumes: (g,) m^3, which sum to the body's.
        means: (g, m) weights that average over the tets of a group by volume.
    """

    volumes: FloatArray
    means: csr_array[np.float64]

    def average(self, values: FloatArray) -> FloatArray:
        """Of one 3 x 3 matrix a tet, (g, 3, 3)."""
        flat = self.means @ values.reshape(len(values), -1)
        return np.asarray(flat).reshape(-1, *values.shape[1:])


def groups(mesh: TetMesh, corners: int) -> Groups:
    """By node (one corner) or by edge (two): a tet's volume is shared by all its groups."""
    picks = list(itertools.combinations(range(4), corners))
    members = np.sort(mesh.tets[:, picks], axis=2).reshape(-1, corners)
    _, owner = np.unique(members, axis=0, return_inverse=True)
    tet = np.repeat(np.arange(len(mesh.tets)), len(picks))
    share = mesh.volumes[tet] / len(picks)
    volumes = np.asarray(np.bincount(owner.ravel(), share), dtype=np.float64)
    weights = share / volumes[owner.ravel()]
    shape = (len(volumes), len(mesh.tets))
    return Groups(volumes, csr_array(coo_array((weights, (owner.ravel(), tet)), shape=shape)))


def by_edge(mesh: TetMesh) -> Groups:
    """Those of the shear energy."""
    return groups(mesh, 2)


def by_node(mesh: TetMesh) -> Groups:
    """Those of the volume energy."""
    return groups(mesh, 1)


def smoothed_energy(mesh: TetMesh, material: Material, positions: FloatArray) -> float:
    """``sum V mu |F - R|^2`` over edges and ``sum V lambda/2 (tr(R^T F) - 3)^2`` over nodes."""
    F = reference.deformation_gradients(mesh, positions)
    edges, nodes = by_edge(mesh), by_node(mesh)
    shear, volume = edges.average(F), nodes.average(F)
    gap = shear - reference.polar_rotations(shear)
    trace = np.einsum("gij,gij->g", reference.polar_rotations(volume), volume) - 3.0
    energy = material.lame_mu * (edges.volumes @ (gap**2).sum(axis=(1, 2)))
    return float(energy + 0.5 * material.lame_lambda * (nodes.volumes @ trace**2))


def smoothed_forces(mesh: TetMesh, material: Material, positions: FloatArray) -> FloatArray:
    """Minus its derivative, by the chain rule through the averages, (n, 3)."""
    F = reference.deformation_gradients(mesh, positions)
    edges, nodes = by_edge(mesh), by_node(mesh)
    shear, volume = edges.average(F), nodes.average(F)
    R = reference.polar_rotations(volume)
    trace = np.einsum("gij,gij->g", R, volume) - 3.0
    P = 2.0 * material.lame_mu * (shear - reference.polar_rotations(shear))
    Q = material.lame_lambda * trace[:, None, None] * R
    # one row a group, the derivative of its energy by its mean
    rows = edges.means.T @ (edges.volumes[:, None] * P.reshape(-1, 9))
    rows = rows + nodes.means.T @ (nodes.volumes[:, None] * Q.reshape(-1, 9))
    by_corner = -np.einsum("mij,maj->mai", rows.reshape(-1, 3, 3), reference.rest_gradients(mesh))
    forces = np.zeros_like(positions)
    np.add.at(forces, mesh.tets, by_corner)
    return forces


def smoothed_stiffness(mesh: TetMesh, material: Material) -> csr_array[np.float64]:
    """The energy's Hessian at rest, from averaged strains in Voigt notation, sparse (3n, 3n)."""
    dofs = (3 * mesh.tets[:, :, None] + np.arange(3)).reshape(-1, 12)
    count = len(mesh.tets)
    pick = coo_array(
        (np.ones(dofs.size), (np.arange(dofs.size), dofs.ravel())),
        shape=(dofs.size, 3 * mesh.points.shape[0]),
    )
    strains = csr_array(block_diag(list(strain_matrices(mesh)), format="csr") @ pick)
    assert strains.shape[0] == 6 * count
    shear = np.array([2.0, 2.0, 2.0, 1.0, 1.0, 1.0]) * material.lame_mu
    edges, nodes = by_edge(mesh), by_node(mesh)
    mean = csr_array(kron(edges.means, np.eye(6))) @ strains
    K = mean.T @ diags_array(np.kron(edges.volumes, shear)) @ mean
    trace = csr_array(kron(nodes.means, [[1.0, 1.0, 1.0, 0.0, 0.0, 0.0]])) @ strains
    K = K + material.lame_lambda * (trace.T @ diags_array(nodes.volumes) @ trace)
    return csr_array(K)


def smallest_sum(mesh: TetMesh, positions: FloatArray) -> float:
    """Of the two smaller stretches of any mean F, one signed: R is not unique where it is 0."""
    F = reference.deformation_gradients(mesh, positions)
    lowest = np.inf
    for mean in (by_edge(mesh).average(F), by_node(mesh).average(F)):
        s = np.linalg.svd(mean, compute_uv=False)
        lowest = min(lowest, float((s[:, 1] + np.sign(np.linalg.det(mean)) * s[:, 2]).min()))
    return lowest
