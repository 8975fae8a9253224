"""What a `Recorder` holds, as the tables of one plot each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray

Array = npt.NDArray[Any]

_VECTORS = {
    "centre_of_mass": ("Centre of mass", "m"),
    "momentum": ("Momentum", "N s"),
    "angular_momentum": ("Angular momentum about the centre of mass", "N m s"),
    "contact_force": ("Contact force on the body", "N"),
}
_GROUPS = {
    "energy": ("Energy", "J"),
    "objective": ("What the step leaves of its goals", "1"),
    "milliseconds": ("Wall time of the step's parts", "ms"),
}


@dataclass(frozen=True, kw_only=True)
class PlotTable:
    """Columns over time.

    Attributes:
        name: of the files.
        title: of the plot.
        unit: of all columns.
        time: (k,) s.
        columns: (k,) each, by what they are called.
        logarithmic: whether the plot's axis is.
        paired: whether columns come in pairs, drawn in one colour, the second one dashed.
        picture: whether the rows are drawn one below the other, by colour, instead of as lines.
    """

    name: str
    title: str
    unit: str
    time: FloatArray
    columns: Mapping[str, FloatArray]
    logarithmic: bool = False
    paired: bool = False
    picture: bool = False


@dataclass(frozen=True, kw_only=True)
class PlotSheet:
    """Tables over the same times, drawn one below the other in one picture.

    Attributes:
        name: of the files.
        tables: of lines; the columns of all have different names.
    """

    name: str
    tables: tuple[PlotTable, ...]


Plot: TypeAlias = PlotTable | PlotSheet


def plot_tables(arrays: Mapping[str, Array], bodies: Sequence[str]) -> tuple[PlotTable, ...]:
    """The tables of a record; columns are named by body where there are several."""
    time = arrays["time"]
    tables = [
        PlotTable(name=name, title=title, unit=unit, time=time, columns=_axes(arrays[name], bodies))
        for name, (title, unit) in _VECTORS.items()
    ]
    modes = {mode: arrays[mode] for mode in ("sticking", "sliding")}
    tables.append(
        PlotTable(
            name="contact_modes",
            title="Contacts",
            unit="1",
            time=time,
            columns=_by_body(modes, bodies),
        )
    )
    if arrays["activations"].shape[1]:
        tables.append(
            PlotTable(
                name="activations",
                title="Activations l_d / l_0 by segment",
                unit="1",
                time=time,
                columns={str(i): one for i, one in enumerate(arrays["activations"].T)},
                picture=True,
            )
        )
    tables += _grouped(arrays, time, bodies)
    counts = ("qps", "cg_iterations", "contact_passes")
    titles = {name: np.asarray(arrays[name], dtype=float) for name in counts}
    tables.append(PlotTable(name="solver", title="Solvers", unit="1", time=time, columns=titles))
    return tuple(tables)


def _grouped(
    arrays: Mapping[str, Array], time: FloatArray, bodies: Sequence[str]
) -> list[PlotTable]:
    """Tables of the arrays that have a group's name and a slash in front."""
    tables = []
    for group, (title, unit) in _GROUPS.items():
        start = f"{group}/"
        own = {
            name.removeprefix(start): array
            for name, array in arrays.items()
            if name.startswith(start)
        }
        if group == "energy":
            own = {**own, "sum": np.sum(list(own.values()), axis=0)}
        if own:
            columns = _by_body(own, bodies)
            tables.append(
                PlotTable(
                    name=group,
                    title=title,
                    unit=unit,
                    time=time,
                    columns=columns,
                    logarithmic=group != "energy",
                )
            )
    return tables


def _axes(vectors: Array, bodies: Sequence[str]) -> dict[str, FloatArray]:
    axes = {axis: vectors[:, :, i] for i, axis in enumerate("xyz")}
    return _by_body(axes, bodies)


def _by_body(arrays: Mapping[str, Array], bodies: Sequence[str]) -> dict[str, FloatArray]:
    """One column for each body of arrays (k, b); arrays (k,) as they are."""
    columns: dict[str, FloatArray] = {}
    for name, array in arrays.items():
        if array.ndim == 1:
            columns[name] = np.asarray(array, dtype=float)
            continue
        for body, values in zip(bodies, array.T, strict=True):
            label = name if len(bodies) == 1 else f"{body} {name}"
            columns[label] = np.asarray(values, dtype=float)
    return columns
