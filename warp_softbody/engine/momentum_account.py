"""Momentum and energy accounts of a run, and the shapes of its bodies, kept on the device."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import warp as wp

from warp_softbody.arrays import FloatArray
from warp_softbody.device.launching import launch
from warp_softbody.device.turns import shares_warp
from warp_softbody.device.warp_runtime import captured
from warp_softbody.engine.model import Model
from warp_softbody.engine.state import Contacts, State
from warp_softbody.kernels.account import make_account


@dataclass(frozen=True, kw_only=True)
class Account:
    """What the steps so far did to each body.

    Attributes:
        missing: (bodies, 3) N s, changes of momentum that gravity, outer forces, damping of the
            mass and the impulses of contact do not explain; zero for a body with fixed nodes.
        exchanged: (bodies,) N s, sum of the sizes of the impulses that do.
        gained: (bodies,) J, work by which contact with the ground drove instead of braking.
        energy: (bodies,) J, largest kinetic energy.
    """

    missing: FloatArray
    exchanged: FloatArray
    gained: FloatArray
    energy: FloatArray


@dataclass(frozen=True, kw_only=True)
class Shapes:
    """How the bodies are deformed in the last state measured, and at most so far.

    Attributes:
        volumes, least, largest: (bodies,) of the rest volume.
        inverted, most_inverted: (bodies,) int, tets whose volume is not positive.
    """

    volumes: FloatArray
    least: FloatArray
    largest: FloatArray
    inverted: npt.NDArray[np.int32]
    most_inverted: npt.NDArray[np.int32]


class Accountant:
    """Keeps the account of a run; its launches are capturable."""

    def __init__(self, model: Model) -> None:
        """Open the account of a model."""
        bodies = len(model.scene.parts)
        self._model = model
        self._kernels = make_account(model.options.precision)
        self._missing = model.zeros(bodies, wp.vec3d)
        self._exchanged, self._gained, self._energy = (
            model.zeros(bodies, wp.float64) for _ in range(3)
        )
        self._bodies = bodies

    def _launch(self, kernel: Any, inputs: list[Any], outputs: list[Any]) -> None:
        device = self._model.options.device
        launch(kernel, self._bodies, inputs, outputs, device)

    def launch(
        self,
        contacts: Contacts,
        normals: Any,
        outer_impulses: Any,
        before: Any,
        change: Any,
        found: list[Any] | None = None,
    ) -> None:
        """Launch the account of a step that ends.

        Args:
            contacts: with the step's impulses.
            normals: (n,) vec3 of the ground.
            outer_impulses: (n,) vec3 N s.
            before: (n,) vec3 m/s, velocities before the step.
            change: (n,) vec3 m/s, what the step adds to them.
            found: numbers of the pairs that there are, and how many; None where there are none.
        """
        a, k = self._model.arrays, self._kernels
        sums = [self._missing, self._exchanged]
        inputs = [
            a.step.body_start,
            a.masses.mass,
            a.masses.damped_mass,
            a.masses.fixed,
            a.step.gravity,
        ]
        inputs += [a.step.factors, outer_impulses, before, change]
        self._launch(k.balance_bodies, inputs, [*sums, self._energy])
        if a.ground is not None:
            inputs = [a.step.body_start, a.ground.body_start, a.ground.nodes, a.masses.fixed]
            inputs += [contacts.modes, contacts.impulses, normals, before, change]
            self._launch(k.add_ground, inputs, [*sums, self._gained])
        if found is not None and contacts.pairs is not None:
            inputs = [a.step.body_start, a.masses.fixed, *found]
            inputs += [contacts.pairs.nodes, contacts.pairs.impulses]
            self._launch(k.add_pairs, inputs, sums)

    def read(self) -> Account:
        """The account so far."""
        return Account(
            missing=self._missing.numpy().copy(),
            exchanged=self._exchanged.numpy().copy(),
            gained=self._gained.numpy().copy(),
            energy=self._energy.numpy().copy(),
        )


class ShapeGauge:
    """Measures volumes and inverted tets of states, and keeps their extremes."""

    def __init__(self, model: Model) -> None:
        """Work arrays of a model."""
        parts = model.scene.parts
        bodies = len(parts)
        self._model = model
        self._kernel = make_account(model.options.precision).find_shapes
        self._starts = model.array([0, *(part.tets.stop for part in parts)], wp.int32)
        rest = model.body.mesh.volumes
        self._rest = np.array([rest[part.tets].sum() for part in parts])
        self._volumes = [model.array(self._rest, wp.float64) for _ in range(3)]
        self._counts = [model.zeros(bodies, wp.int32) for _ in range(2)]
        self._graphs: dict[int, tuple[Any, State]] = {}

    @shares_warp
    def measure(self, state: State) -> None:
        """Measure a state."""
        if id(state) not in self._graphs:
            graph = captured(self._model.options.device, lambda: self._launch(state))
            # the state is kept alive, so that its identity is not used again
            self._graphs[id(state)] = (graph, state)
        wp.capture_launch(self._graphs[id(state)][0])

    def _launch(self, state: State) -> None:
        model = self._model
        inputs = [self._starts, model.arrays.mesh.tets, state.positions]
        outputs = [*self._volumes, *self._counts]
        launch(self._kernel, len(self._rest), inputs, outputs, model.options.device)

    def read(self) -> Shapes:
        """The last state measured, and the extremes so far."""
        now, least, largest = (array.numpy() / self._rest for array in self._volumes)
        inverted, most = (array.numpy().copy() for array in self._counts)
        return Shapes(
            volumes=now, least=least, largest=largest, inverted=inverted, most_inverted=most
        )
