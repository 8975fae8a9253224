"""The tables of docs/frontier.md, from the charts' files: ``python -m benchmarks.charts``.

Prints them, or with ``--write`` puts them between the marks of the page.
"""

from __future__ import annotations

import argparse
import csv
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any

from benchmarks.marked_page import put, rows
from warp_softbody.accuracy.analysis.chart import SETTLED
from warp_softbody.accuracy.analysis.design import WORTH
from warp_softbody.accuracy.analysis.store import SHIPPED, load
from warp_softbody.accuracy.cases.functionals import FUNCTIONALS
from warp_softbody.accuracy.cases.table import CASES

BEGIN = "<!-- {}: written by python -m benchmarks.charts, from here -->"
END = "<!-- to here -->"
REAL_TIME = 1000.0  # ms
SHOWN = 3
"""Most points of a controlled scene's frontier."""
CLOSE = 0.05
"""Error within which the cheapest settings are looked for."""


@dataclass(frozen=True)
class Stored:
    """The files of a chart.

    Attributes:
        note: of SCENE.json.
        points: rows of SCENE.csv.
    """

    note: Mapping[str, Any]
    points: Sequence[Mapping[str, str]]


def stored(folder: Path) -> dict[str, Stored]:
    """Of every scene of the table that has a chart, in the table's order."""
    found = {}
    for scene in CASES:
        note, table = folder / f"{scene}.json", folder / f"{scene}.csv"
        if note.exists() and table.exists():
            with table.open(encoding="utf-8", newline="") as lines:
                points = list(csv.DictReader(lines))
            found[scene] = Stored(json.loads(note.read_text(encoding="utf-8")), points)
    return found


def passive(charts: Mapping[str, Stored]) -> str:
    """A line a passive scene."""
    head = ["scene", "seconds", "functional, and its reference"]
    head += ["reference known to (mesh, time, mixed)", "as shipped", "same error for"]
    cells = [[*head, f"best below {REAL_TIME:.0f} ms"]]
    for scene, chart in charts.items():
        if not CASES[scene].controlled:
            default, frontier = chart.note["default"], chart.note["frontier"]
            most = (1.0 + WORTH) * float(default["error"])
            good = [one for one in frontier if float(one["error"]) <= most]
            quick = [one for one in frontier if float(one["cost_ms"]) <= REAL_TIME]
            same = f"{_ms(good[0])}: {good[0]['differs']}" if good else "-"
            best = _point(quick[-1]) if quick else "-"
            shipped = f"{_ms(default)}, {_error(default)}"
            known = _known(chart, ("mesh", "time", "mixed"))
            cells.append([*_named(scene, chart), _values(chart, False), known, shipped, same, best])
    return rows(cells)


def controlled(charts: Mapping[str, Stored]) -> str:
    """A line a controlled scene, and their pictures."""
    head = ["scene", "seconds", "functionals: shipped, reference"]
    cells = [[*head, "reference known to (mesh, time)", "as shipped", "frontier"]]
    pictures = []
    for scene, chart in charts.items():
        if CASES[scene].controlled:
            default, frontier = chart.note["default"], chart.note["frontier"]
            points = [_point(one) for one in frontier]
            shown = [*points[: SHOWN - 1], points[-1]] if len(points) > SHOWN else points
            known = _known(chart, ("mesh", "time"))
            shipped = f"{_ms(default)}, {_error(default)}"
            named, values = _named(scene, chart), _values(chart, True)
            cells.append([*named, values, known, shipped, "; ".join(shown)])
            pictures.append(f"![{scene}](frontier/{scene}.png)")
    return "\n".join([rows(cells), "", *pictures])


def knobs(charts: Mapping[str, Stored]) -> str:
    """Errors in % of what is shipped with one knob turned, a line a controlled scene."""
    singles = {
        scene: {point["differs"]: point for point in chart.points if _single(point)}
        for scene, chart in charts.items()
        if CASES[scene].controlled and "differs" in chart.points[0]
    }
    if not singles:
        return ""
    names = list(dict.fromkeys(name for points in singles.values() for name in points))
    names.sort(key=lambda name: (name != "default", name))
    cells = [["scene", *("as shipped" if name == "default" else name for name in names)]]
    ratios: dict[str, list[float]] = {name: [] for name in names}
    for scene, points in singles.items():
        shipped = float(points["default"]["cost_ms"])
        cells.append([f"`{scene}`", *(_outcome(points.get(name)) for name in names)])
        for name, point in points.items():
            if point["error"]:
                ratios[name].append(float(point["cost_ms"]) / shipped)
    middle = [f"{median(found):.2f}" if found else "" for found in ratios.values()]
    return rows([*cells, ["cost over that of what is shipped, median", *middle]])


