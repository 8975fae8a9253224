"""Friction that hangs on where a node is: coefficients of a step from a ground's map."""

from __future__ import annotations

from typing import Any

from warp_softbody.device.launching import launch
from warp_softbody.device.structs import struct_of
from warp_softbody.engine.model import Model
from warp_softbody.engine.state import State
from warp_softbody.kernels.contact.ground_friction import make_ground_friction
from warp_softbody.world.friction_map import FrictionMap, map_of


class PlacedFriction:
    """Launches that look up the coefficient of every surface node; made to be captured.

    Attributes:
        coefficients: (c,) scalar, those of the present step.
    """

    def __init__(self, model: Model, friction_map: FrictionMap) -> None:
        """Keep the map on the device."""
        kernels = make_ground_friction(model.options.precision)
        (x, y), (dx, dy) = friction_map.origin, friction_map.spacing
        self._model = model
        self._kernel = kernels.place
        self._grid = struct_of(
            kernels.FrictionGrid,
            factors=model.array(friction_map.factors, model.types.scalar),
            origin_x=x,
            origin_y=y,
            spacing_x=dx,
            spacing_y=dy,
        )
        self.coefficients = model.zeros(model.contact_count, model.types.scalar)

    @classmethod
    def of(cls, model: Model) -> PlacedFriction | None:
        """For the ground of a model; None where its friction is the same everywhere."""
        found = map_of(model.scene.ground)
        return None if found is None else cls(model, found)

    def launch(self, state: State) -> None:
        """Launch the coefficients of a step from ``state`` on."""
        m = self._model
        assert m.arrays.ground is not None
        inputs: list[Any] = [m.arrays.mesh.surface_nodes, m.arrays.ground.friction, self._grid]
        inputs += [state.positions]
        device = m.options.device
        launch(self._kernel, m.contact_count, inputs, [self.coefficients], device)
