"""Momenta that the solves of a step leave over, given back to the bodies that nothing holds."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from warp_softbody.device.launching import launch
from warp_softbody.device.structs import struct_of
from warp_softbody.engine.model import Model
from warp_softbody.engine.state import Contacts, State
from warp_softbody.kernels.rigid_balance import make_rigid_balance
from warp_softbody.linear.pcg import ConjugateGradients


class RigidBalance:
    """Balances the momenta of groups of bodies that touch each other.

    Attributes:
        groups: (bodies,) int32, number of the first body of the group of each.
        carry: (2 bodies,) vec3d, momenta that rounding keeps velocities from taking.
    """

    def __init__(self, model: Model, solver: ConjugateGradients) -> None:
        """Each body a group; ``solver`` has the velocities and what holds them."""
        self._model = model
        self._solver = solver
        self._kernels = make_rigid_balance(model.options.precision)
        bodies = len(model.scene.parts)
        self.groups = model.array(np.arange(bodies, dtype=np.int32), wp.int32)
        self.carry = model.zeros(2 * bodies, wp.vec3d)
        step = model.arrays.step
        self._free_bodies = struct_of(
            self._kernels.FreeBodies,
            model.arrays.masses,
            node_start=step.body_start,
            groups=self.groups,
            gravity=step.gravity,
            step_factors=step.factors,
            # Newton's method has other arms in every iteration
            turns=int(model.options.newton_iterations == 1),
        )

    def launch(
        self,
        state: State,
        contacts: Contacts,
        found: list[Any] | None,
        outer_impulses: Any,
        change: Any,
    ) -> None:
        """Launch what gives bodies back the momenta that a solve left over.

        Args:
            state: at the start of the step.
            contacts: as the solve took them.
            found: numbers of the pairs that there are, and how many; None where there are none.
            outer_impulses: (n,) vec3 N s, of the forces from outside, without gravity.
            change: (n,) vec3 m/s, what the step adds to the velocities; mended in place.
        """
        solver, k, device = self._solver, self._kernels, self._model.options.device
        if found is not None and contacts.pairs is not None:
            inputs = [self._model.arrays.step.body_start, *found]
            inputs += [contacts.pairs.nodes, contacts.pairs.modes]
            launch(k.join_touching, 1, inputs, [self.groups], device)
        inputs = [self._free_bodies, state.positions, solver.kinds, solver.axes]
        inputs += [contacts.slip_stiffness, contacts.friction_forces]
        inputs += [outer_impulses, solver.before, state.carry]
        launch(k.balance, len(self.groups), inputs, [change, self.carry], device)
