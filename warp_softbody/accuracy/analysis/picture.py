"""Charts for people: error over cost, both logarithmic."""

from __future__ import annotations

import io
import textwrap
from importlib import import_module
from pathlib import Path
from typing import Any

from warp_softbody.accuracy.analysis.chart import Chart, Point
from warp_softbody.atomic_files import replacing
from warp_softbody.errors import OutputError
from warp_softbody.inputs.extras import require_package

REAL_TIME = 1000.0
"""ms of CPU time in a simulated second: one thread keeps up."""
COLORS = 64


def require_matplotlib() -> None:
    """Say early that pictures cannot be drawn.

    Raises:
        MissingExtraError: Matplotlib is not installed.
    """
    require_package("matplotlib", "charts", "charts")


def draw(chart: Chart, path: Path) -> Path:
    """Write the picture.

    Raises:
        MissingExtraError: Matplotlib is not installed.
        OutputError: the file cannot be written.
    """
    require_matplotlib()
    # the class itself, not pyplot, draws without a display and leaves no state behind
    figure = import_module("matplotlib.figure").Figure(figsize=(9.6, 5.4), layout="constrained")
    axes = figure.subplots()
    ticker = import_module("matplotlib.ticker")
    shown = [
        point
        for point in chart.points
        if point.error and point.solver == "ours" and point.settings != chart.reference.finest
    ]
    axes.plot(*_places(shown), ".", color="0.72", markersize=6, label="points run", zorder=2)
    frontier = [point for point in chart.frontier if point.error]
    axes.plot(*_places(frontier), "o-", color="#1f6f8b", markersize=5, label="frontier", zorder=4)
    axes.plot(
        *_places([chart.default]),
        "*",
        color="#c8452f",
        markersize=15,
        label="as shipped: " + _short(chart.default),
        zorder=5,
    )
    _peers(axes, chart)
    _label(axes, chart, frontier)
    axes.set(xscale="log", yscale="log")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(ticker.LogLocator(subs=(1.0, 2.0, 5.0), numticks=20))
        axis.set_major_formatter("{x:g}")
        axis.set_minor_formatter(ticker.NullFormatter())
    _floor(axes, chart)
    axes.axvline(REAL_TIME, color="0.35", linewidth=0.8, linestyle=":", zorder=1)
    axes.annotate(
        "real time on one thread",
        (REAL_TIME, 0.99),
        xycoords=("data", "axes fraction"),
        rotation=90,
        va="top",
        ha="right",
        fontsize=7,
        color="0.35",
    )
    axes.set_title(f"{chart.case.scene}: error over cost, {chart.case.seconds:g} s simulated")
    axes.set_xlabel("CPU time of one thread, ms per simulated second")
    axes.set_ylabel(_error_title(chart))
    axes.grid(True, which="major", color="0.9", linewidth=0.6, zorder=0)
    axes.legend(fontsize=7.5, loc="best", framealpha=0.9)
    _save(figure, path)
    return path


def _save(figure: Any, path: Path) -> None:
    """With few colours, which takes a third of the bytes."""
    drawn = io.BytesIO()
    figure.savefig(drawn, format="png", dpi=100)
    image = import_module("PIL.Image").open(drawn).convert("RGB").quantize(COLORS)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with replacing(path) as beside:
            image.save(beside, optimize=True)
    except OSError as error:
        raise OutputError(f"cannot write {str(path)!r}: {error.strerror or error}") from error


def _places(points: list[Point]) -> tuple[list[float], list[float]]:
    return [p.outcome.cost for p in points], [100.0 * (p.error or 0.0) for p in points]


def _error_title(chart: Chart) -> str:
    if chart.case.controlled:
        return "largest error of a functional, %"
    return "distance of the nodes from the reference, % of the body (RMS)"


def _short(point: Point) -> str:
    from warp_softbody.accuracy.cases.settings import shown

    return f"{point.outcome.tets} tets, dt {shown('time_step', point.settings.time_step)}"


def _peers(axes: Any, chart: Chart) -> None:
    """A line for each peer and mesh, one name for each peer."""
    markers = dict(zip(chart.case.peers, "sD^vP", strict=False))
    points = [p for p in chart.points if p.solver != "ours" and p.error]
    for name, tets in dict.fromkeys((p.solver, p.outcome.tets) for p in points):
        line = [p for p in points if (p.solver, p.outcome.tets) == (name, tets)]
        axes.plot(
            *_places(sorted(line, key=lambda p: p.outcome.cost)),
            markers[name] + "--",
            color="#b8860b",
            markersize=5,
            linewidth=0.8,
            label=f"{name}, {tets} tets",
            alpha=0.6 if tets == chart.default.outcome.tets else 1.0,
            zorder=3,
        )


def _floor(axes: Any, chart: Chart) -> None:
    floor = 100.0 * chart.reference.uncertainty
    low, high = axes.get_ylim()
    low = min(low, floor / 1.5)
    axes.axhspan(low, floor, color="0.93", zorder=0)
    axes.annotate(
        f"the reference is known to {float(f'{floor:.2g}'):g} %",
        (0.01, floor),
        xycoords=("axes fraction", "data"),
        xytext=(0, -3),
        textcoords="offset points",
        va="top",
        fontsize=7,
        color="0.35",
    )
    axes.set_ylim(low, high)


def _label(axes: Any, chart: Chart, frontier: list[Point]) -> None:
    """Number the frontier's points; beside the chart, how each differs from what is shipped."""
    lines = ["frontier, as shipped but:"]
    for number, point in enumerate(frontier, start=1):
        axes.annotate(
            str(number),
            (point.outcome.cost, 100.0 * (point.error or 0.0)),
            xytext=(4, 4),
            textcoords="offset points",
            fontsize=7,
            color="#1f4b5a",
            zorder=6,
        )
        text = point.settings.differences(chart.case.default)
        lines.append(textwrap.fill(f"{number}  {text}", 36, subsequent_indent="    "))
    axes.text(
        1.02, 1.0, "\n".join(lines), transform=axes.transAxes, va="top", fontsize=7, color="#1f4b5a"
    )
