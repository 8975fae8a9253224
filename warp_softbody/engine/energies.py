"""Energies of the bodies in a state, in NumPy and double precision, as the elements define them."""

from __future__ import annotations

from itertools import combinations
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_array, csr_array

from warp_softbody.arrays import FloatArray
from warp_softbody.body.mesh_geometry import inverse_edges
from warp_softbody.engine.model import Model
from warp_softbody.kernels.implicit_muscles import SHORT

Indices = npt.NDArray[np.integer]


class Energies(NamedTuple):
    """Of each body, (b,) J.

    Attributes:
        kinetic: of its nodes.
        potential: of its weight, zero where the origin is.
        elastic: of its tets; viscous forces store none.
        muscles: of implicit muscles; explicit ones store none.
    """

    kinetic: FloatArray
    potential: FloatArray
    elastic: FloatArray
    muscles: FloatArray


class _Groups:
    """Averages over the tets that share an edge or a node, by volume, within each body.

    Attributes:
        volumes: (g,) m^3, as given.
        tets: (g,) one of each group, which tells its body and material.
    """

    def __init__(self, tets: Indices, volumes: FloatArray, corners: int) -> None:
        picks = list(combinations(range(4), corners))
        members = np.sort(tets[:, picks], axis=2).reshape(-1, corners)
        _, first, owner = np.unique(members, axis=0, return_index=True, return_inverse=True)
        tet = np.repeat(np.arange(len(tets)), len(picks))
        share = volumes[tet] / len(picks)
        owner = owner.reshape(-1)
        self.tets = tet[first]
        self.volumes = _sums(owner, share, len(first))
        weights = share / self.volumes[owner]
        shape = (len(first), len(tets))
        self._means = csr_array(coo_array((weights, (owner, tet)), shape=shape))

    def mean(self, values: FloatArray) -> FloatArray:
        """The average of values (m, ...) of tets."""
        flat = self._means @ values.reshape(len(values), -1)
        return np.asarray(flat).reshape(-1, *values.shape[1:])


class EnergyMeter:
    """Energies of the states of a model."""

    def __init__(self, model: Model) -> None:
        """Prepare what no state changes."""
        mesh, parts = model.body.mesh, model.scene.parts
        self._model = model
        self._tets = np.asarray(mesh.tets)
        self._inverse = inverse_edges(np.asarray(mesh.points), self._tets)
        self._volumes = np.asarray(mesh.volumes)
        self._stiff = np.asarray(model.scene.elastic_volumes)
        counts = [part.tets.stop - part.tets.start for part in parts]
        self._bodies = np.repeat(np.arange(len(parts)), counts)
        materials = [parts[body].material for body in self._bodies]
        self._mu = np.array([material.lame_mu for material in materials])
        self._lambda = np.array([material.lame_lambda for material in materials])
        self._exact = np.array([material.volume == "exact" for material in materials])
        smoothed = model.options.elements == "smoothed"
        self._edges = _Groups(self._tets, self._stiff, 2) if smoothed else None
        self._nodes = _Groups(self._tets, self._stiff, 1) if smoothed else None
        self._node_bodies = model.scene.node_bodies
        self._segment_bodies = np.repeat(
            np.arange(len(parts)), [part.segments.stop - part.segments.start for part in parts]
        )

    def measure(
        self, positions: FloatArray, velocities: FloatArray, lengths: FloatArray
    ) -> Energies:
        """Energies at positions (n, 3) m, velocities (n, 3) m/s and rest lengths l_d (s,) m."""
        masses, gravity = self._model.masses, np.asarray(self._model.scene.gravity)
        corners = positions[self._tets]
        gradients = (corners[:, 1:] - corners[:, :1]).transpose(0, 2, 1) @ self._inverse
        speeds = np.einsum("ni,ni->n", velocities, velocities)
        return Energies(
            kinetic=self._by_node(0.5 * masses * speeds),
            potential=self._by_node(-masses * (positions @ gravity)),
            elastic=self._elastic(gradients),
            muscles=self._muscles(gradients, lengths),
        )

    def _by_node(self, values: FloatArray) -> FloatArray:
        return _sums(self._node_bodies, values, len(self._model.scene.parts))

    def _elastic(self, gradients: FloatArray) -> FloatArray:
        """``V mu |F - R|^2 + V lambda / 2 s^2``, of smoothed tets over edges and over nodes."""
        if self._edges is None or self._nodes is None:
            turned = polar_rotations(gradients)
            shear = self._stiff * self._mu * ((gradients - turned) ** 2).sum(axis=(1, 2))
            swelling = self._swelling(gradients, np.linalg.det(gradients), self._exact)
            return self._by_tet(shear + 0.5 * self._stiff * self._lambda * swelling**2)
        edges, nodes = self._edges, self._nodes
        mean = edges.mean(gradients)
        gap = ((mean - polar_rotations(mean)) ** 2).sum(axis=(1, 2))
        shear = edges.volumes * self._mu[edges.tets] * gap
        volumes = nodes.mean(np.linalg.det(gradients))
        swelling = self._swelling(nodes.mean(gradients), volumes, self._exact[nodes.tets])
        swollen = 0.5 * nodes.volumes * self._lambda[nodes.tets] * swelling**2
        return self._by_tet(shear, edges.tets) + self._by_tet(swollen, nodes.tets)

    @staticmethod
    def _swelling(gradients: FloatArray, volumes: FloatArray, exact: FloatArray) -> FloatArray:
        """Relative change of volume, exact or linear in the stretch."""
        trace = np.einsum("gij,gij->g", polar_rotations(gradients), gradients) - 3.0
        return np.where(exact, volumes - 1.0, trace)

    def _by_tet(self, values: FloatArray, tets: Indices | None = None) -> FloatArray:
        bodies = self._bodies if tets is None else self._bodies[tets]
        return _sums(bodies, values, len(self._model.scene.parts))

    def _muscles(self, gradients: FloatArray, lengths: FloatArray) -> FloatArray:
        """``S V / 2 max(0, f - a)^2`` of each segment (docs/method.md section 2)."""
        layout, bodies = self._model.muscles, len(self._model.scene.parts)
        count = len(layout.rest_lengths)
        if self._model.options.muscles != "implicit" or not count:
            return np.zeros(bodies)
        along = np.einsum(
            "qij,qj->qi", gradients[layout.pair_tet], layout.directions[layout.pair_segment]
        )
        stretch = np.linalg.norm(along, axis=1)
        stretch = np.where(stretch < SHORT, 0.5 * (stretch**2 / SHORT + SHORT), stretch)
        shares = layout.pair_weight * self._volumes[layout.pair_tet]
        volumes = _sums(layout.pair_segment, shares, count)
        means = _sums(layout.pair_segment, shares * stretch, count)
        means = np.divide(means, volumes, out=np.zeros(count), where=volumes > 0.0)
        strengths = layout.stiffness * layout.rest_lengths
        pull = np.maximum(0.0, means - lengths / layout.rest_lengths)
        return _sums(self._segment_bodies, 0.5 * strengths * volumes * pull**2, bodies)


def _sums(owners: Indices, values: FloatArray, count: int) -> FloatArray:
    """(count,) sums of values by their owner."""
    return np.asarray(np.bincount(owners, values, count), dtype=np.float64)


def polar_rotations(gradients: FloatArray) -> FloatArray:
    """Closest proper rotations (m, 3, 3), with the sign of a mirrored one on its least stretch."""
    left, _, right = np.linalg.svd(gradients)
    left[:, :, 2] *= np.sign(np.linalg.det(left) * np.linalg.det(right))[:, None]
    return np.asarray(left @ right)
