"""What a run of one point came to; small, so that it can be sent between processes and kept."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Path3 = npt.NDArray[np.float32]


@dataclass(frozen=True, kw_only=True)
class RunOutcome:
    """What a run came to.

    Attributes:
        status: "complete", or the sentence that ended it.
        cost: CPU time of the process, ms per simulated second, set-up and first steps apart; the
            least of up to `running.REPEATS` runs.
        setup: CPU time before, s.
        memory: of the arrays that the run holds, MB.
        tets, nodes: sizes.
        iterations, passes, qps: means a step.
        unconverged: share of the steps that did not settle.
        functionals: values by name.
        path: (f, k, 3) m, places of the scene's material points by frame.
    """

    status: str
    cost: float
    setup: float
    memory: float
    tets: int
    nodes: int
    iterations: float
    passes: float
    qps: float
    unconverged: float
    functionals: Mapping[str, float]
    path: Path3

    @property
    def complete(self) -> bool:
        """Whether it came to its end."""
        return self.status == "complete"


def refused(sentence: str) -> RunOutcome:
    """Of a run that never began."""
    counts = dict.fromkeys(("cost", "setup", "memory", "iterations", "passes", "qps"), 0.0)
    path = np.zeros((0, 0, 3), dtype=np.float32)
    return RunOutcome(
        status=sentence, tets=0, nodes=0, unconverged=0.0, functionals={}, path=path, **counts
    )
