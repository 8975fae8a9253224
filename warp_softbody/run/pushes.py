"""Pushes of a scene as forces on its nodes, step by step."""

from __future__ import annotations

import numpy as np

from warp_softbody.engine.model import Model
from warp_softbody.engine.state import Control


class Pushes:
    """Writes the forces of the pushes that act in a step."""

    def __init__(self, model: Model) -> None:
        """Of the scene of a model; none acts yet."""
        self._model = model
        self._acting = False

    def apply(self, control: Control, time: float) -> bool:
        """Set the forces, averaged over the step that begins at a time, s; whether there are any.

        Forces are left alone while nothing pushes, so that a user may set them.
        """
        scene, dt = self._model.scene, self._model.options.time_step
        shares = [push.share(time, time + dt) for push in scene.pushes]
        if not any(shares) and not self._acting:
            return False
        forces = np.zeros((self._model.node_count, 3))
        acting = [(p, share) for p, share in zip(scene.pushes, shares, strict=True) if share > 0.0]
        for push, share in acting:
            nodes = scene.whole.region(push.region)
            masses = self._model.masses[nodes]
            forces[nodes] += np.outer(masses / masses.sum(), push.force) * share
        control.external_forces.assign(forces)
        self._acting = any(shares)
        return self._acting