def close(charts: Mapping[str, Stored]) -> str:
    """A line a controlled scene: the cheapest sound settings within 5 % of the reference."""
    head = ["scene", "as shipped", "cheapest within 5 %", "times real time, shipped and so"]
    cells = [[*head, "gain"]]
    for scene, chart in charts.items():
        if not CASES[scene].controlled:
            continue
        shipped = chart.note["default"]
        good = [one for one in chart.points if _is_close(one)]
        best = min(good, key=lambda one: float(one["cost_ms"]), default=None)
        if best is None:
            cells.append([f"`{scene}`", _error(shipped), "none", "", ""])
            continue
        costs = [float(one["cost_ms"]) for one in (shipped, best)]
        speeds = ", ".join(plain(REAL_TIME / cost, 2) for cost in costs)
        told = f"{best['differs']}: {_error(best)}"
        cells.append([f"`{scene}`", _error(shipped), told, speeds, f"{costs[0] / costs[1]:.1f}"])
    return rows(cells)


def _is_close(point: Mapping[str, str]) -> bool:
    """Whether a point is within 5 %, of ours, sound, and no run of the reference."""
    ours = point["solver"] == "ours" and point.get("precision") != "float64"
    if not ours or not point["error"] or float(point["error"]) > CLOSE:
        return False
    limits = {name: one.limit for name, one in FUNCTIONALS.items() if one.limit is not None}
    small = all(float(point[name]) <= limit for name, limit in limits.items() if point.get(name))
    return small and float(point.get("unconverged") or 0.0) <= SETTLED


def tuned() -> str:
    """A line for each of the settings that ship."""
    head = ["scene", "bound", "settings, as shipped but", "error, and reference", "ms"]
    cells = [[*head, "as shipped"]]
    for one in load(SHIPPED):
        cells.append(
            [
                f"`{one.scene}`",
                f"{100.0 * one.bound:g} %",
                one.settings.differences(CASES[one.scene].default),
                f"{percent(one.error)}, {percent(one.uncertainty)}",
                plain(one.cost, 3),
                f"{plain(one.default_cost, 3)} ms, {percent(one.default_error)}",
            ]
        )
    return rows(cells)


def percent(share: float) -> str:
    """With two digits."""
    return f"{plain(100.0 * share, 2)} %"


def plain(value: float, digits: int) -> str:
    """So many digits of a number, without an exponent below a million."""
    return f"{float(f'{value:.{digits}g}'):g}"


def _single(point: Mapping[str, str]) -> bool:
    return point["solver"] == "ours" and ", " not in point["differs"]


def _outcome(point: Mapping[str, str] | None) -> str:
    if point is None:
        return ""
    if point["error"]:
        return plain(100.0 * float(point["error"]), 2)
    return "refused" if point["tets"] == "0" else "fails"


def _named(scene: str, chart: Stored) -> list[str]:
    given = "".join(f", {key}={value:g}" for key, value in chart.note["given"].items())
    return [f"`{scene}`{given}", f"{chart.note['seconds']:g}"]


def _ms(row: Mapping[str, Any]) -> str:
    return f"{plain(float(row['cost_ms']), 3)} ms"


def _point(row: Mapping[str, Any]) -> str:
    return f"{_ms(row)}, {_error(row)}: {row['differs']}"


def _error(row: Mapping[str, Any]) -> str:
    return percent(float(row["error"])) if row["error"] else "failed"


def _known(chart: Stored, kinds: Sequence[str]) -> str:
    reference = chart.note["reference"]
    parts = ", ".join(percent(reference[f"{kind}_change"]) for kind in kinds)
    return f"{percent(reference['uncertainty'])} ({parts})"


def _values(chart: Stored, shipped: bool) -> str:
    texts = []
    for name, about in chart.note["functionals"].items():
        if about.get("limit") is not None:
            continue
        values = [chart.note["reference"]["functionals"][name]]
        if shipped and chart.note["default"].get(name):
            values.insert(0, float(chart.note["default"][name]))
        digits = 3 if shipped else 4
        numbers = ", ".join(plain(value, digits) for value in values)
        texts.append(f"{about['text']} {numbers} {about['unit']}")
    return "; ".join(texts)


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the tables, or write them into a page."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.charts", description=__doc__)
    parser.add_argument("--charts", type=Path, default=Path("docs/frontier"), metavar="FOLDER")
    parser.add_argument("--write", type=Path, metavar="PAGE")
    args = parser.parse_args(arguments)
    charts = stored(args.charts)
    tables = {
        "passive": passive(charts),
        "controlled": controlled(charts),
        "knobs": knobs(charts),
        "close": close(charts),
        "stored": tuned(),
    }
    for name, table in tables.items():
        if args.write is None:
            print(f"{name}\n\n{table}\n")
        else:
            put(args.write, BEGIN.format(name), END, table)
