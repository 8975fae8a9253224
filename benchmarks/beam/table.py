"""Results of the beam benchmark, and how they are printed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.beam.rounds import Entrant
from benchmarks.tables import as_text


@dataclass(frozen=True, kw_only=True)
class BeamResult:
    """One solver at one size; the command's description says what each number means."""

    tets: int
    solver: str
    steps: int
    setup_ms: float
    step_ms: float
    step_ms_p10: float
    step_ms_p90: float
    step_ratio: float
    assembly_ms: float | None
    assembly_ns_per_tet: float | None
    solve_ms: float | None
    solve_ratio: float | None
    iterations: float | None
    unconverged_steps: int
    residual: float | None
    sag: float | None


def summarise(
    name: str, entrant: Entrant, ours: Entrant, tets: int, sag: float | None
) -> BeamResult:
    """Medians, and ratios of medians to ours."""
    reports = entrant.reports
    our_step = float(np.median(ours.step_ms))
    step = float(np.median(entrant.step_ms))
    assembly = _median(entrant.assembly_ms)
    solve = _median([report.solve_ms for report in reports if report.solve_ms is not None])
    counts = [report.iterations for report in reports if report.iterations is not None]
    return BeamResult(
        tets=tets,
        solver=name,
        steps=len(entrant.step_ms),
        setup_ms=entrant.setup_ms,
        step_ms=step,
        step_ms_p10=float(np.percentile(entrant.step_ms, 10)),
        step_ms_p90=float(np.percentile(entrant.step_ms, 90)),
        step_ratio=step / our_step,
        assembly_ms=assembly,
        assembly_ns_per_tet=None if assembly is None else 1e6 * assembly / tets,
        solve_ms=solve,
        solve_ratio=None if solve is None else solve / our_step,
        iterations=float(np.mean(counts)) if counts else None,
        unconverged_steps=sum(not report.converged for report in reports),
        residual=max(entrant.residuals, default=None),
        sag=sag,
    )


def _median(values: list[float]) -> float | None:
    return float(np.median(values)) if values else None


COLUMNS = {
    "setup ms": ("setup_ms", ".0f"),
    "step ms": ("step_ms", ".2f"),
    "p10": ("step_ms_p10", ".2f"),
    "p90": ("step_ms_p90", ".2f"),
    "ratio": ("step_ratio", ".2f"),
    "assembly ns/tet": ("assembly_ns_per_tet", ".0f"),
    "solve ms": ("solve_ms", ".2f"),
    "ratio of solve": ("solve_ratio", ".2f"),
    "iterations": ("iterations", ".1f"),
    "not converged": ("unconverged_steps", "d"),
    "residual": ("residual", ".1e"),
    "sag m": ("sag", ".5f"),
}


def table(results: list[BeamResult]) -> str:
    """Lines of a table; a dash where there is no number."""
    return as_text(
        ("tets", "solver", *COLUMNS),
        ((result.tets, result.solver, *_cells(result)) for result in results),
        left="solver",
    )


def _cells(result: BeamResult) -> list[str]:
    values = ((getattr(result, name), form) for name, form in COLUMNS.values())
    return ["-" if value is None else format(value, form) for value, form in values]
