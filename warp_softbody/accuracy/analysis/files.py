"""A chart's table and what is known of its reference, as files."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path
from typing import Any

from warp_softbody.accuracy.analysis.chart import Chart, Point
from warp_softbody.accuracy.cases.functionals import FUNCTIONALS
from warp_softbody.accuracy.cases.settings import Settings
from warp_softbody.atomic_files import replacing, require_makeable
from warp_softbody.errors import OutputError


def write_tables(chart: Chart, folder: Path) -> tuple[Path, Path]:
    """``SCENE.csv`` and ``SCENE.json``, each replaced in one step.

    Raises:
        OutputError: the folder cannot be written into.
    """
    table, note = (folder / f"{chart.case.scene}.{kind}" for kind in ("csv", "json"))
    try:
        folder.mkdir(parents=True, exist_ok=True)
        # both are written before either is replaced
        with replacing(table) as rows, replacing(note) as found:
            rows.write_text(as_csv(chart), encoding="utf-8")
            found.write_text(json.dumps(as_dict(chart), indent=1, allow_nan=False) + "\n")
    except OSError as error:
        raise OutputError(
            f"cannot write into {str(folder)!r}: {error.strerror or error}"
        ) from error
    return table, note


def require_folder(folder: Path) -> None:
    """Refuse a folder for charts before hours are spent on one.

    Raises:
        OutputError: it cannot be made or written in.
    """
    try:
        require_makeable(folder.absolute())
    except OSError as error:
        raise OutputError(
            f"cannot write into {str(folder)!r}: {error.strerror or error}"
        ) from error


def as_csv(chart: Chart) -> str:
    """One row a point, ours by cost, then the peers."""
    default = chart.case.default
    rows = [
        {**row(point), "differs": point.settings.differences(default)} for point in _ordered(chart)
    ]
    text = io.StringIO()
    writer = csv.DictWriter(text, fieldnames=list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def row(point: Point) -> dict[str, Any]:
    """A point as the table has it; errors and shares as fractions, numbers to four digits."""
    outcome = point.outcome
    numbers = {
        "cost_ms": outcome.cost,
        "setup_s": outcome.setup,
        "memory_mb": outcome.memory,
        "error": point.error,
        "time_error": point.time_error,
        "space_error": point.space_error,
        "iterations": outcome.iterations,
        "passes": outcome.passes,
        "unconverged": outcome.unconverged,
        **outcome.functionals,
    }
    return {
        "solver": point.solver,
        **cells_of(point.settings),
        "tets": outcome.tets,
        **{name: _plain(value) for name, value in numbers.items()},
        "frontier": int(point.on_frontier),
        "status": outcome.status if outcome.complete else "failed",
    }


def cells_of(settings: Settings) -> dict[str, Any]:
    """Knobs as the table has them."""
    return {knob: _plain(value) for knob, value in settings.to_dict().items()}


def _plain(value: Any) -> Any:
    if value is None:
        return ""
    return f"{value:.4g}" if isinstance(value, float) else value


def _ordered(chart: Chart) -> list[Point]:
    # a run that failed measured nothing, and would leave columns out of the first row
    return sorted(
        chart.points, key=lambda p: (not p.outcome.complete, p.solver != "ours", p.outcome.cost)
    )


def as_dict(chart: Chart) -> dict[str, Any]:
    """What the chart is of, its reference with the evidence, and the frontier."""
    case, default = chart.case, chart.default
    return {
        "scene": case.scene,
        "given": dict(case.given),
        "seconds": case.seconds,
        "version": chart.version,
        "cost": "CPU time of the process, ms per simulated second, one thread",
        "error": (
            "largest relative difference of a functional"
            if case.controlled
            else "root mean square distance of material points over all frames, by the body's size"
        ),
        "functionals": {
            name: {
                key: getattr(FUNCTIONALS[name], key) for key in ("text", "unit", "scale", "limit")
            }
            for name in case.functionals
        },
        "reference": chart.reference.to_dict(),
        "points": len(chart.points),
        "default": row(default),
        "frontier": [
            {**row(point), "differs": point.settings.differences(case.default)}
            for point in chart.frontier
        ],
    }
