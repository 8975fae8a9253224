"""Following a moving target by a rate of momentum, the same at every time step.

A plan is not quite what the step does: patches stand for whole soles. What momentum was missing
after the last steps is learnt and asked for in addition (docs/method.md section 4).
"""

from __future__ import annotations

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.world.view import BodyView

MOST_MISSING = 0.3
"""Body weights, of the force that a plan may be thought to miss."""


def following(view: BodyView, path: FloatArray, position: float, velocity: float) -> FloatArray:
    """Rate of momentum (3,) N by which the centre of mass follows a path.

    Spring and damper act at the end of the step, as in its implicit Euler scheme, so that no gain
    is too large for a time step (Tan, Liu and Turk, Stable proportional-derivative controllers,
    2011). Speeds of the path are its differences from step to step, so that a body that is on it
    and does what is asked stays on it at any step.

    Args:
        view: the step's start.
        path: the centre of mass as wanted one step before, now and one step later, (3, 3) m.
        position: Kp, 1/s^2.
        velocity: Kd, 1/s.
    """
    dt = view.horizon
    before, soon = (path[1:] - path[:-1]) / dt
    speed = view.linear_momentum / view.mass
    behind = path[2] - view.center_of_mass - dt * speed
    pull = (soon - before) / dt + position * behind + velocity * (soon - speed)
    return np.asarray(view.mass * pull / (1.0 + velocity * dt + position * dt * dt))


class MissingRate:
    """Learns by how much the rate of momentum has fallen short of the one that was asked."""

    def __init__(self, time: float) -> None:
        """Learn within some ``time`` (s)."""
        self._time = time
        self._learnt = np.zeros(3)
        self._asked: FloatArray | None = None  # momentum, kg m/s
        self._asked_at = 0.0  # s

    def made_up(self, view: BodyView, wanted: FloatArray) -> FloatArray:
        """What to ask for (3,) N so that the wanted rate comes about; to be called once a step."""
        # what was asked of the start of this very step has not come about yet
        if self._asked is not None and view.time > self._asked_at:
            short = (self._asked - view.linear_momentum) / view.time_step
            share = view.time_step / (view.time_step + self._time)
            self._learnt += share * (short - self._learnt)
            most = MOST_MISSING * view.weight
            self._learnt = np.minimum(np.maximum(self._learnt, -most), most)
        rate = wanted + self._learnt
        self._asked = view.linear_momentum + view.time_step * rate
        self._asked_at = view.time
        return np.asarray(rate)
