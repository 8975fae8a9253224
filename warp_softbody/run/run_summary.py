"""One run in numbers, as it is told and written down."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from warp_softbody.controllers.motions.motion_span import MotionSpan
from warp_softbody.run.plan_log import PlanMisses
from warp_softbody.run.run_account import Findings

PARTS = ("assembly", "solve", "contact", "control", "export")
"""Of a step, in the order in which they are told."""

WHOLE = "whole"
"""The part of steps whose parts are not timed apart."""


@dataclass(frozen=True, kw_only=True)
class Spread:
    """Typical and large values of a series."""

    median: float
    p95: float

    @staticmethod
    def of(values: list[float]) -> Spread:
        """Median and 95th percentile; zeros for an empty series."""
        if not values:
            return Spread(median=0.0, p95=0.0)
        return Spread(median=float(np.median(values)), p95=float(np.percentile(values, 95)))


@dataclass(frozen=True, kw_only=True)
class MeanSpread:
    """Mean and large values of a series of counts."""

    mean: float
    p95: float

    @staticmethod
    def of(values: list[int]) -> MeanSpread:
        """Mean and 95th percentile; zeros for an empty series."""
        if not values:
            return MeanSpread(mean=0.0, p95=0.0)
        return MeanSpread(mean=float(np.mean(values)), p95=float(np.percentile(values, 95)))


@dataclass(frozen=True, kw_only=True)
class RunSummary:
    """One run in numbers.

    Attributes:
        scene: its name.
        frames: written or handed out.
        simulated_seconds: s.
        wall_seconds: s, from the first step to the end.
        export_seconds: s, of the wall time, writing and drawing.
        setup_seconds: s, building the model and compiling or loading kernels.
        time_step: s, as used.
        step_ms: spread by part, and "all"; "assembly" is rotations, forces and matrix, "solve" the
            linear solve with last step's contact modes, "contact" what finding the modes took
            beyond it, "control" the reduced dynamics and the QPCC, "export" writing and drawing,
            shared by the steps of a frame; of steps that are not timed part by part "whole" is all
            of the engine.
        tets, nodes, segments, patches: sizes.
        qps_per_step, cg_iterations, contact_passes: counts per step.
        residuals: median and 95th percentile of what the linear solves were asked for, of their
            right-hand sides.
        renewals: how often the preconditioner was factorised anew.
        unkicked_steps: controlled steps in which the search for other contact modes was left out.
        left_out: what the scene has none of, so that nothing is spent on it, out of "muscles",
            "contact" and "control".
        unconverged_steps: steps in which a linear solve or the contact modes did not settle.
        slept_steps: left out because all was at rest.
        newton_halvings: of Newton steps, in all time steps together.
        stalled_steps: steps in which no halving helped, so that Newton's method stopped short.
        signorini, coulomb: largest violation of a contact law by a node in any step, N, as in
            `StepStatistics`.
        precision: as used, "float32" or "float64".
        findings: momentum, energy and shape, and doubts in plain sentences.
        status: "complete"; "doubtful" where the findings hold a doubt; "stopped" while frames of a
            run were not asked for; "interrupted" by the user; "failed" where a step raised, as
            where a controller did; or "not finite".
        stage: path of the stage, or None.
        motions: of a `Sequence` of the first controlled body, those that have begun.
        plans: how far steps end from those of the first controlled body; None where no step was
            compared.
    """

    scene: str
    frames: int
    simulated_seconds: float
    wall_seconds: float
    export_seconds: float
    setup_seconds: float
    time_step: float
    step_ms: dict[str, Spread]
    tets: int
    nodes: int
    segments: int
    patches: int
    qps_per_step: MeanSpread
    cg_iterations: MeanSpread
    contact_passes: MeanSpread
    residuals: Spread
    renewals: int
    unkicked_steps: int
    left_out: tuple[str, ...]
    unconverged_steps: int
    slept_steps: int
    newton_halvings: int
    stalled_steps: int
    signorini: float
    coulomb: float
    precision: str
    findings: Findings
    status: str
    stage: str | None = None
    motions: tuple[MotionSpan, ...] = ()
    plans: PlanMisses | None = None

    @property
    def real_time_factor(self) -> float:
        """Simulated seconds per wall second; 1 and above is real time."""
        return self.simulated_seconds / self.wall_seconds if self.wall_seconds > 0.0 else 0.0

    def lines(self) -> list[tuple[str, str]]:
        """What a reader wants to know first, as pairs of a short name and a text."""
        whole, part = self.step_ms["all"], self.step_ms
        names = (*PARTS, WHOLE) if WHOLE in part else PARTS
        steps = round(self.simulated_seconds / self.time_step)
        rest = [("at rest", f"{self.slept_steps} of {steps} steps left out")]
        halved = [("newton", self._halved(steps))]
        files = f", {self.export_seconds:.1f} s of it for files" if self.export_seconds else ""
        return [
            (
                "real time",
                f"{self.real_time_factor:.2f} simulated s per wall s: {self.wall_seconds:.1f} s"
                f"{files}, after {self.setup_seconds:.1f} s of setup",
            ),
            (
                "step",
                f"{whole.median:.2f} ms median, {whole.p95:.2f} ms p95, "
                f"for {1e3 * self.time_step:.4g} ms of motion",
            ),
            ("parts", ", ".join(f"{p} {part[p].median:.2f}" for p in names) + " ms (medians)"),
            (
                "body",
                f"{self.tets} tets, {self.nodes} nodes, {self.segments} muscle segments, "
                f"{self.patches} patches",
            ),
            (
                "solves",
                f"{self.qps_per_step.mean:.1f} QPs and {self.cg_iterations.mean:.1f} "
                "conjugate gradient iterations a step (means), to a residual of "
                f"{self.residuals.median:.1g} (median)",
            ),
            ("saved", self._saved(steps)),
            (
                "contact",
                f"{self.contact_passes.mean:.1f} passes a step (mean), off Signorini's law by at "
                f"most {self.signorini:.2g} N, off Coulomb's by {self.coulomb:.2g} N",
            ),
            ("quality", self._quality()),
            *([("plans", str(self.plans))] if self.plans is not None else []),
            *([("motions", ", ".join(map(str, self.motions)))] if self.motions else []),
            *(halved if self.newton_halvings else []),
            *(rest if self.slept_steps else []),
            *(("in doubt", doubt) for doubt in self.findings.doubts),
        ]

    def _quality(self) -> str:
        """What the run can be believed to."""
        f = self.findings
        least, largest = (100.0 * (volume - 1.0) for volume in f.volumes)
        parts = [
            self.precision,
            f"momentum to {f.momentum_error:.1g}",
            f"volume {least:+.1f} to {largest:+.1f} %",
            f"{f.depth:.2g} m below the ground at the end" if f.depth > 0.0 else "",
            f"up to {f.most_inverted} tets inside out" if f.most_inverted else "",
        ]
        return ", ".join(part for part in parts if part)

    def _halved(self, steps: int) -> str:
        """What kept Newton's method from diverging."""
        stalled = f", which did not help in {self.stalled_steps} of {steps} steps"
        times = "once" if self.newton_halvings == 1 else f"{self.newton_halvings} times"
        return f"step halved {times}" + (stalled if self.stalled_steps else "")

    def _saved(self, steps: int) -> str:
        """What the scene has no need of."""
        kept = f"preconditioner kept in {steps - self.slept_steps - self.renewals} of {steps} steps"
        calm = [f"no kicks in {self.unkicked_steps}"] if self.unkicked_steps else []
        return ", ".join([*(f"no {part}" for part in self.left_out), kept, *calm])

    def __str__(self) -> str:
        """A few aligned lines."""
        return text_table(self.headline, self.lines())

    @property
    def headline(self) -> str:
        """What was run, how far, and how it ended."""
        frames = f"{self.frames} frames" if self.frames != 1 else "1 frame"
        return f"{self.scene}: {self.simulated_seconds:.4g} s in {frames}, {self.status}"

    def to_dict(self) -> dict[str, Any]:
        """Plain values, ready for JSON."""
        return {**asdict(self), "real_time_factor": self.real_time_factor}


def text_table(headline: str, lines: list[tuple[str, str]]) -> str:
    """A headline and, below it, names and texts in two columns."""
    return "\n".join([headline, *(f"  {name:<12}{text}" for name, text in lines)])
