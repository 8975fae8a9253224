"""What accuracy is measured with: observed orders, energies, and matrices and modes of SciPy's."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_array, csc_array, diags_array
from scipy.sparse.linalg import eigsh

from tests.support.bodies import Rig
from tests.verification import reference
from warp_softbody.arrays import FloatArray
from warp_softbody.body.material import Material
from warp_softbody.body.mesh import TetMesh
from warp_softbody.engine.options import Tangent


def orders(errors: npt.ArrayLike) -> FloatArray:
    """Observed orders of errors at sizes halved from one to the next, by column."""
    values = np.asarray(errors, dtype=float)
    return np.asarray(np.log2(values[:-1] / values[1:]))


def order_margin(frequency: float, duration: float, step: float) -> float:
    """How far the observed order of an implicit Euler run can be from one, at ``step`` and half it.

    A mode exp(s t), |s| = w with and without damping, becomes (1 - dt s)^-n: its error is
    dt (s^2 T / 2) (1 + r + ...) with |r| at most dt (w^2 T / 4 + 2 w / 3).
    """
    r = next_term(frequency, duration, step)
    return float(np.log2((1.0 - 0.5 * r) / (1.0 - r)))


def next_term(frequency: float, duration: float, step: float) -> float:
    """The r of ``order_margin``."""
    return step * (0.25 * frequency**2 * duration + 2.0 / 3.0 * frequency)


def energy(body: Rig) -> float:
    """Kinetic and elastic energy, J."""
    scene = body.model.scene
    kinetic = 0.5 * float(body.masses @ (body.velocities**2).sum(axis=1))
    mesh, material = scene.character.mesh, scene.character.material
    return kinetic + reference.elastic_energy(mesh, material, body.positions)


def damping_forces(
    mesh: TetMesh, material: Material, tangent: Tangent, x: FloatArray, v: FloatArray
) -> FloatArray:
    """``-lambda K v`` with the K of a tangent, by numerical derivatives of R^T F or P, (n, 3)."""
    F = reference.deformation_gradients(mesh, x)
    rate = reference.deformation_gradients(mesh, v).reshape(-1, 9, 1)
    R = reference.polar_rotations(F)
    if tangent == "exact":
        C = _derivative(lambda A: _stress(material, A), F)
        squares, vectors = np.linalg.eigh(0.5 * (C + C.transpose(0, 2, 1)))
        C = vectors * np.maximum(squares, 0.0)[:, None] @ vectors.transpose(0, 2, 1)
    else:
        frozen = tangent == "warped"
        T = _derivative(lambda A: _stretch(R if frozen else reference.polar_rotations(A), A), F)
        identity = np.eye(3).reshape(-1, 1)
        D = 2.0 * material.lame_mu * np.eye(9) + material.lame_lambda * identity @ identity.T
        C = T.transpose(0, 2, 1) @ D @ T
    P = material.stiffness_damping * (C @ rate).reshape(-1, 3, 3)
    by_corner = -np.einsum("m,mij,maj->mai", mesh.volumes, P, reference.rest_gradients(mesh))
    forces = np.zeros_like(x)
    np.add.at(forces, mesh.tets, by_corner)
    return forces


def _stretch(R: FloatArray, F: FloatArray) -> FloatArray:
    S = R.transpose(0, 2, 1) @ F
    return np.asarray(0.5 * (S + S.transpose(0, 2, 1)))


def _stress(material: Material, F: FloatArray) -> FloatArray:
    R = reference.polar_rotations(F)
    trace = np.einsum("mij,mij->m", R, F) - 3.0
    pressure = material.lame_lambda * trace[:, None, None]
    return np.asarray(2.0 * material.lame_mu * (F - R) + pressure * R)


def _derivative(function: Callable[[FloatArray], FloatArray], F: FloatArray) -> FloatArray:
    """Central differences by the nine entries of F, (m, 9, 9)."""
    h = 1e-5
    columns = []
    for k in range(9):
        move = np.zeros(9)
        move[k] = h
        ahead, behind = function(F + move.reshape(3, 3)), function(F - move.reshape(3, 3))
        columns.append((ahead - behind).reshape(-1, 9) / (2.0 * h))
    return np.stack(columns, axis=2)


def strain_matrices(mesh: TetMesh) -> FloatArray:
    """Engineering strain by corner displacements, Voigt order xx yy zz xy yz zx, (m, 6, 12)."""
    x, y, z = np.moveaxis(reference.rest_gradients(mesh), 2, 0)
    B = np.zeros((len(x), 6, 4, 3))
    B[:, 0, :, 0], B[:, 1, :, 1], B[:, 2, :, 2] = x, y, z
    B[:, 3, :, 0], B[:, 3, :, 1] = y, x
    B[:, 4, :, 1], B[:, 4, :, 2] = z, y
    B[:, 5, :, 2], B[:, 5, :, 0] = x, z
    return B.reshape(len(x), 6, 12)


def elasticity_matrix(material: Material) -> FloatArray:
    """Stress by engineering strain of an isotropic material, (6, 6) Pa."""
    D = np.diag([2.0 * material.lame_mu] * 3 + [material.lame_mu] * 3)
    D[:3, :3] += material.lame_lambda
    return D


def rest_stiffness(mesh: TetMesh, material: Material) -> csc_array[np.float64]:
    """K of linear elasticity at rest, sparse (3n, 3n) N/m."""
    B = strain_matrices(mesh)
    blocks = mesh.volumes[:, None, None] * (B.transpose(0, 2, 1) @ elasticity_matrix(material) @ B)
    dofs = (3 * mesh.tets[:, :, None] + np.arange(3)).reshape(-1, 12)
    rows = np.repeat(dofs, 12, axis=1).ravel()
    columns = np.tile(dofs, (1, 12)).ravel()
    return csc_array(coo_array((blocks.ravel(), (rows, columns)), shape=(mesh.points.size,) * 2))


@dataclass(frozen=True)
class Modes:
    """Eigenmodes of K and the lumped M with some nodes held, by rising frequency.

    Attributes:
        frequencies: (k,) rad/s.
        shapes: (k, n, 3), of unit modal mass.
        masses: (n,) kg.
    """

    frequencies: FloatArray
    shapes: FloatArray
    masses: FloatArray

    def coordinates(self, field: FloatArray) -> FloatArray:
        """Modal coordinates (k,) of a field (n, 3)."""
        return np.asarray(np.einsum("kni,n,ni->k", self.shapes, self.masses, field))


def quarter_masses(mesh: TetMesh, material: Material) -> FloatArray:
    """A quarter of each tet's mass at each corner, (n,) kg."""
    quarter = np.repeat(0.25 * material.density * mesh.volumes, 4)
    masses = np.zeros(len(mesh.points))
    np.add.at(masses, mesh.tets.ravel(), quarter)
    return masses


