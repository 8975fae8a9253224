"""A `BodyView` is what a controller sees: the state in NumPy before the step is taken."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray, cross_rows
from warp_softbody.inputs.records import Value
from warp_softbody.world.native_measures import BodyMeasures, Momenta
from warp_softbody.world.scene import Scene


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class BodyView(Value):
    """State of the body at the start of a step.

    Attributes:
        scene: what is simulated; its pushes are not the controller's to know.
        time: s.
        time_step: dt, s; by it what a controller sums up from step to step goes on.
        masses: (n,) kg; zero at the nodes of other bodies.
        positions: (n, 3) m.
        velocities: (n, 3) m/s.
        touching: (n,) bool, nodes that bore a contact impulse in the last step.
        activations: (s,) l_d / l_0 of the last step; l / l_0 where a segment was slack.
        impulses: (n, 3) N s, of the ground on each node in the last step; (0, 3) where they are
            not known.
        steps_ahead: time steps that a plan looks ahead.
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
    steps_ahead: int = 1
    workroom: dict[Any, Any] | None = field(default=None, init=False)

    @property
    def horizon(self) -> float:
        """Time, s, at whose end objectives ask for velocities; the time step, or some of them."""
        return self.steps_ahead * self.time_step

    def at_horizon(self, now: FloatArray, soon: FloatArray) -> FloatArray:
        """What numbers are at the horizon, if they go on as in the step that takes them there."""
        return soon if self.steps_ahead == 1 else now + self.steps_ahead * (soon - now)

    @property
    def node_count(self) -> int:
        """Number of nodes."""
        return len(self.masses)

    def kept(self, key: object, make: Callable[[], Any]) -> Any:
        """What is the same in all views of a run: made in the first, by ``key`` ever since.

        Views without a workroom make it anew.
        """
        if self.workroom is None:
            return make()
        if key not in self.workroom:
            self.workroom[key] = make()
        return self.workroom[key]

    @cached_property
    def mass(self) -> float:
        """Total mass, kg."""
        total: float = self.kept("mass", lambda: float(self.masses.sum()))
        return total

    @cached_property
    def gravity(self) -> float:
        """Size of the scene's gravity, m/s^2."""
        return math.hypot(*self.scene.gravity)

    @property
    def weight(self) -> float:
        """Total mass times the size of gravity, N."""
        return self.mass * self.gravity

    @property
    def center_of_mass(self) -> FloatArray:
        """(3,) m."""
        return self._momenta.center_of_mass

    @property
    def linear_momentum(self) -> FloatArray:
        """L, (3,) kg m/s."""
        return self._momenta.linear_momentum

    @property
    def angular_momentum(self) -> FloatArray:
        """H about the centre of mass, (3,) kg m^2/s."""
        return self._momenta.angular_momentum

    @property
    def turning(self) -> FloatArray:
        """What takes velocities (3n,) to the angular momentum about the centre of mass, (3, 3n)."""
        return self._momenta.turning

    @property
    def _momenta(self) -> Momenta:
        """All of them, found together when the first is asked for.

        A `cached_property` holds a lock that all views share while it finds its value; native code
        that is then captured waits for threads that may wait for that lock.
        """
        known: Momenta | None = self.__dict__.get("_known_momenta")
        if known is None:
            if self.workroom is None:
                known = momenta_of(self.masses, self.positions, self.velocities)
            else:
                measures = self.kept("momenta", lambda: BodyMeasures(self.masses))
                known = measures.momenta(self.positions, self.velocities)
            self.__dict__["_known_momenta"] = known
        return known


def momenta_of(masses: FloatArray, positions: FloatArray, velocities: FloatArray) -> Momenta:
    """The momenta of nodes with masses (n,), kg; the reference of `BodyMeasures`."""
    centre = masses @ positions / masses.sum()
    arms = positions - centre
    angular = masses @ cross_rows(arms, velocities)
    x, y, z = (arms * masses[:, None]).T
    rows = np.zeros((3, len(masses), 3))
    rows[0, :, 1], rows[0, :, 2] = -z, y
    rows[1, :, 0], rows[1, :, 2] = z, -x
    rows[2, :, 0], rows[2, :, 1] = -y, x
    rows.setflags(write=False)
    return Momenta(centre, masses @ velocities, angular, rows.reshape(3, -1))
