"""The step's linear system in NumPy, double precision, by another road than the kernels take.

Per tet the stiffness matrix of the rest shape, ``K0 = V B^T D B`` in Voigt notation, is computed
once; a step turns it with the tet's rotation, ``K = R K0 R^T``, and its nodal forces are
``-R K0 (R^T x - X)`` (docs/method.md section 1). Rotations come from singular values. The rows and
columns of the matrix are those of the nodes that are not clamped.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp

from warp_softbody.accuracy.runs.peers.beam import GRAVITY, MATERIAL, Cantilever
from warp_softbody.arrays import FloatArray
from warp_softbody.body.material import Material
from warp_softbody.body.mesh import TetMesh
from warp_softbody.body.mesh_geometry import lumped_masses


class CorotationalSystem:
    """``A v+ = b`` of a beam: A = M + dt^2 K, b = M v + dt f, undamped."""

    def __init__(self, beam: Cantilever, time_step: float, *, upper: bool = False) -> None:
        """Rest stiffness and index arrays; ``upper`` keeps only the upper triangle of A."""
        mesh = beam.mesh
        self._mesh, self._time_step = mesh, time_step
        self.gradients = rest_gradients(mesh)
        self._stiffness = _rest_stiffness(mesh, MATERIAL, self.gradients)
        nodes = len(mesh.points)
        self.masses = lumped_masses(mesh.tets, mesh.volumes, nodes, MATERIAL.density)
        self.free = np.flatnonzero(~np.repeat(beam.fixed, 3))
        self._build_pattern(upper)

    def _build_pattern(self, upper: bool) -> None:
        """Find the slot in A's data of every entry of every tet's matrix that is kept."""
        size = len(self.free)
        number = np.full(self._mesh.points.size, -1)
        number[self.free] = np.arange(size)
        unknowns = number[(3 * self._mesh.tets[:, :, None] + np.arange(3)).reshape(-1, 12)]
        rows = np.broadcast_to(unknowns[:, :, None], (len(unknowns), 12, 12))
        columns = rows.transpose(0, 2, 1)
        kept = (rows >= 0) & (columns >= 0)
        if upper:
            kept &= rows <= columns
        self._kept = np.flatnonzero(kept)
        keys = rows.ravel()[self._kept] * size + columns.ravel()[self._kept]
        places, self._slots = np.unique(keys, return_inverse=True)
        self._columns = (places % size).astype(np.int32)
        starts = np.searchsorted(places, np.arange(size + 1) * size)
        self._row_starts = starts.astype(np.int32)
        self._diagonal = np.searchsorted(places, np.arange(size) * (size + 1))

    def _rotations(self, positions: FloatArray) -> FloatArray:
        F = np.einsum("mai,maj->mij", positions[self._mesh.tets], self.gradients)
        U, _, Vt = np.linalg.svd(F)
        U[:, :, 2] *= np.linalg.det(U @ Vt)[:, None]
        return np.asarray(U @ Vt)

    def assemble(self, positions: FloatArray, velocities: FloatArray) -> tuple[Any, FloatArray]:
        """A as a SciPy CSR matrix of the free rows, and b (n, 3) with the clamped nodes' rows."""
        R = self._rotations(positions)
        half = R[:, None] @ self._stiffness.reshape(-1, 4, 3, 12)
        blocks = half.reshape(-1, 12, 4, 3) @ R.transpose(0, 2, 1)[:, None]
        entries = blocks.ravel()[self._kept]
        data = self._time_step**2 * np.bincount(self._slots, entries, len(self._columns))
        data[self._diagonal] += np.repeat(self.masses, 3)[self.free]
        size = len(self.free)
        matrix = sp.csr_matrix((data, self._columns, self._row_starts), shape=(size, size))
        momentum: FloatArray = self.masses[:, None] * velocities
        return matrix, momentum + self._time_step * self._forces(positions, R)

    def _forces(self, positions: FloatArray, R: FloatArray) -> FloatArray:
        tets = self._mesh.tets
        stretched = (positions[tets] @ R - self._mesh.points[tets]).reshape(-1, 12, 1)
        pull = (self._stiffness @ stretched).reshape(-1, 4, 3) @ R.transpose(0, 2, 1)
        forces: FloatArray = self.masses[:, None] * np.array([0.0, 0.0, -GRAVITY])
        for axis in range(3):
            forces[:, axis] -= np.bincount(tets.ravel(), pull[:, :, axis].ravel())
        return forces

    def residual(self, positions: FloatArray, velocities: FloatArray, after: FloatArray) -> float:
        """``|b - A v+| / |b|`` over the free rows; wants the whole of A."""
        matrix, b = self.assemble(positions, velocities)
        right = b.ravel()[self.free]
        left = matrix @ after.ravel()[self.free]
        return float(np.linalg.norm(right - left) / np.linalg.norm(right))


def rest_gradients(mesh: TetMesh) -> FloatArray:
    """Gradients (m, 4, 3) of the shape functions, from N_a(X_b) = delta_ab."""
    corners = mesh.points[mesh.tets]
    system = np.concatenate([np.ones((*corners.shape[:2], 1)), corners], axis=2)
    return np.asarray(np.linalg.inv(system)[:, 1:].transpose(0, 2, 1))


def _rest_stiffness(mesh: TetMesh, material: Material, gradients: FloatArray) -> FloatArray:
    """``V B^T D B`` of each tet, (m, 12, 12)."""
    mu, lam = material.lame_mu, material.lame_lambda
    D = np.diag([2.0 * mu] * 3 + [mu] * 3)
    D[:3, :3] += lam
    B = np.zeros((len(mesh.tets), 6, 4, 3))
    for row, (i, j) in enumerate([(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)]):
        B[:, row, :, i] = gradients[:, :, j]
        B[:, row, :, j] = gradients[:, :, i]
    strain = B.reshape(-1, 6, 12)
    stiffness = strain.transpose(0, 2, 1) @ (D @ strain)
    return np.asarray(mesh.volumes[:, None, None] * stiffness)