def modes_of(
    mesh: TetMesh, material: Material, count: int, fixed: npt.ArrayLike = (), skip: int = 0
) -> Modes:
    """The lowest modes after ``skip`` of a body with nodes held."""
    masses = quarter_masses(mesh, material)
    free = np.ones_like(mesh.points, dtype=bool)
    free[np.asarray(fixed, dtype=int)] = False
    dofs = np.flatnonzero(free.ravel())
    K = rest_stiffness(mesh, material)[dofs][:, dofs]
    M = diags_array(np.repeat(masses, 3)[dofs]).tocsc()
    # below the spectrum, so that rigid modes leave the shifted matrix regular
    shift = -1e-3 * material.young_modulus / material.density / np.ptp(mesh.points) ** 2
    # a start of its own and a sign, so that shapes are the same on every call
    start = np.random.default_rng(1).standard_normal(len(dofs))
    squares, vectors = eigsh(K, count + skip, M, sigma=shift, v0=start)
    vectors *= np.sign(vectors[np.abs(vectors).argmax(axis=0), np.arange(count + skip)])
    order = np.argsort(squares)[skip:]
    shapes = np.zeros((count, mesh.points.size))
    shapes[:, dofs] = vectors[:, order].T
    return Modes(np.sqrt(squares[order]), shapes.reshape(count, -1, 3), masses)


def highest_frequency(mesh: TetMesh, material: Material) -> float:
    """Of the free body, rad/s; holding nodes lowers it."""
    mass = np.repeat(quarter_masses(mesh, material), 3)
    K = rest_stiffness(mesh, material)
    start = np.random.default_rng(1).standard_normal(len(mass))
    largest = eigsh(K, 1, diags_array(mass).tocsc(), v0=start, return_eigenvectors=False)
    return float(np.sqrt(largest[0]))


def recurrence(samples: npt.ArrayLike) -> complex:
    """The root z, Im z >= 0, of the two-term recurrence that a damped oscillation satisfies.

    ``q_n = 2 Re(z) q_{n-1} - |z|^2 q_{n-2}``, fitted to the samples by least squares.
    """
    q = np.asarray(samples)
    pair, *_ = np.linalg.lstsq(np.column_stack([q[1:-1], q[:-2]]), q[2:], rcond=None)
    return complex(np.roots([1.0, -pair[0], -pair[1]])[0])
