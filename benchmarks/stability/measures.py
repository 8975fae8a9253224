"""What the stability suite measures of a state, by formulas of its own in double precision."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warp_softbody import Character
from warp_softbody.accuracy.runs.peers.corotation import rest_gradients
from warp_softbody.arrays import FloatArray
from warp_softbody.body.mesh_geometry import lumped_masses

ROUNDINGS = 4
"""Roundings between a node's position and a tet's strain: position, edge, gradient, rotation."""


@dataclass(frozen=True, kw_only=True)
class StateSample:
    """What is conserved or lost, of one state, and by how much one step may seem to add to it.

    Attributes:
        kinetic, elastic, weight: energies, J; the last is -sum m g . x.
        spin: angular momentum (3,) about the centre of mass, kg m^2/s.
        energy_allowance, spin_allowance: what the linear solve's residual and rounding can add.
    """

    kinetic: float
    elastic: float
    weight: float
    spin: FloatArray
    energy_allowance: float
    spin_allowance: float

    @property
    def energy(self) -> float:
        """All of it, J."""
        return self.kinetic + self.elastic + self.weight


@dataclass(frozen=True, kw_only=True)
class Accuracy:
    """Of a step.

    Attributes:
        time_step: s.
        tolerance: relative residual of the linear solve.
        epsilon: rounding unit of the state.
    """

    time_step: float
    tolerance: float
    epsilon: float


class StateProbe:
    """Measures of the states of one body."""

    def __init__(
        self, character: Character, gravity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    ) -> None:
        """Rest gradients and masses."""
        mesh, material = character.mesh, character.material
        self._gradients = rest_gradients(mesh)
        self._mesh, self._gravity = mesh, np.array(gravity)
        self._free = np.setdiff1d(np.arange(len(mesh.points)), character.fixed)
        self._mu, self._lambda = material.lame_mu, material.lame_lambda
        nodes = len(mesh.points)
        self.masses = lumped_masses(mesh.tets, mesh.volumes, nodes, material.density)

    def volumes(self, positions: FloatArray) -> FloatArray:
        """Signed volume of each tet over its rest volume, (m,)."""
        corners = positions[self._mesh.tets]
        return np.asarray(
            np.linalg.det(corners[:, 1:] - corners[:, :1]) / (6.0 * self._mesh.volumes)
        )

    def volume(self, positions: FloatArray) -> float:
        """Signed volume of the body over its rest volume."""
        return float(self._mesh.volumes @ self.volumes(positions) / self._mesh.volume)

    def shape_error(self, positions: FloatArray) -> float:
        """Largest distance of a node from the rest shape, best turned and moved, over its length.

        The turn is that of least squares (Kabsch).
        """
        rest = self._mesh.points - self._mesh.points.mean(axis=0)
        now = positions - positions.mean(axis=0)
        U, _, Vt = np.linalg.svd(now.T @ rest)
        turn = U @ np.diag([1.0, 1.0, np.linalg.det(U @ Vt)]) @ Vt
        length = np.ptp(self._mesh.points, axis=0).max()
        return float(np.linalg.norm(now - rest @ turn.T, axis=1).max() / length)

    def sample(
        self, positions: FloatArray, velocities: FloatArray, accuracy: Accuracy
    ) -> StateSample:
        """Energies and spin, and the allowances of one step.

        A residual r of the step's equation, ``|r| <= tolerance |M v + dt f|`` over the free nodes,
        does the work r . v and has the moment x x r about the centre of mass. Rounding shifts a
        node by up to d = ROUNDINGS epsilon max |x|; with E_d a bound of the elastic energy of such
        shifts, a shift changes an elastic energy E by at most ``2 sqrt(E E_d) + E_d`` (Cauchy and
        Schwarz in the norm of K), and the forces of such shifts, times dt, have moments too.
        """
        elastic, forces = self._elasticity(positions)
        momenta = self.masses[:, None] * velocities
        weights = np.outer(self.masses, self._gravity)
        arms = positions - self.masses @ positions / self.masses.sum()
        shift = ROUNDINGS * accuracy.epsilon * float(np.abs(positions).max())
        noise = self._shift_energy(shift)
        right = momenta + accuracy.time_step * (forces + weights)
        residual = accuracy.tolerance * float(np.linalg.norm(right[self._free]))
        kinetic = float(0.5 * (momenta * velocities).sum())
        rounding = 2.0 * np.sqrt(elastic * noise) + noise + shift * np.abs(weights).sum()
        impulses = accuracy.time_step * self._shift_force(shift)
        return StateSample(
            kinetic=kinetic,
            elastic=elastic,
            weight=-float((weights * positions).sum()),
            spin=np.asarray(np.cross(arms, momenta).sum(axis=0)),
            energy_allowance=float(
                residual * np.linalg.norm(velocities) + rounding + 2.0 * accuracy.epsilon * kinetic
            ),
            spin_allowance=float(
                np.linalg.norm(arms) * (residual + impulses) + shift * np.abs(momenta).sum()
            ),
        )

    def _shift_energy(self, shift: float) -> float:
        strain = shift * np.linalg.norm(self._gradients, axis=2).sum(axis=1)
        stiffness = self._mu + 1.5 * self._lambda
        return float(stiffness * (self._mesh.volumes @ strain**2))

    def _shift_force(self, shift: float) -> float:
        """Largest norm of the forces that shifts of all nodes cause, taking tets one by one."""
        gradients = np.linalg.norm(self._gradients, axis=2).sum(axis=1)
        stress = (2.0 * self._mu + 3.0 * self._lambda) * shift * gradients
        return float(np.sqrt(((self._mesh.volumes * stress * gradients) ** 2).sum()))

    def _elasticity(self, positions: FloatArray) -> tuple[float, FloatArray]:
        """``sum V0 (mu |F - R|^2 + lambda / 2 tr(R^T F - I)^2)`` and its forces (n, 3)."""
        tets, volumes = self._mesh.tets, self._mesh.volumes
        F = np.einsum("mai,maj->mij", positions[tets], self._gradients)
        U, stretches, Vt = np.linalg.svd(F)
        sign = np.sign(np.linalg.det(U) * np.linalg.det(Vt))
        U[:, :, 2] *= sign[:, None]
        stretches[:, 2] *= sign
        R, trace = U @ Vt, stretches.sum(axis=1) - 3.0
        squares = ((stretches - 1.0) ** 2).sum(axis=1)
        energy = float(volumes @ (self._mu * squares + 0.5 * self._lambda * trace**2))
        stress = 2.0 * self._mu * (F - R) + (self._lambda * trace)[:, None, None] * R
        pulls = -np.einsum("m,mij,maj->mai", volumes, stress, self._gradients)
        forces = np.stack(
            [np.bincount(tets.ravel(), pulls[:, :, axis].ravel()) for axis in range(3)], axis=1
        )
        return energy, np.asarray(forces, np.float64)
