"""Tets that resist their exact change of volume once more, in NumPy, to compare with."""

from __future__ import annotations

import numpy as np

from tests.verification import reference
from warp_softbody.arrays import FloatArray
from warp_softbody.body.material import Material
from warp_softbody.body.mesh import TetMesh


def cofactors(F: FloatArray) -> FloatArray:
    """Derivatives of det F, (m, 3, 3), also where F is singular."""
    rows = np.roll(F, -1, axis=1)
    return np.asarray(np.cross(rows, np.roll(F, -2, axis=1)))


def volume_forces(mesh: TetMesh, material: Material, positions: FloatArray) -> FloatArray:
    """``-V0 P g_a`` summed by node, (n, 3) N, P = 2 mu (F - R) + lambda (det F - 1) cof F."""
    F = reference.deformation_gradients(mesh, positions)
    P = 2.0 * material.lame_mu * (F - reference.polar_rotations(F))
    swelling = material.lame_lambda * (np.linalg.det(F) - 1.0)
    P = P + swelling[:, None, None] * cofactors(F)
    gradients = reference.rest_gradients(mesh)
    by_corner = -np.einsum("m,mij,maj->mai", mesh.volumes, P, gradients)
    forces = np.zeros_like(positions)
    np.add.at(forces, mesh.tets, by_corner)
    return forces
