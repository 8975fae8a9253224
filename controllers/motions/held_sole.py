"""A sole that stays where it stands, as an objective.

Objectives of the whole body hardly know how its sole slides. A plan is then free to let the parts
of it slide out in one step and in in the next, whichever costs a little less, and every change
shakes the body.
"""

from __future__ import annotations

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers import objectives
from warp_softbody.controllers.body_units import BodyUnits
from warp_softbody.controllers.motions.body_measures import mean_weights
from warp_softbody.controllers.objectives import Objective
from warp_softbody.world.view import BodyView

LEAST = 1e-4
"""L, of the middle of a part from that of the sole, below which it is on neither side."""


class HeldSole:
    """The sole comes to rest along the ground, and neither widens nor shrinks."""

    def __init__(self, base: str, parts: tuple[str, ...]) -> None:
        """Of the region ``base`` and the regions that are parts of it."""
        self._base = base
        self._parts = parts
        self._rows: FloatArray | None = None

    def objectives(self, view: BodyView, rate: float, weight: float) -> tuple[Objective, ...]:
        """Decay of its velocities by ``rate`` (1/s), as an implicit step has it; in units of g dt.

        For one body and one time step: the rows are kept. None without a weight.
        """
        if weight == 0.0:
            return ()
        if self._rows is None:
            self._rows = self._made(view)
        slower = 1.0 / (1.0 + rate * view.horizon)
        sole = Objective(
            name="sole",
            rows=self._rows,
            target=slower * (self._rows @ view.velocities.ravel()),
            weight=np.full(len(self._rows), weight),
        )
        return (sole,)

    def _made(self, view: BodyView) -> FloatArray:
        """Rows (4, 3n) of the mean velocity along x and y, and of half the widening along each.

        Their squares add up to those of as many parts, but for turning and shearing.
        """
        rest = view.scene.character.mesh.points
        middle = mean_weights(view, (self._base,))
        parts = [mean_weights(view, (name,)) for name in self._parts]
        least = LEAST * BodyUnits.of(view).length
        rows = np.zeros((4, view.node_count, 3))
        for axis in (0, 1):
            rows[axis, :, axis] = middle
            for own in parts:
                beside = float((own - middle)[: len(rest)] @ rest[:, axis])
                side = np.sign(beside) if abs(beside) > least else 0.0
                rows[2 + axis, :, axis] += side * own / len(parts)
        unit = objectives.weight_of(view) / view.mass * view.horizon
        return np.asarray(rows.reshape(4, -1) * len(parts) ** 0.5 / unit)
