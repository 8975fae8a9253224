"""The method's formulas once more, in NumPy and by another road, to compare the kernels with."""

from __future__ import annotations

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.body.material import Material
from warp_softbody.body.mesh import TetMesh
from warp_softbody.engine.model import Model


def polar_rotations(F: FloatArray) -> FloatArray:
    """Closest proper rotations (m, 3, 3), by singular values with the sign on the smallest."""
    U, _, Vt = np.linalg.svd(F)
    U[:, :, 2] *= np.sign(np.linalg.det(U) * np.linalg.det(Vt))[:, None]
    return np.asarray(U @ Vt)


def rest_gradients(mesh: TetMesh) -> FloatArray:
    """Gradients (m, 4, 3) of the shape functions, from the linear system N_a(X_b) = delta_ab."""
    corners = mesh.points[mesh.tets]
    ones = np.ones((*corners.shape[:2], 1))
    system = np.concatenate([ones, corners], axis=2)
    return np.asarray(np.linalg.inv(system)[:, 1:].transpose(0, 2, 1))


def deformation_gradients(mesh: TetMesh, positions: FloatArray) -> FloatArray:
    """F = sum_a x_a g_a^T, (m, 3, 3)."""
    return np.asarray(np.einsum("mai,maj->mij", positions[mesh.tets], rest_gradients(mesh)))


def elastic_energy(mesh: TetMesh, material: Material, positions: FloatArray) -> float:
    """``sum V0 (mu |F - R|^2 + lambda/2 tr(R^T F - I)^2)``."""
    F = deformation_gradients(mesh, positions)
    R = polar_rotations(F)
    trace = np.einsum("mij,mij->m", R, F) - 3.0
    density = material.lame_mu * ((F - R) ** 2).sum(axis=(1, 2))
    density += 0.5 * material.lame_lambda * trace**2
    return float(mesh.volumes @ density)


def elastic_forces(mesh: TetMesh, material: Material, positions: FloatArray) -> FloatArray:
    """-V0 P g_a summed over the tets of each node, (n, 3)."""
    F = deformation_gradients(mesh, positions)
    R = polar_rotations(F)
    trace = np.einsum("mij,mij->m", R, F) - 3.0
    P = 2.0 * material.lame_mu * (F - R) + material.lame_lambda * trace[:, None, None] * R
    by_corner = -np.einsum("m,mij,maj->mai", mesh.volumes, P, rest_gradients(mesh))
    forces = np.zeros_like(positions)
    np.add.at(forces, mesh.tets, by_corner)
    return forces


def warped_stiffness(mesh: TetMesh, material: Material, positions: FloatArray) -> FloatArray:
    """``sum_e V0 R B^T D B R^T`` in Voigt notation, dense (3n, 3n)."""
    mu, lam = material.lame_mu, material.lame_lambda
    D = np.diag([2.0 * mu] * 3 + [mu] * 3)
    D[:3, :3] += lam
    R = polar_rotations(deformation_gradients(mesh, positions))
    K = np.zeros((positions.size, positions.size))
    for tet, g, rotation, volume in zip(
        mesh.tets, rest_gradients(mesh), R, mesh.volumes, strict=True
    ):
        B = np.zeros((6, 12))
        for a in range(4):
            x, y, z = g[a]
            B[:, 3 * a : 3 * a + 3] = [
                [x, 0, 0],
                [0, y, 0],
                [0, 0, z],
                [y, x, 0],
                [0, z, y],
                [z, 0, x],
            ]
        warp = np.kron(np.eye(4), rotation)
        dofs = (3 * tet[:, None] + np.arange(3)).ravel()
        K[np.ix_(dofs, dofs)] += volume * warp @ B.T @ D @ B @ warp.T
    return K


def step_matrix(model: Model, positions: FloatArray) -> FloatArray:
    """``M~ = (1 + dt mu) M + (dt lambda + dt^2) K``, dense (3n, 3n)."""
    material, dt = model.scene.character.material, model.options.time_step
    K = warped_stiffness(model.scene.character.mesh, material, positions)
    mass = np.diag(np.repeat(model.masses, 3))
    return (1.0 + dt * material.mass_damping) * mass + dt * (material.stiffness_damping + dt) * K


def block_matrix(model: Model, values: FloatArray) -> FloatArray:
    """3 x 3 blocks in the engine's slots as a dense (3n, 3n) matrix."""
    n, t = model.node_count, model.topology
    rows = np.repeat(np.arange(n), np.diff(t.row_start))
    dense = np.zeros((n, 3, n, 3))
    dense[rows, :, t.column, :] = values
    return dense.reshape(3 * n, 3 * n)


def segment_lengths(character: Character, positions: FloatArray) -> FloatArray:
    """Lengths of fibre segments whose vertices move with the tets that hold them, (s,)."""
    mesh = character.mesh
    gradients = rest_gradients(mesh)
    centres = mesh.points[mesh.tets].mean(axis=1)
    lengths = []
    for fiber in character.fibers:
        moved = []
        for vertex in fiber.vertices:
            weights = 0.25 + np.einsum("mai,mi->ma", gradients, vertex - centres)
            tet = int(np.argmax(weights.min(axis=1)))
            moved.append(weights[tet] @ positions[mesh.tets[tet]])
        lengths += list(np.linalg.norm(np.diff(moved, axis=0), axis=1))
    return np.array(lengths)


def segment_weights(character: Character) -> FloatArray:
    """w_ij of paper eq. (6)-(7), nothing dropped, (m, s)."""
    centres = character.mesh.points[character.mesh.tets].mean(axis=1)
    columns = []
    for group in character.muscles:
        kernel = []
        for fiber in group.fibers:
            for start, end in zip(fiber.vertices[:-1], fiber.vertices[1:], strict=True):
                along = np.linspace(0.0, 1.0, 4001)[:, None]
                samples = start + along * (end - start)
                distance = np.linalg.norm(centres[:, None] - samples, axis=2).min(axis=1)
                kernel.append(np.exp(-((distance / group.kernel_width) ** 2)))
        columns.append(np.array(kernel) / np.sum(kernel, axis=0))
    return np.asarray(np.concatenate(columns).T)


def muscle_forces(
    character: Character, positions: FloatArray, tensions: FloatArray, weights: FloatArray
) -> FloatArray:
    """Forces (n, 3) of tensions (s,) Pa: each face pulled inwards, sigma times its area normal."""
    mesh = character.mesh
    R = polar_rotations(deformation_gradients(mesh, positions))
    spans = np.concatenate([np.diff(fiber.vertices, axis=0) for fiber in character.fibers])
    d = spans / np.linalg.norm(spans, axis=1, keepdims=True)
    stress = np.einsum("ms,s,si,sj->mij", weights, tensions, d, d)
    sigma = R @ stress @ R.transpose(0, 2, 1)
    forces = np.zeros_like(positions)
    for face in ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)):
        nodes = mesh.tets[:, face]
        a, b, c = positions[nodes].transpose(1, 0, 2)
        area_normal = 0.5 * np.cross(b - a, c - a)
        pull = -np.einsum("mij,mj->mi", sigma, area_normal) / 3.0
        for corner in range(3):
            np.add.at(forces, nodes[:, corner], pull)
    return forces
