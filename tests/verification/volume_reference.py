"""Tets that resist their exact change of volume once more, in NumPy, to compare with."""

from __future__ import annotations

import numpy as np

from tests.verification import reference
from tests.verification.smoothed_reference import by_edge, by_node
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


def smoothed_volume_energy(mesh: TetMesh, material: Material, positions: FloatArray) -> float:
    """``sum V mu |F - R|^2`` over edges and ``sum V lambda/2 (J - 1)^2`` over nodes."""
    F = reference.deformation_gradients(mesh, positions)
    edges, nodes = by_edge(mesh), by_node(mesh)
    shear, swelling = edges.average(F), nodes.means @ np.linalg.det(F) - 1.0
    gap = shear - reference.polar_rotations(shear)
    energy = material.lame_mu * (edges.volumes @ (gap**2).sum(axis=(1, 2)))
    return float(energy + 0.5 * material.lame_lambda * (nodes.volumes @ swelling**2))


def volume_slopes(mesh: TetMesh, positions: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Derivatives (n, 3n) of the nodes' J by all coordinates, and the nodes' volumes (n,)."""
    F = reference.deformation_gradients(mesh, positions)
    by_corner = np.einsum("mij,maj->mai", cofactors(F), reference.rest_gradients(mesh))
    slopes = np.zeros((len(mesh.tets), len(positions), 3))
    tet = np.arange(len(mesh.tets))[:, None]
    slopes[tet, mesh.tets] = by_corner
    nodes = by_node(mesh)
    return np.asarray(nodes.means @ slopes.reshape(len(slopes), -1)), nodes.volumes


def smoothed_volume_forces(mesh: TetMesh, material: Material, positions: FloatArray) -> FloatArray:
    """Minus the derivative of the smoothed energy, (n, 3) N."""
    F = reference.deformation_gradients(mesh, positions)
    edges = by_edge(mesh)
    shear = edges.average(F)
    P = 2.0 * material.lame_mu * (shear - reference.polar_rotations(shear))
    rows = np.asarray(edges.means.T @ (edges.volumes[:, None] * P.reshape(-1, 9)))
    rows = rows.reshape(-1, 3, 3)
    by_corner = -np.einsum("mij,maj->mai", rows, reference.rest_gradients(mesh))
    forces = np.zeros_like(positions)
    np.add.at(forces, mesh.tets, by_corner)
    slopes, volumes = volume_slopes(mesh, positions)
    swelling = by_node(mesh).means @ np.linalg.det(F) - 1.0
    pressures = material.lame_lambda * (volumes * swelling)
    return np.asarray(forces - (pressures @ slopes).reshape(-1, 3))
