"""What an environment observes of a body, in NumPy and in units of the body."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_array, csr_array

from warp_softbody.controllers.body_units import BodyUnits
from warp_softbody.controllers.motions.any_body import feet_of
from warp_softbody.engine.muscle_layout import MuscleLayout
from warp_softbody.run.simulation import Simulation
from warp_softbody.world.view import BodyView

LARGEST = 10.0
"""Size at which what is observed is cut off."""

FIXED = 16
"""Numbers that every body has: height, velocity, spin and orientation."""


class Senses:
    """Observes the character of a simulation.

    In this order: height of the centre of mass over that at rest (L); its velocity (3, sqrt(g L));
    angular momentum over mass and length (3, sqrt(g L)); orientation (9, the moments ``sum m r a``
    of the arms r now and a at rest, over their sum at rest); of each muscle its length over that at
    rest, less one; of each its contraction, 0 to 1; of each foot, or part of the base, the share of
    the weight that it bears.

    Attributes:
        count: of the numbers.
        muscles: which segments each muscle has, as in ``muscles`` of an environment.
    """

    def __init__(self, simulation: Simulation, muscles: str) -> None:
        """Observe by fibres or by segments."""
        model = simulation.model
        character = model.scene.character
        self._units = BodyUnits.of_scene(model.scene)
        self._gravity = float(np.linalg.norm(model.scene.gravity))
        segments = [fiber.segment_count for fiber in character.fibers]
        count = sum(segments)
        sizes = segments if muscles == "fibers" else [1] * count
        self.muscles = np.repeat(np.arange(len(sizes)), sizes)
        self._starts = np.concatenate([[0], np.cumsum(sizes)])[:-1].astype(np.intp)
        layout = model.muscles
        lengths = layout.rest_lengths[:count]
        self._rest = np.add.reduceat(lengths, self._starts) if count else lengths
        self._segments = count
        self._ways = _segment_ways(layout, count, model.node_count)
        points = character.mesh.points
        masses = simulation.view().masses[: len(points)]
        middle = masses @ points / masses.sum()
        arms = masses[:, None] * (points - middle)
        self._spread = float((arms * (points - middle)).sum())
        # the mass and the moments of the arms at rest, which sum up to zero
        self._moments = np.concatenate([masses[None], arms.T])
        self._masses = masses[:, None].copy()
        self._mass = float(masses.sum())
        self._height = float(middle[2])
        regions = [name for name in feet_of(character) if len(character.regions.get(name, ()))]
        self._feet = [character.region(name) for name in regions]
        self.count = FIXED + 2 * len(sizes) + len(self._feet)

    def observe(self, view: BodyView) -> npt.NDArray[np.float32]:
        """What is observed of a state, (count,)."""
        count, mass, muscles = len(self._masses), self._mass, len(self._starts)
        positions = view.positions[:count]
        moments = self._moments @ positions
        momenta = self._masses * view.velocities[:count]
        linear, middle = momenta.sum(axis=0), moments[0] / mass
        across = positions.T @ momenta - np.outer(middle, linear)
        spin = (
            across[1, 2] - across[2, 1],
            across[2, 0] - across[0, 2],
            across[0, 1] - across[1, 0],
        )
        seen = np.empty(self.count)
        seen[0] = (middle[2] - self._height) / self._units.length
        seen[1:4] = linear / (mass * self._units.speed)
        seen[4:7] = np.array(spin) / (mass * self._units.length * self._units.speed)
        seen[7:FIXED] = moments[1:].ravel() / self._spread
        if muscles:
            ways = self._ways @ view.positions
            lengths = np.sqrt(np.einsum("ij,ij->i", ways, ways))
            seen[FIXED : FIXED + muscles] = (
                np.add.reduceat(lengths, self._starts) / self._rest - 1.0
            )
            contractions = 2.0 - 2.0 * view.activations[self._starts]
            seen[FIXED + muscles : FIXED + 2 * muscles] = contractions
        borne = view.impulses[:, 2]
        weight = mass * self._gravity * view.time_step
        for place, nodes in enumerate(self._feet, start=FIXED + 2 * muscles):
            seen[place] = borne[nodes].sum() / weight if weight else 0.0
        return np.clip(seen, -LARGEST, LARGEST).astype(np.float32)


def _segment_ways(layout: MuscleLayout, count: int, nodes: int) -> csr_array:
    """Matrix (segments, nodes) that takes positions to the ways from end to end of segments."""
    corners = layout.point_nodes[layout.segment_points[:count]]
    weights = layout.point_weights[layout.segment_points[:count]] * np.array([[[-1.0], [1.0]]])
    rows = np.repeat(np.arange(count), corners.shape[1] * corners.shape[2])
    entries = (weights.ravel(), (rows, corners.ravel()))
    return csr_array(coo_array(entries, shape=(count, nodes)))
