"""The forces with which handles moved their nodes in the last step of a run."""

from __future__ import annotations

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.engine.holding import holding_impulse
from warp_softbody.engine.state import Contacts
from warp_softbody.engine.stepper import Stepper
from warp_softbody.run.handle_motion import HandleMotion


class HandleForces:
    """Reads them from the work arrays of a step, while these are of that step.

    Steppers that share work arrays write over them: there forces are read in every step. Elsewhere
    they are when somebody asks.
    """

    def __init__(
        self, stepper: Stepper, contacts: Contacts, motion: HandleMotion, *, shared: bool
    ) -> None:
        """Of a run before its first step; ``shared`` tells whether others write to its arrays."""
        self._stepper = stepper
        self._contacts = contacts
        self._motion = motion
        self._shared = shared
        self._known: tuple[FloatArray, ...] | None = tuple(np.zeros(3) for _ in motion.holds)

    def note_step(self) -> None:
        """A step has been taken."""
        self._known = None
        if self._shared:
            self.read()

    def read(self) -> tuple[FloatArray, ...]:
        """(3,) N of each handle, mean over the last step; zero before the first one."""
        if self._known is None:
            time_step = self._stepper.model.options.time_step
            self._known = tuple(
                holding_impulse(self._stepper, self._contacts, nodes) / time_step
                if holds
                else np.zeros(3)
                for nodes, holds in zip(
                    self._stepper.model.scene.handle_nodes, self._motion.holds, strict=True
                )
            )
        return self._known

    def put(self, forces: tuple[FloatArray, ...]) -> None:
        """Take those of a step that another run took."""
        self._known = forces
