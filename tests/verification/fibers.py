"""The energy of implicit muscles in NumPy, by pairs of a tet and a segment."""

from __future__ import annotations

import numpy as np

from tests.verification import reference
from warp_softbody.arrays import FloatArray
from warp_softbody.engine.model import Model


class Fibers:
    """The energy of muscles in NumPy: q pairs of a tet and a segment."""

    def __init__(self, model: Model) -> None:
        """Of all muscles of a model."""
        layout, mesh = model.muscles, model.body.mesh
        self.mesh, self.tet, self.segment = mesh, layout.pair_tet, layout.pair_segment
        self.directions = layout.directions[self.segment]
        self.strength = layout.stiffness * layout.rest_lengths
        self.volume = layout.pair_weight * mesh.volumes[self.tet]
        self.whole = np.bincount(self.segment, self.volume, model.segment_count)
        self.gradients = reference.rest_gradients(mesh)[self.tet]

    def along(self, positions: FloatArray) -> FloatArray:
        """F d of the pairs, (q, 3)."""
        F = reference.deformation_gradients(self.mesh, positions)[self.tet]
        return np.asarray(np.einsum("qij,qj->qi", F, self.directions))

    def stretches(self, positions: FloatArray) -> FloatArray:
        """Mean over the volume of a segment, (s,)."""
        size = np.linalg.norm(self.along(positions), axis=1)
        return np.bincount(self.segment, self.volume * size, len(self.whole)) / self.whole

    def tensions(self, positions: FloatArray, activations: FloatArray) -> FloatArray:
        """S max(0, f - a), (s,) Pa."""
        return self.strength * np.maximum(self.stretches(positions) - activations, 0.0)

    def energy(self, positions: FloatArray, activations: FloatArray) -> float:
        """In J."""
        tensions = self.tensions(positions, activations)
        return float((0.5 * self.whole / self.strength) @ tensions**2)

    def by_pair(self, positions: FloatArray, tensions: FloatArray) -> FloatArray:
        """Forces (n, 3) N of tensions (q,) Pa of the pairs."""
        along = self.along(positions)
        stress = (self.volume * tensions / np.linalg.norm(along, axis=1))[:, None] * along
        parts = np.einsum("qi,qaj,qj->qai", stress, self.gradients, self.directions)
        forces = np.zeros_like(positions)
        np.add.at(forces, self.mesh.tets[self.tet], -parts)
        return forces

    def forces(self, positions: FloatArray, activations: FloatArray) -> FloatArray:
        """Forces (n, 3) N of the energy."""
        return self.by_pair(positions, self.tensions(positions, activations)[self.segment])
