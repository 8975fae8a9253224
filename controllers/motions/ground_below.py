"""The ground's height under a body and ahead of it, for motions that are planned over it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.world.ground import Ground, Plane
from warp_softbody.world.view import BodyView

ROUNDS = 3
"""Of going down by the distance: exact at once over planes and height fields."""


@dataclass(frozen=True)
class GroundBelow:
    """A ground that is not level, as heights over x and y."""

    ground: Ground

    @classmethod
    def of(cls, view: BodyView) -> GroundBelow | None:
        """That of a scene; None where it is level or there is none, so that no plan need ask."""
        ground = view.scene.ground
        level = type(ground) is Plane and ground.normal == (0.0, 0.0, 1.0)
        return None if ground is None or level else cls(ground)

    def heights(self, places: FloatArray, start: float) -> FloatArray:
        """Heights (k,) m of the ground under places (k, 2 or more) m.

        Args:
            places: x and y; what else there is of a point is not used.
            start: m, from which it is looked for, near the ground.
        """
        points = np.column_stack([places[:, :2], np.full(len(places), start)])
        for _ in range(ROUNDS):
            distances, normals = self.ground.measure(points)
            points[:, 2] -= distances / np.maximum(normals[:, 2], 1e-3)
        return np.asarray(points[:, 2])
