"""What an environment observes of a body, in NumPy and in units of the body."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from warp_softbody.controllers.body_units import BodyUnits
from warp_softbody.controllers.motions.any_body import feet_of
from warp_softbody.engine.body_sums import BodySums
from warp_softbody.run.simulation import Simulation

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
        segments = [fiber.segment_count for fiber in character.fibers]
        count = sum(segments)
        sizes = segments if muscles == "fibers" else [1] * count
        self.muscles = np.repeat(np.arange(len(sizes)), sizes)
        self._starts = np.concatenate([[0], np.cumsum(sizes)])[:-1].astype(np.intp)
        points = character.mesh.points
        masses = simulation.view().masses[: len(points)]
        middle = masses @ points / masses.sum()
        arms = masses[:, None] * (points - middle)
        regions = [name for name in feet_of(character) if len(character.regions.get(name, ()))]
        feet = [character.region(name) for name in regions]
        self._sums = BodySums(model, np.column_stack([masses, arms]), self.muscles, feet)
        self._simulation, self._muscles = simulation, len(sizes)
        self.count = FIXED + 2 * len(sizes) + len(feet)
        self._rest, self._scale = np.zeros(self.count), np.zeros(self.count)
        self._mass = float(masses.sum())
        self._measure_units(simulation, self._mass, float(middle[2]))
        self._scale[7:FIXED] = 1.0 / float((arms * (points - middle)).sum())

    def _measure_units(self, simulation: Simulation, mass: float, height: float) -> None:
        """What is observed is what was summed, less what it is at rest, times a scale."""
        scene, options = simulation.model.scene, simulation.model.options
        units, muscles = BodyUnits.of_scene(scene), self._muscles
        lengths = simulation.model.muscles.rest_lengths[: len(self.muscles)]
        rest = np.add.reduceat(lengths, self._starts) if muscles else lengths
        self._rest[0], self._scale[0] = mass * height, 1.0 / (mass * units.length)
        self._scale[1:4] = 1.0 / (mass * units.speed)
        self._scale[4:7] = 1.0 / (mass * units.length * units.speed)
        self._rest[FIXED : FIXED + muscles] = rest
        self._scale[FIXED : FIXED + muscles] = 1.0 / rest
        # a contraction of one is half the length
        self._rest[FIXED + muscles : FIXED + 2 * muscles] = 1.0
        self._scale[FIXED + muscles : FIXED + 2 * muscles] = -2.0
        weight = mass * float(np.linalg.norm(scene.gravity)) * options.time_step
        self._scale[FIXED + 2 * muscles :] = 1.0 / weight if weight else 0.0

    @property
    def ahead(self) -> float:
        """Where along x the centre of mass of what was observed last is, m."""
        return float(self._sums.sums[0, 0]) / self._mass

    def observe(self) -> npt.NDArray[np.float32]:
        """What is observed of the state that the simulation is in, (count,)."""
        muscles, found, now = self._muscles, self._sums, self._simulation
        found.observe(now.state, now.contacts)
        seen = np.empty(self.count)
        seen[0] = found.sums[0, 2]
        seen[1:4], seen[4:7] = found.momentum, found.spin
        seen[7:FIXED] = found.sums[1:].ravel()
        seen[FIXED : FIXED + muscles] = found.lengths
        seen[FIXED + muscles : FIXED + 2 * muscles] = now.activations[self._starts]
        seen[FIXED + 2 * muscles :] = found.loads
        seen -= self._rest
        seen *= self._scale
        np.maximum(np.minimum(seen, LARGEST, out=seen), -LARGEST, out=seen)
        return seen.astype(np.float32)
