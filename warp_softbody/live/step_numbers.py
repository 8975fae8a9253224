"""Numbers of the steps since a page was last shown something."""

from __future__ import annotations

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.run.step_record import StepRecord

PARTS = ("control", "assembly", "solve", "contact")
NUMBERS = (*(f"ms.{part}" for part in PARTS), "qps")
"""Milliseconds of each part of a step, and QPs of a step."""


class StepNumbers:
    """Means over steps; an observer of a simulation."""

    def __init__(self) -> None:
        """No step yet."""
        self._rows: list[list[float]] = []
        self._last = np.zeros(len(NUMBERS))

    def note(self, record: StepRecord) -> None:
        """Add a step."""
        qps = 0 if record.decision is None else record.decision.result.qp_count
        spent = [1e3 * record.seconds.get(part, 0.0) for part in PARTS]
        self._rows.append([*spent, float(qps)])

    def clear(self) -> None:
        """Forget all steps."""
        self._rows, self._last = [], np.zeros(len(NUMBERS))

    def mean(self) -> FloatArray:
        """(5,) means over the steps since the last call, by `NUMBERS`; as before without any."""
        if self._rows:
            self._last = np.mean(self._rows, axis=0)
            self._rows = []
        return self._last
