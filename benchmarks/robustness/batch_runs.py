"""Runs of one variation of a scene that differ in gains and material, side by side in a batch."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

from benchmarks.robustness.outcomes import Cell, VariationOutcome
from benchmarks.robustness.runs import Ends, broken_off, measured, run, without
from benchmarks.robustness.variation import Make
from warp_softbody.errors import InputError
from warp_softbody.run.batch import Batch
from warp_softbody.run.batch_member import BatchMember
from warp_softbody.run.warp_session import warp_engine
from warp_softbody.scenes import ScenePlan
from warp_softbody.stage_exports import StageWriter


def run_together(
    cell: Cell, meshes: Path, makes: Sequence[Make], ends: Sequence[Ends]
) -> list[VariationOutcome]:
    """The outcome of each way to make the scene, which are those of `runs.run`.

    The run of one way is broken off where its own ``ends`` says so.
    """
    try:
        plans = [cell.variation.plan(cell.scene, meshes, make) for make in makes]
        batch = _batch(cell, plans)
    except InputError:
        # one of them is refused; alone each tells
        ways = zip(makes, ends, strict=True)
        return [run(cell, meshes, make=make, ends=end) for make, end in ways]
    with tempfile.TemporaryDirectory() as folder, warp_engine("cpu", on_compile=lambda: None):
        stages = [Path(folder) / f"motion{index}.usdc" for index in range(len(plans))]
        broken = _record(batch, stages, cell.seconds or plans[0].seconds, ends)
        return [
            without(cell, failures=(broken[index],))
            if index in broken
            else measured(cell, plan, stages[index])
            for index, plan in enumerate(plans)
        ]


def _batch(cell: Cell, plans: Sequence[ScenePlan]) -> Batch:
    """The plans as members of a batch; their meshes and time steps are the same."""

    def planned(member: BatchMember) -> BatchMember:
        plan = plans[member.index]
        return replace(member, scene=plan.scene, controller=plan.controller)

    options, fps = cell.variation.settings_of(plans[0])
    return Batch(plans[0].scene, len(plans), planned, options=options, fps=fps)


def _record(
    batch: Batch, stages: Sequence[Path], seconds: float, ends: Sequence[Ends]
) -> dict[int, str]:
    """Write the stages; by what the runs that did not come to their end were broken off."""
    broken: dict[int, str] = {}
    with ExitStack() as files:
        writers = [
            files.enter_context(StageWriter(stage, simulation.model.scene, fps=batch.fps))
            for stage, simulation in zip(stages, batch, strict=True)
        ]
        for frames in batch.run(seconds):
            for index, frame in enumerate(frames):
                if frame is None:
                    continue
                writers[index].write(frame)
                if ends[index](frame):
                    broken[index] = f"falls at {frame.time:.2f} s"
                    batch.leave(index)
    for index, error in batch.failures.items():
        broken[index] = broken_off(error, batch[index])
    return broken
