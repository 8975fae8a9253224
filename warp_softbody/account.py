"""Momentum and energy accounts of a step, and the shape of the bodies, measured on the device."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import warp as wp

from warp_softbody.kernels.account import make_account
from warp_softbody.model import Model
from warp_softbody.state import Contacts, State

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True)
class StepAccount:
    """What a step did to each body.

    Attributes:
        missing: (bodies, 3) N s, change of momentum that gravity, outer forces, damping and the
            impulses of contact do not explain; zero for a body with fixed nodes.
        exchanged: (bodies,) N s, sum of the sizes of the impulses that explain it.
        gained: (bodies,) J, work by which contact drove instead of braking.
    """

    missing: FloatArray
    exchanged: FloatArray
    gained: FloatArray


class Accountant:
    """Keeps the account of a step; its launches are capturable."""

    def __init__(self, model: Model) -> None:
        """Work arrays of a model."""
        bodies = len(model.scene.parts)
        self._model = model
        self._kernels = make_account(model.options.precision)
        self._missing = model.zeros(bodies, wp.vec3d)
        self._exchanged = model.zeros(bodies, wp.float64)
        self._gains = model.zeros(bodies, wp.float64)
        self._bodies = bodies

    def _launch(self, kernel: Any, inputs: list[Any], outputs: list[Any]) -> None:
        device = self._model.options.device
        wp.launch(kernel, dim=self._bodies, inputs=inputs, outputs=outputs, device=device)

    def launch(
        self,
        contacts: Contacts,
        normals: Any,
        outer_impulses: Any,
        before: Any,
        change: Any,
        corners: Any = None,
    ) -> None:
        """Launch the account of a step that ends.

        Args:
            contacts: with the step's impulses.
            normals: (n,) vec3 of the ground.
            outer_impulses: (n,) vec3 N s.
            before: (n,) vec3 m/s, velocities before the step.
            change: (n,) vec3 m/s, what the step adds to them.
            corners: (c,) vec3i of the triangles of pairs; None where the scene has none.
        """
        m, a, k = self._model, self._model.arrays, self._kernels
        sums = [self._missing, self._exchanged, self._gains]
        inputs = [a["body_start"], a["mass"], a["damped_mass"], a["fixed"], a["gravity"]]
        inputs += [a["step_factors"], outer_impulses, before, change]
        self._launch(k.balance_bodies, inputs, sums)
        if m.contact_count:
            inputs = [a["body_start"], a["contact_start"], a["surface_nodes"], a["fixed"]]
            inputs += [contacts.modes, contacts.impulses, normals, before, change]
            self._launch(k.add_ground, inputs, sums)
        if corners is not None and contacts.pairs is not None:
            inputs = [a["body_start"], a["surface_nodes"], corners]
            inputs += [contacts.pairs.modes, contacts.pairs.impulses]
            self._launch(k.add_pairs, inputs, sums[:2])

    def read(self) -> StepAccount:
        """The account of the last step."""
        return StepAccount(
            self._missing.numpy().copy(), self._exchanged.numpy().copy(), self._gains.numpy().copy()
        )


@dataclass(frozen=True, kw_only=True)
class Shape:
    """How the bodies of a scene are deformed.

    Attributes:
        inverted: tets whose volume is not positive.
        volumes: (bodies,) volume of each body, of its rest volume.
    """

    inverted: int
    volumes: FloatArray


class ShapeGauge:
    """Measures volumes and inverted tets of a state."""

    def __init__(self, model: Model) -> None:
        """Work arrays of a model."""
        self._model = model
        self._kernel = make_account(model.options.precision).find_volumes
        self._volumes = model.zeros(model.tet_count, wp.float64)
        self._starts = [part.tets.start for part in model.scene.parts]
        self._rest = np.add.reduceat(model.body.mesh.volumes, self._starts)

    def measure(self, state: State) -> Shape:
        """The shape in a state."""
        model = self._model
        inputs, outputs = [model.arrays["tets"], state.positions], [self._volumes]
        device = model.options.device
        wp.launch(self._kernel, dim=model.tet_count, inputs=inputs, outputs=outputs, device=device)
        volumes = self._volumes.numpy()
        inverted = int(np.count_nonzero(volumes <= 0.0))
        return Shape(
            inverted=inverted, volumes=np.add.reduceat(volumes, self._starts) / self._rest
        )
