"""The mean shape of a body seen from the side: second moments of its mass, as objectives.

They are means over the whole body, so that they hardly know the mesh.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.body_units import BodyUnits
from warp_softbody.controllers.objectives import Objective
from warp_softbody.world.view import BodyView


class MeanShape(NamedTuple):
    """Second moments about the centre of mass in the plane of x and z, over their sum.

    A round body that is strained by e has a tilt of e_xz and a squash of e_xx - e_zz, where e is
    small.

    Attributes:
        arms: (n, 3) m, of the nodes from the centre of mass.
        inertia: kg m^2, about the axis y.
        tilt: sum m x z over the inertia; positive where the upper half leans towards +x.
        squash: sum m (x^2 - z^2) over the inertia.
    """

    arms: FloatArray
    inertia: float
    tilt: float
    squash: float

    @classmethod
    def of(cls, view: BodyView) -> MeanShape:
        """That of the body as it is."""
        arms = view.positions - view.center_of_mass
        along, up = view.masses @ arms[:, 0] ** 2, view.masses @ arms[:, 2] ** 2
        inertia = float(along + up)
        tilt = float(view.masses @ (arms[:, 0] * arms[:, 2])) / inertia
        return cls(arms, inertia, tilt, float(along - up) / inertia)

    def rows(self, view: BodyView) -> FloatArray:
        """Rates of tilt and squash as linear functions of the velocities, (2, 3n)."""
        shares = view.masses / self.inertia
        along, up = shares * self.arms[:, 0], shares * self.arms[:, 2]
        # those of the sum of both moments leave out what is of second order in tilt and squash
        rows = np.zeros((2, view.node_count, 3))
        rows[0, :, 0], rows[0, :, 2] = up, along
        rows[1, :, 0], rows[1, :, 2] = 2.0 * along, -2.0 * up
        return rows.reshape(2, -1)

    def objective(self, view: BodyView, rates: FloatArray, weight: FloatArray) -> Objective:
        """``|rate - rate*|^2`` for wanted rates (2,) 1/s of tilt and squash, over sqrt(g / L)."""
        unit = BodyUnits.of(view).time
        return Objective(
            name="mean shape", rows=unit * self.rows(view), target=unit * rates, weight=weight
        )
