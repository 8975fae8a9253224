"""A push of a character's upper third, for a fifth of a second."""

from __future__ import annotations

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.run.simulation import Simulation

SECONDS = 0.2
UPPER = 2.0 / 3.0
"""Share of the height at rest above which nodes are pushed."""


class Shove:
    """Acts on a simulation until it is over.

    Attributes:
        until: simulated time of its end, s.
    """

    def __init__(self, simulation: Simulation, force: float, angle: float) -> None:
        """Push with a force, N, at an angle, rad, about the ground's normal from its x axis."""
        self.until = simulation.time + SECONDS
        self._given = (force, angle)
        scene = simulation.model.scene
        up = np.array((0.0, 0.0, 1.0) if scene.ground is None else scene.ground.normal)
        across = level_axis(up)
        way = np.cos(angle) * across + np.sin(angle) * np.cross(up, across)
        height = np.asarray(scene.character.mesh.points) @ up
        nodes = np.flatnonzero(height >= height.min() + UPPER * np.ptp(height))
        x, y, z = (force * way).tolist()
        self._applied = simulation.apply_force(nodes, (x, y, z))

    def continued(self, simulation: Simulation) -> Shove:
        """The rest of it, on another simulation."""
        rest = Shove(simulation, *self._given)
        rest.until = self.until
        return rest

    def over(self, time: float) -> bool:
        """Whether it has ended by a simulated time, s."""
        return time >= self.until - 1e-9

    def end(self) -> None:
        """Push no more."""
        self._applied.remove()


def level_axis(up: FloatArray) -> FloatArray:
    """The unit vector across ``up`` nearest to the x axis, or to y where that is upright."""
    axis = np.array((1.0, 0.0, 0.0) if abs(up[0]) < 0.9 else (0.0, 1.0, 0.0))
    axis = axis - (axis @ up) * up
    return np.asarray(axis / np.linalg.norm(axis))
