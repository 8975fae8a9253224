"""Tables over time are written as CSV and drawn as PNG, without a display."""

from __future__ import annotations

import io
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from warp_softbody.atomic_files import replace_text, replacing, require_makeable
from warp_softbody.errors import InputError, OutputError
from warp_softbody.inputs import input_kinds
from warp_softbody.inputs.extras import require_package
from warp_softbody.run.plot_tables import Plot, PlotSheet, PlotTable

MOST_LINES = 12
"""Named in a legend; more are too many to tell apart."""
LEAST_SHARE = 1e-9
"""Of the largest value, shown on a logarithmic axis: what is less is nothing."""


def check_plots(folder: str | Path) -> Path:
    """The folder of plots, which is not made yet.

    Raises:
        InputError: it is no path, or a file.
        MissingExtraError: Matplotlib is not installed.
        OutputError: nothing can be written there.
    """
    target = input_kinds.path("folder of plots", folder).expanduser().absolute()
    if target.exists() and not target.is_dir():
        raise InputError(f"folder of plots {str(folder)!r} is a file")
    require_package("matplotlib", "plots", "charts")
    try:
        require_makeable(target)
    except (OSError, ValueError) as error:
        raise _unwritten(folder, error) from error
    return target


def write_plots(tables: Sequence[Plot], folder: Path) -> tuple[Path, ...]:
    """Write both files of each table.

    Raises:
        OutputError: one cannot be written.
    """
    written = []
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for table in tables:
            numbers, picture = folder / f"{table.name}.csv", folder / f"{table.name}.png"
            replace_text(numbers, as_csv(table))
            with replacing(picture) as path:
                path.write_bytes(_drawn(table))
            written += [numbers, picture]
    except OSError as error:
        raise _unwritten(folder, error) from error
    return tuple(written)


def as_csv(plot: Plot) -> str:
    """One row a step; the heading tells the unit, and nothing stands where there is no number."""
    heading, columns = ["time [s]"], []
    for table in _tables(plot):
        heading += [f"{name} [{table.unit}]" for name in table.columns]
        columns += list(table.columns.values())
    rows = np.column_stack([_tables(plot)[0].time, *columns])
    lines = [
        ",".join("" if np.isnan(value) else f"{value:.9g}" for value in row)
        for row in rows.tolist()
    ]
    return "\n".join([",".join(heading), *lines, ""])


def _tables(plot: Plot) -> tuple[PlotTable, ...]:
    return plot.tables if isinstance(plot, PlotSheet) else (plot,)


def _drawn(plot: Plot) -> bytes:
    tables = _tables(plot)
    height = 5.0 if len(tables) == 1 else 2.6 * len(tables)
    # the class itself, not pyplot, draws without a display and leaves no state behind
    figure = import_module("matplotlib.figure").Figure(figsize=(9.6, height), layout="constrained")
    rows = figure.subplots(len(tables), sharex=True, squeeze=False)[:, 0]
    for axes, table in zip(rows, tables, strict=True):
        axes.set_title(table.title)
        if table.picture:
            _draw_rows(figure, axes, table)
        else:
            _draw_lines(axes, table)
    rows[-1].set_xlabel("time, s")
    stream = io.BytesIO()
    # without the name and version of the program that drew it
    figure.savefig(stream, format="png", dpi=110, metadata={"Software": None})
    return stream.getvalue()


def _draw_lines(axes: Any, table: PlotTable) -> None:
    styles = import_module("matplotlib")
    colors = styles.colormaps["tab10"].colors
    for number, (name, values) in enumerate(table.columns.items()):
        shown = np.where(values > 0.0, values, np.nan) if table.logarithmic else values
        dashes = ("-", "--", ":", "-.")[number // len(colors) % 4]
        color = colors[number % len(colors)]
        if table.paired:
            # dashed above, so that the one below is seen where both agree
            dashes, color = ("-", "--")[number % 2], colors[number // 2 % len(colors)]
        marker = "." if len(values) == 1 else ""
        axes.plot(
            table.time,
            shown,
            dashes,
            color=color,
            marker=marker,
            linewidth=1.3,
            label=name,
        )
    largest = max((np.nanmax(values, initial=0.0) for values in table.columns.values()), default=0)
    if table.logarithmic and largest > 0.0:
        axes.set_yscale("log")
        axes.set_ylim(bottom=max(LEAST_SHARE * largest, axes.get_ylim()[0]))
    axes.set_ylabel("" if table.unit == "1" else table.unit)
    axes.grid(True, color="0.88", linewidth=0.8)
    axes.margins(x=0.01)
    if len(table.columns) <= MOST_LINES:
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)


def _draw_rows(figure: Any, axes: Any, table: PlotTable) -> None:
    """One row a column of the table, dark where a muscle pulls."""
    values = np.stack(list(table.columns.values()))
    step = float(np.diff(table.time).min()) if len(table.time) > 1 else 1.0
    extent = (table.time[0] - step, table.time[-1], len(values) - 0.5, -0.5)
    drawn = axes.imshow(
        values,
        aspect="auto",
        interpolation="nearest",
        extent=extent,
        cmap="viridis",
        vmin=0.5,
        vmax=1.0,
    )
    axes.set_ylabel("segment")
    figure.colorbar(drawn, ax=axes, label="l_d / l_0")


def _unwritten(folder: str | Path, error: OSError | ValueError) -> OutputError:
    cause = getattr(error, "strerror", None) or error
    return OutputError(f"plots cannot be written in {str(folder)!r}: {cause}")
