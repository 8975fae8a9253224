"""One run of a scene in a variation, measured from its stage."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from benchmarks.motions.criteria import examine
from benchmarks.motions.criterion import RecordedMotion
from benchmarks.robustness.outcomes import Cell, VariationOutcome
from benchmarks.robustness.turned_world import turned_back
from benchmarks.robustness.variation import Make
from warp_softbody import scenes
from warp_softbody.errors import InputError, NotFiniteError, SoftBodyError
from warp_softbody.run.simulation import Simulation
from warp_softbody.run.warp_session import warp_engine
from warp_softbody.scenes import ScenePlan
from warp_softbody.stage_exports import StageWriter, read_take
from warp_softbody.world.frame import Frame

Ends = Callable[[Frame], bool]
"""Whether a run has come to a bad end with this frame."""


def run(
    cell: Cell,
    meshes: Path,
    limit: float | None = None,
    *,
    make: Make = scenes.make,
    ends: Ends = lambda frame: False,
) -> VariationOutcome:
    """Make a run, for at most so many seconds of this machine, and measure its stage.

    The folder ``meshes`` has the meshes of the variations that need others; ``make`` makes the
    scene, and a run that ``ends`` early is broken off.
    """
    scene = cell.scene
    with tempfile.TemporaryDirectory() as folder, warp_engine("cpu", on_compile=lambda: None):
        stage = Path(folder) / "motion.usdc"
        try:
            plan = cell.variation.plan(scene, meshes, make)
            simulation = cell.variation.simulation(plan)
        except InputError as error:
            return without(cell, refused=str(error))
        end = _record(plan, simulation, stage, cell.seconds or plan.seconds, limit, ends)
        if end.late and limit is not None:
            return without(cell, limit=limit)
        if end.broken:
            return without(cell, failures=(end.broken,))
        return measured(cell, plan, stage)


def measured(cell: Cell, plan: ScenePlan, stage: Path) -> VariationOutcome:
    """What the whole stage of a run says of it."""
    scene, variation = cell.name
    take = turned_back(read_take(stage), cell.variation.turn)
    findings = examine(scene, RecordedMotion(take, plan.scene.character))
    return VariationOutcome(
        scene=scene,
        variation=variation,
        own=findings[0].criterion.text(findings[0].value),
        failures=tuple(str(finding) for finding in findings if not finding.holds),
        values={finding.criterion.name: finding.value for finding in findings},
    )


def without(
    cell: Cell,
    *,
    failures: tuple[str, ...] = (),
    refused: str = "",
    limit: float = 0.0,
) -> VariationOutcome:
    """An outcome without numbers."""
    scene, variation = cell.name
    return VariationOutcome(
        scene=scene,
        variation=variation,
        own="-",
        failures=failures,
        values={},
        refused=refused,
        limit=limit,
    )


@dataclass(frozen=True)
class _End:
    """How a run ended: broken off by what, or for want of time."""

    broken: str = ""
    late: bool = False


def _record(
    plan: ScenePlan,
    simulation: Simulation,
    stage: Path,
    seconds: float,
    limit: float | None,
    ends: Ends,
) -> _End:
    """Write the stage."""
    begun = time.monotonic()
    with StageWriter(stage, plan.scene, fps=simulation.fps) as writer:
        try:
            for frame in simulation.run(seconds):
                writer.write(frame)
                if ends(frame):
                    return _End(broken=f"falls at {frame.time:.2f} s")
                if limit is not None and time.monotonic() - begun > limit:
                    return _End(late=True)
        except (NotFiniteError, InputError) as error:
            return _End(broken=broken_off(error, simulation))
    return _End()


def broken_off(error: SoftBodyError, simulation: Simulation) -> str:
    """When an error ended a run; a plan refuses numbers before the next step does."""
    time = error.time if isinstance(error, NotFiniteError) else simulation.time
    return f"breaks off at {time:.2f} s"
