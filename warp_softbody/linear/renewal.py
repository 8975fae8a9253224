"""Whether a solve begins with a new factor: decided on the host, done within one captured graph."""

from __future__ import annotations

import numpy as np
import warp as wp

from warp_softbody.device.host_view import HostView
from warp_softbody.linear.block_ldlt import Freedom
from warp_softbody.linear.preconditioner import Preconditioner
from warp_softbody.linear.system import LinearSystem


class Renewal:
    """The choice whether what a preconditioner keeps is renewed, and a launch that asks for it.

    Attributes:
        due: whether the next replay renews, or the last one did.
    """

    def __init__(self, preconditioner: Preconditioner, system: LinearSystem) -> None:
        """Of a preconditioner; not due yet."""
        self._preconditioner = preconditioner
        self._flag = system.zeros(1, wp.int32)
        self._view = HostView(self._flag)
        self.due = False

    def choose(self) -> None:
        """Take what the preconditioner says of itself."""
        stale = self._preconditioner.stale
        if stale != self.due:
            self._view.write(np.array([stale], dtype=np.int32))
        self.due = stale

    def launch(self, freedom: Freedom) -> None:
        """Launch the renewal, which takes place in replays that it is due in."""
        if self._preconditioner.renewable:
            wp.capture_if(self._flag, lambda: self._preconditioner.renew(freedom))

    def done(self) -> None:
        """Note that a replay is over."""
        if self.due:
            self._preconditioner.renewed()
