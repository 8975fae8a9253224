"""A `BodyView` is what a controller sees: the state in NumPy before the step is taken."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray, cross_rows
from warp_softbody.inputs.records import Value
from warp_softbody.world.scene import Scene


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class BodyView(Value):
    """State of the body at the start of a step.

    Attributes:
        scene: what is simulated; its pushes are not the controller's to know.
        time: s.
        time_step: dt, s.
        masses: (n,) kg; zero at the nodes of other bodies.
        positions: (n, 3) m.
        velocities: (n, 3) m/s.
        touching: (n,) bool, nodes that bore a contact impulse in the last step.
        activations: (s,) l_d / l_0 of the last step; l / l_0 where a segment was slack.
        impulses: (n, 3) N s, of the ground on each node in the last step; (0, 3) where they are
            not known.
        workroom: what native code keeps by name for the views of one run; None where controllers
            are to reckon in NumPy. It is no part of the state: copies and pickles have none.
    """

    scene: Scene
    time: float
    time_step: float
    masses: FloatArray
    positions: FloatArray
    velocities: FloatArray
    touching: npt.NDArray[np.bool_]
    activations: FloatArray
    impulses: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    workroom: dict[Any, Any] | None = field(default=None, init=False)

    @property
    def node_count(self) -> int:
        """Number of nodes."""
        return len(self.masses)

    @cached_property
    def mass(self) -> float:
        """Total mass, kg."""
        return float(self.masses.sum())

    @cached_property
    def weight(self) -> float:
        """Total mass times the size of gravity, N."""
        return self.mass * float(np.linalg.norm(self.scene.gravity))

    @cached_property
    def center_of_mass(self) -> FloatArray:
        """(3,) m."""
        return np.asarray(self.masses @ self.positions / self.mass)

    @cached_property
    def linear_momentum(self) -> FloatArray:
        """L, (3,) kg m/s."""
        return np.asarray(self.masses @ self.velocities)

    @cached_property
    def angular_momentum(self) -> FloatArray:
        """H about the centre of mass, (3,) kg m^2/s."""
        arms = self.positions - self.center_of_mass
        return np.asarray(self.masses @ cross_rows(arms, self.velocities))
