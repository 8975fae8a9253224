"""Short runs of a coarse cantilever, for tests of sweeps and of the processes that make them."""

from __future__ import annotations

from warp_softbody.accuracy.cases.settings import Settings
from warp_softbody.accuracy.runs.job import Job

MESHES = (1, 2, 3)
STEPS = (1.0 / 30.0, 1.0 / 60.0)


def jobs() -> list[Job]:
    """Six runs; one process or another makes the same ones."""
    return [
        Job(
            scene="cantilever",
            seconds=0.2,
            functionals=("tip_fall",),
            settings=Settings(time_step=step, cells=cells),
        )
        for cells in MESHES
        for step in STEPS
    ]
