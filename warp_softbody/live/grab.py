"""A hand that has taken hold of a point of the skin, and pulls it by a damped spring."""

from __future__ import annotations

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.run.simulation import Simulation
from warp_softbody.world.scene import STANDARD_GRAVITY

REACH = 0.16
"""Radius of what the hand holds, over the body's diagonal."""
HALF_WAY = 0.5
"""Stretch of the spring, over the body's diagonal, at which it pulls as hard as the body weighs."""
MOST = 1.5
"""Largest force, in weights of the body."""
DAMPING = 0.7
"""Of the spring with the body on it, over the critical one."""


class Grab:
    """Pulls the nodes about a grabbed one; those near to it bear more of the force.

    A force is constant within a step, so stiffness and damping stay below what the held mass m can
    take in a step dt: dt^2 k / m < 1/4 and dt c / m < 1/2.

    Attributes:
        node: the grabbed one.
        force: of the last step, N.
    """

    def __init__(self, simulation: Simulation, node: int, to: tuple[float, ...]) -> None:
        """Take hold of a node and pull it to a place, m."""
        model = simulation.model
        body = int(model.scene.node_bodies[node])
        nodes = np.arange(model.node_count)[model.scene.parts[body].nodes]
        rest = np.asarray(model.body.mesh.points)
        size = float(np.linalg.norm(np.ptp(rest[nodes], axis=0)))
        far = np.linalg.norm(rest[nodes] - rest[node], axis=1) / (REACH * size)
        nodes, far = nodes[far < 1.0], far[far < 1.0]
        weights = model.masses[nodes] * (1.0 - far**2) ** 2
        self.node = node
        self._applied = simulation.apply_force(nodes, (0.0, 0.0, 0.0), weights=weights)
        own = model.masses[model.scene.parts[body].nodes].sum()
        held = float(1.0 / (self._applied.shares**2 / model.masses[nodes]).sum())
        dt = model.options.time_step
        weight = own * (np.linalg.norm(model.scene.gravity) or STANDARD_GRAVITY)
        self._stiffness = min(weight / (HALF_WAY * size), 0.25 * held / dt**2)
        # a quarter of the body swings along
        damping = 2.0 * DAMPING * float(np.sqrt(self._stiffness * own / 4.0))
        self._damping = min(damping, 0.5 * held / dt)
        self._most = MOST * weight
        self._offset = self._mean(simulation.state.positions) - self._node_place(simulation)
        self.force = np.zeros(3)
        self.to = np.array(to)

    def move(self, to: tuple[float, ...]) -> None:
        """Pull to another place, m."""
        self.to = np.array(to)

    def place(self, simulation: Simulation) -> FloatArray:
        """Where the held point is, m."""
        return np.asarray(self._mean(simulation.state.positions) - self._offset)

    def pull(self, simulation: Simulation) -> None:
        """Set the force of the next step."""
        stretch = self.to - self.place(simulation)
        speed = self._mean(simulation.state.velocities)
        force = self._stiffness * stretch - self._damping * speed
        size = float(np.linalg.norm(force))
        self.force = force * min(1.0, self._most / size) if size > 0.0 else force
        x, y, z = self.force.tolist()
        self._applied.force = (x, y, z)

    def release(self) -> None:
        """Let go."""
        self._applied.remove()

    def _mean(self, vectors: object) -> FloatArray:
        held = vectors.numpy()[self._applied.nodes]  # type: ignore[attr-defined]
        return np.asarray(self._applied.shares @ held.astype(np.float64))

    def _node_place(self, simulation: Simulation) -> FloatArray:
        return np.asarray(simulation.state.positions.numpy()[self.node], dtype=np.float64)
