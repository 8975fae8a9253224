"""Bodies at rest are left alone until something acts on them."""

from __future__ import annotations

import math

STILL_SPEED = 2e-5
"""Speed, m/s, that nothing of a metre may exceed; rounding in single precision leaves 5e-6."""

STILL_SECONDS = 0.25
"""How long, s. A mode of period T that is this slow this long has an amplitude of at most some
``STILL_SPEED T^2 / 5``: 0.02 mm at two seconds."""


class Sleep:
    """Tells when a scene has come to rest.

    Attributes:
        asleep: whether steps may be left out.
        slept: steps left out so far.
        still: steps for which nothing has moved or acted.
    """

    def __init__(self, time_step: float, *, allowed: bool, speed_share: float = 1.0) -> None:
        """Watch a run of a time step, s, with bodies of a `Model.speed_share`, if allowed."""
        self._still_speed = STILL_SPEED * speed_share
        self._needed = max(2, math.ceil(STILL_SECONDS / time_step))
        self._allowed = allowed
        self.still = 0
        self.slept = 0

    @property
    def asleep(self) -> bool:
        """Whether all has been still for long enough."""
        return self._allowed and self.still >= self._needed

    def note(self, fastest: float, *, acted: bool) -> None:
        """Note a step's largest speed, m/s, and whether muscles or pushes acted in it."""
        self.still = self.still + 1 if fastest < self._still_speed and not acted else 0

    def skip(self) -> None:
        """Note a step left out."""
        self.slept += 1
