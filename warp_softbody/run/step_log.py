"""What the steps of a run cost: counts and times, gathered while it goes on."""

from __future__ import annotations

from dataclasses import dataclass, field

from warp_softbody.controllers.control_solver import Decision
from warp_softbody.controllers.motions.motion_span import MotionSpan
from warp_softbody.engine.model import Model
from warp_softbody.engine.step_statistics import StepClock, StepStatistics
from warp_softbody.run.plan_log import PlanMisses
from warp_softbody.run.run_account import Findings
from warp_softbody.run.run_summary import PARTS, MeanSpread, RunSummary, Spread


@dataclass
class StepLog:
    """Series and sums over the steps of a run.

    Attributes:
        setup: s, building the model, and the first step, which loads kernels and captures graphs.
        wall: s, from the first step on.
        exporting: s, of the wall time, that the receiver of frames took.
        seconds: s, of each part in each step but the first, as in `RunSummary.step_ms`.
        renewals, unkicked, unconverged, stalled: steps, as in `RunSummary`.
        halvings: of Newton steps.
        patches: most in a step.
        signorini, coulomb: largest violations, N.
    """

    setup: float = 0.0
    wall: float = 0.0
    exporting: float = 0.0
    seconds: dict[str, list[float]] = field(default_factory=lambda: {part: [] for part in PARTS})
    iterations: list[int] = field(default_factory=list)
    passes: list[int] = field(default_factory=list)
    residuals: list[float] = field(default_factory=list)
    renewals: int = 0
    unkicked: int = 0
    qps: list[int] = field(default_factory=list)
    unconverged: int = 0
    halvings: int = 0
    stalled: int = 0
    patches: int = 0
    signorini: float = 0.0
    coulomb: float = 0.0

    def note(
        self,
        statistics: StepStatistics,
        decision: Decision | None,
        clock: StepClock,
        *,
        first: bool,
    ) -> None:
        """Add a step; the ``first`` one loads kernels and captures graphs."""
        self.renewals += statistics.renewed
        self.unconverged += not statistics.settled
        self.halvings += statistics.halvings
        self.stalled += statistics.stalled
        if decision is not None:
            self.qps.append(decision.result.qp_count)
            self.unconverged += not decision.converged
            self.unkicked += not decision.kicked
            self.patches = max(self.patches, len(decision.result.modes))
        if first:
            self.setup += clock.total
            return
        self.wall += clock.total
        for part, seconds in clock.seconds.items():
            self.seconds.setdefault(part, []).append(seconds)
        self.iterations.append(statistics.iterations)
        self.passes.append(statistics.passes)
        self.residuals.append(statistics.residual)
        self.signorini = max(self.signorini, statistics.signorini)
        self.coulomb = max(self.coulomb, statistics.coulomb)

    def count_export(self, seconds: float) -> None:
        """Add the wall time that the receiver of the last frame took, shared by its steps."""
        self.wall += seconds
        self.exporting += seconds
        recorded = len(self.iterations)
        missing = recorded - len(self.seconds["export"])
        self.seconds["export"] += [seconds / max(1, missing)] * missing

    def spread_ms(self) -> dict[str, Spread]:
        """Spread of each part and of their sum, ms per step."""
        # a run that is broken off within a frame has steps whose export was not counted
        series = [values for values in self.seconds.values() if values]
        total = [sum(parts) for parts in zip(*series, strict=False)]
        spread = {
            part: Spread.of([1e3 * s for s in values]) for part, values in self.seconds.items()
        }
        return {"all": Spread.of([1e3 * s for s in total]), **spread}

    def summary(
        self,
        model: Model,
        findings: Findings,
        *,
        scene: str,
        frames: int,
        simulated_seconds: float,
        slept_steps: int,
        controlled: bool,
        motions: tuple[MotionSpan, ...],
        plans: PlanMisses | None,
        status: str,
        stage: str | None,
    ) -> RunSummary:
        """The summary of a run of a model; the arguments by name are `RunSummary`'s."""
        return RunSummary(
            scene=scene,
            frames=frames,
            simulated_seconds=simulated_seconds,
            wall_seconds=self.wall,
            export_seconds=self.exporting,
            setup_seconds=self.setup,
            time_step=model.options.time_step,
            step_ms=self.spread_ms(),
            tets=model.tet_count,
            nodes=model.node_count,
            segments=model.segment_count,
            patches=self.patches,
            qps_per_step=MeanSpread.of(self.qps),
            cg_iterations=MeanSpread.of(self.iterations),
            contact_passes=MeanSpread.of(self.passes),
            residuals=Spread.of(self.residuals),
            renewals=self.renewals,
            unkicked_steps=self.unkicked,
            left_out=model.absent_parts + (() if controlled else ("control",)),
            unconverged_steps=self.unconverged,
            slept_steps=slept_steps,
            newton_halvings=self.halvings,
            stalled_steps=self.stalled,
            signorini=self.signorini,
            coulomb=self.coulomb,
            precision=model.options.precision,
            findings=findings,
            motions=motions,
            plans=plans,
            status="doubtful" if status == "complete" and findings.doubts else status,
            stage=stage,
        )
