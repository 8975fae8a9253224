"""What was planned for the character and what came of it, as one picture of a record."""

from __future__ import annotations

from collections.abc import Mapping

from warp_softbody.arrays import FloatArray
from warp_softbody.run.plot_tables import Array, PlotSheet, PlotTable

_VECTORS = {
    "p": ("momentum", "Momentum", "N s"),
    "H": ("angular_momentum", "Angular momentum about the centre of mass", "N m s"),
}
"""By symbol: the array, the title and the unit."""

_MISSES = {"momentum": "m g dt", "feet": "sqrt(g L)", "cost": "the larger cost"}


def plan_sheets(arrays: Mapping[str, Array]) -> tuple[PlotSheet, ...]:
    """One sheet of a record's arrays; none where no step was planned."""
    if "plan/momentum" not in arrays:
        return ()
    tables = [_vector(arrays, symbol) for symbol in _VECTORS]
    share = ("plan/contact_share", "plan/contact_share_reached")
    tables.append(_pair(arrays, share, "contact", "Share of the weight that contact bears"))
    cost = ("objective/planned", "objective/reached")
    tables.append(
        _pair(arrays, cost, "cost", "Cost of goals and activations", logarithmic=True),
    )
    tables.append(
        PlotTable(
            name="miss",
            title="What a step misses of its plan",
            unit="1",
            time=arrays["time"],
            columns={
                f"{what} over {unit}": arrays[f"plan/{what}_miss"] for what, unit in _MISSES.items()
            },
            logarithmic=True,
        )
    )
    return (PlotSheet(name="plan", tables=tuple(tables)),)


def _vector(arrays: Mapping[str, Array], symbol: str) -> PlotTable:
    name, title, unit = _VECTORS[symbol]
    # the character is the first body
    kinds = {"realised": arrays[name][:, 0], "planned": arrays[f"plan/{name}"]}
    columns: dict[str, FloatArray] = {
        f"{symbol}_{axis} {kind}": values[:, i]
        for i, axis in enumerate("xyz")
        for kind, values in kinds.items()
    }
    return PlotTable(
        name=name, title=title, unit=unit, time=arrays["time"], columns=columns, paired=True
    )


def _pair(
    arrays: Mapping[str, Array],
    names: tuple[str, str],
    symbol: str,
    title: str,
    *,
    logarithmic: bool = False,
) -> PlotTable:
    planned, realised = (arrays[name] for name in names)
    return PlotTable(
        name=symbol,
        title=title,
        unit="1",
        time=arrays["time"],
        columns={f"{symbol} realised": realised, f"{symbol} planned": planned},
        logarithmic=logarithmic,
        paired=True,
    )
