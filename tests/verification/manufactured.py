"""A smooth displacement of the unit cube, the body force that holds it, and errors against it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tests.verification.accuracy import elasticity_matrix, strain_matrices
from warp_softbody.arrays import FloatArray
from warp_softbody.body.material import Material
from warp_softbody.body.mesh import TetMesh

WAVE_NUMBER = 2.0
PHASES = np.array([0.3, 0.5, 0.7])


@dataclass(frozen=True)
class Manufactured:
    """``u = amplitude sin(pi x + 0.3) sin(pi y + 0.5) sin(pi z + 0.7)``, not zero on the faces."""

    material: Material
    amplitude: FloatArray

    def displacement(self, points: FloatArray) -> FloatArray:
        """(..., 3) m."""
        sines = np.sin(WAVE_NUMBER * points + PHASES)
        return np.asarray(sines.prod(axis=-1)[..., None] * self.amplitude)

    def gradient(self, points: FloatArray) -> FloatArray:
        """du_i / dx_j, (..., 3, 3)."""
        sines = np.sin(WAVE_NUMBER * points + PHASES)
        cosines = np.cos(WAVE_NUMBER * points + PHASES)
        slope = np.empty_like(points)
        for j in range(3):
            others = [k for k in range(3) if k != j]
            slope[..., j] = WAVE_NUMBER * cosines[..., j] * sines[..., others].prod(axis=-1)
        return np.asarray(self.amplitude[:, None] * slope[..., None, :])

    def body_force(self, points: FloatArray) -> FloatArray:
        """``-div sigma`` of linear elasticity, (..., 3) N/m^3."""
        sines = np.sin(WAVE_NUMBER * points + PHASES)
        cosines = np.cos(WAVE_NUMBER * points + PHASES)
        product = sines.prod(axis=-1)
        hessian = np.empty((*points.shape, 3))
        for i in range(3):
            hessian[..., i, i] = -product
            j, k = (i + 1) % 3, (i + 2) % 3
            mixed = cosines[..., i] * cosines[..., j] * sines[..., k]
            hessian[..., i, j] = hessian[..., j, i] = mixed
        hessian *= WAVE_NUMBER**2
        mu, lam = self.material.lame_mu, self.material.lame_lambda
        trace = np.trace(hessian, axis1=-2, axis2=-1)
        return np.asarray(
            -(lam + mu) * hessian @ self.amplitude - mu * trace[..., None] * self.amplitude
        )

    def loads(self, mesh: TetMesh) -> FloatArray:
        """Consistent nodal loads, the integral of N_a b, (n, 3) N."""
        shapes, weights = quadrature()
        force = self.body_force(shapes @ mesh.points[mesh.tets])
        volume = mesh.volumes[:, None, None]
        by_corner = volume * np.einsum("q,qa,mqi->mai", weights, shapes, force)
        loads = np.zeros_like(mesh.points)
        np.add.at(loads, mesh.tets, by_corner)
        return loads

    def errors(self, mesh: TetMesh, positions: FloatArray) -> FloatArray:
        """Of a finite element displacement: in L2, in energy, and the largest at a node."""
        shapes, weights = quadrature()
        found = positions - mesh.points
        points = shapes @ mesh.points[mesh.tets]
        gap = shapes @ found[mesh.tets] - self.displacement(points)
        square = mesh.volumes @ ((gap**2).sum(axis=2) @ weights)
        strain = (strain_matrices(mesh) @ found[mesh.tets].reshape(-1, 12, 1))[:, None, :, 0]
        strain = strain - engineering_strain(self.gradient(points))
        density = ((strain @ elasticity_matrix(self.material)) * strain).sum(axis=2)
        nodal = np.abs(found - self.displacement(mesh.points)).max()
        return np.array([np.sqrt(square), np.sqrt(mesh.volumes @ (density @ weights)), nodal])


def engineering_strain(gradient: FloatArray) -> FloatArray:
    """Voigt order xx yy zz xy yz zx, (..., 6)."""
    doubled = gradient + np.swapaxes(gradient, -1, -2)
    normal = 0.5 * np.diagonal(doubled, axis1=-2, axis2=-1)
    shear = np.stack([doubled[..., 0, 1], doubled[..., 1, 2], doubled[..., 2, 0]], axis=-1)
    return np.concatenate([normal, shear], axis=-1)


def quadrature() -> tuple[FloatArray, FloatArray]:
    """Barycentric points (q, 4) and weights that sum to one, exact to degree 5.

    Gauss points of a cube collapsed to a tet: four a side are exact to degree 7, of which the map's
    Jacobian takes two.
    """
    ticks, weights = np.polynomial.legendre.leggauss(4)
    r, s, t = (axis.ravel() for axis in np.meshgrid(*[0.5 * (1.0 + ticks)] * 3, indexing="ij"))
    product = np.einsum("i,j,k->ijk", weights, weights, weights).ravel() / 8.0
    corners = np.stack([r, (1.0 - r) * s, (1.0 - r) * (1.0 - s) * t], axis=1)
    barycentric = np.column_stack([1.0 - corners.sum(axis=1), corners])
    return barycentric, 6.0 * product * (1.0 - r) ** 2 * (1.0 - s)
