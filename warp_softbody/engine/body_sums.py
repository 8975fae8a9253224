"""Sums over a body that an environment observes after every action, by native code."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.device.host_program import HostProgram
from warp_softbody.device.host_view import HostViews
from warp_softbody.device.turns import shares_warp
from warp_softbody.engine.model import Model
from warp_softbody.engine.state import Contacts, State
from warp_softbody.kernels.contact.modes import Mode
from warp_softbody.kernels.senses import COUNTS, NUMBERS, make_senses

LIFT = int(Mode.LIFT)


class BodySums:
    """Sums over the nodes, fibres and feet of a scene's character.

    Attributes, of the state last observed:
        sums: (4, 3) m r, and the moments m a r with the arms a at rest; kg m and kg m^2.
        momentum: (3,) kg m/s.
        spin: (3,) angular momentum about the centre of mass, kg m^2/s.
        lengths: (muscles,) m.
        loads: (feet,) N s, impulses of the ground along z.
    """

    def __init__(
        self,
        model: Model,
        moments: FloatArray,
        muscles: npt.NDArray[np.integer],
        feet: Sequence[npt.NDArray[np.integer]],
    ) -> None:
        """Lay out the arrays.

        Args:
            model: of the scene.
            moments: (n, 4) m and m a of the character's nodes.
            muscles: (s,) which muscle each segment of the character belongs to.
            feet: nodes of each.
        """
        touching = model.body.mesh.surface_nodes if model.contact_count else np.zeros(0, np.int32)
        members = [np.flatnonzero(np.isin(touching, nodes)) for nodes in feet]
        joined = np.concatenate([np.zeros(0, np.intp), *members])
        count = int(muscles.max()) + 1 if len(muscles) else 0
        sizes = (len(moments), len(muscles), count, len(feet), len(joined), len(touching))
        program = HostProgram(
            {name: shape(*sizes) for name, shape in NUMBERS.items()},
            {name: shape(*sizes) for name, shape in COUNTS.items()},
        )
        numbers, counts = program.numbers, program.counts
        numbers["moments"][...] = moments
        corners, weights = _segment_ways(model, len(muscles))
        counts["corners"][...], numbers["weights"][...] = corners, weights
        counts["muscles"][...], counts["members"][...] = muscles, joined
        counts["starts"][...] = np.cumsum([0, *map(len, members)])
        counts["sizes"][...] = sizes[:4]
        self._numbers, self._views, self._count = numbers, HostViews(), len(moments)
        self.sums, self.momentum, self.spin = (numbers[k] for k in ("sums", "momentum", "spin"))
        self.lengths, self.loads = numbers["lengths"], numbers["loads"]
        self._run = program.running(make_senses().observe, reads=[], writes=[])

    @shares_warp
    def observe(self, state: State, contacts: Contacts) -> None:
        """Sum over a state, with the contacts of the step that led to it."""
        numbers, read, count = self._numbers, self._views.read, self._count
        numbers["positions"][...] = read(state.positions)[:count]
        numbers["velocities"][...] = read(state.velocities)[:count]
        if len(self.loads):
            pressed = read(contacts.modes) != LIFT
            np.multiply(read(contacts.impulses)[:, 2], pressed, out=numbers["borne"])
        self._run()


def _segment_ways(model: Model, count: int) -> tuple[npt.NDArray[np.integer], FloatArray]:
    """Nodes and weights (segments, 8) that take positions to ways from end to end of segments."""
    layout = model.muscles
    points = layout.segment_points[:count]
    corners = layout.point_nodes[points].reshape(count, -1)
    weights = layout.point_weights[points] * np.array([[[-1.0], [1.0]]])
    return corners, weights.reshape(count, -1)
