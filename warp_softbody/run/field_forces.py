"""Force fields of a scene as forces on its nodes, step by step."""

from __future__ import annotations

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.device.host_view import HostViews
from warp_softbody.engine.model import Model
from warp_softbody.engine.state import State
from warp_softbody.world.force_fields import ForceField
from warp_softbody.world.handles import IntArray, nodes_named


class FieldForces:
    """Adds the forces of fields, by the state at the start of each step."""

    def __init__(self, model: Model) -> None:
        """Of the scene of a model."""
        scene = model.scene
        self._time_step = model.options.time_step
        self._masses = model.masses[:, None]
        self._views = HostViews()
        everywhere = np.arange(model.node_count, dtype=np.int32)
        self._fields = tuple(
            (
                field,
                everywhere
                if field.region is None
                else nodes_named(field.region, scene.whole, scene.parts),
            )
            for field in scene.fields
        )

    def acting(self, time: float) -> list[tuple[ForceField, IntArray, float]]:
        """Fields that act in the step that begins at a time, s, their nodes and mean strengths."""
        end = time + self._time_step
        found = [(field, nodes, field.strength(time, end)) for field, nodes in self._fields]
        return [each for each in found if each[2] != 0.0]

    def add_to(
        self, forces: FloatArray, state: State, acting: list[tuple[ForceField, IntArray, float]]
    ) -> None:
        """Add the forces (n, 3) N of fields that act."""
        if not acting:
            return
        positions, velocities = (
            np.asarray(self._views.read(array), dtype=np.float64)
            for array in (state.positions, state.velocities)
        )
        for field, nodes, strength in acting:
            pull = field.accelerations(positions[nodes], velocities[nodes], self._time_step)
            forces[nodes] += strength * self._masses[nodes] * pull
