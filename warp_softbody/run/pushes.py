"""Pushes, force fields and forces applied beside them, as forces on a scene's nodes."""

from __future__ import annotations

import numpy as np

from warp_softbody.device.host_view import HostViews
from warp_softbody.engine.model import Model
from warp_softbody.engine.state import Control, State
from warp_softbody.run.applied_forces import AppliedForce
from warp_softbody.run.field_forces import FieldForces


class Pushes:
    """Writes the forces that act in a step: of the scene's pushes and fields, and those beside.

    Attributes:
        applied: beside the pushes; those that are zero do not act.
        acting: whether any force acted in the last step.
    """

    def __init__(self, model: Model) -> None:
        """Of the scene of a model; none acts yet."""
        self._model = model
        pushes = model.scene.pushes
        self._spans = [(push, push.start, push.start + push.duration) for push in pushes]
        self._pushed = bool(pushes or model.scene.fields)
        self._fields = FieldForces(model)
        self.applied: list[AppliedForce] = []
        self._views = HostViews()
        self.acting = False

    def apply(self, control: Control, state: State, time: float) -> bool:
        """Set the forces, averaged over the step that begins at a time, s; whether there are any.

        `Control.external_forces` is left alone while nothing pushes, so that a user may set it.
        """
        if not (self._pushed or self.applied or self.acting):
            return False
        scene, dt = self._model.scene, self._model.options.time_step
        soon = time + dt
        near = [push for push, begin, end in self._spans if begin < soon and end > time]
        acting = [(push, share) for push in near if (share := push.share(time, soon)) > 0.0]
        applied = [force for force in self.applied if force.acts]
        fields = self._fields.acting(time)
        if not (acting or applied or fields or self.acting):
            return False
        forces = np.zeros((self._model.node_count, 3))
        for push, share in acting:
            nodes = scene.whole.region(push.region)
            masses = self._model.masses[nodes]
            forces[nodes] += np.outer(masses / masses.sum(), push.force) * share
        for force in applied:
            force.add_to(forces)
        self._fields.add_to(forces, state, fields)
        self._views.write(control.external_forces, forces)
        self.acting = bool(acting or applied or fields)
        return self.acting
