"""What a run cost: counts and times of its steps, and their summary."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

PARTS = ("assembly", "solve", "contact", "control", "export")


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
        setup_seconds: s, building the model and compiling or loading kernels.
        time_step: s, as used.
        step_ms: spread by part, and "all"; "assembly" is rotations, forces and matrix, "solve" the
            linear solve with last step's contact modes, "contact" what finding the modes took
            beyond it, "control" the bridge and the QPCC, "export" writing and drawing, spread over
            the steps of a frame.
        tets, nodes, segments, patches: sizes.
        qps_per_step, cg_iterations, contact_passes: counts per step.
        unconverged_steps: steps in which a linear solve or the contact modes did not settle.
        status: "complete", "interrupted" or "not finite".
        stage: path of the stage, or None.
    """

    scene: str
    frames: int
    simulated_seconds: float
    wall_seconds: float
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
    unconverged_steps: int
    status: str
    stage: str | None = None

    @property
    def real_time_factor(self) -> float:
        """Simulated seconds per wall second; 1 and above is real time."""
        return self.simulated_seconds / self.wall_seconds if self.wall_seconds > 0.0 else 0.0

    def to_dict(self) -> dict[str, Any]:
        """Plain values, ready for JSON."""
        return {**asdict(self), "real_time_factor": self.real_time_factor}


@dataclass
class StepLog:
    """Series gathered while a run goes on; times in s."""

    seconds: dict[str, list[float]] = field(default_factory=lambda: {part: [] for part in PARTS})
    iterations: list[int] = field(default_factory=list)
    passes: list[int] = field(default_factory=list)
    qps: list[int] = field(default_factory=list)
    unconverged: int = 0
    patches: int = 0

    def spread_ms(self) -> dict[str, Spread]:
        """Spread of each part and of their sum, ms per step."""
        series = {part: values for part, values in self.seconds.items() if values}
        total = np.sum([values for values in series.values()], axis=0) if series else np.zeros(0)
        spread = {
            part: Spread.of([1e3 * s for s in values]) for part, values in self.seconds.items()
        }
        return {"all": Spread.of([1e3 * float(s) for s in total]), **spread}
