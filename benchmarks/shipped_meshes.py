"""What scenes gain by the coarser mesh with which they ship.

    python -m benchmarks.shipped_meshes --rounds 3 --write docs/frontier.md

Each round makes every such motion on the usual mesh, with the paper's number of tets
(``--set coarse=0``), and as it ships, in turn in one process, as ``warp-softbody run SCENE --fps
60`` does: control and export included. Medians of the rounds are shown. CPU times count the process
that writes beside the run too. Errors are those of the charts.
"""

from __future__ import annotations

import argparse
import resource
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any

from benchmarks.beam.arguments import count
from benchmarks.charts.command import Stored, percent, plain, stored
from benchmarks.marked_page import put, rows
from benchmarks.motions.command import run
from warp_softbody.accuracy.analysis.files import cells_of
from warp_softbody.accuracy.cases.case import shipped_coarse
from warp_softbody.accuracy.cases.settings import Settings
from warp_softbody.accuracy.cases.table import CASES

BEGIN = "<!-- shipped meshes: written by python -m benchmarks.shipped_meshes, from here -->"
END = "<!-- shipped meshes: to here -->"

Run = Callable[..., Mapping[str, Any]]


@dataclass(frozen=True)
class MeshCost:
    """What a run took.

    Attributes:
        tets: of the body.
        cpu: ms in a simulated second.
        real_time: simulated time over wall time.
    """

    tets: int
    cpu: float
    real_time: float


def moved() -> list[str]:
    """Scenes that ship with a coarser mesh than the usual one."""
    return [scene for scene, case in CASES.items() if case.controlled and shipped_coarse(scene)]


def cost(scene: str, coarse: int, folder: Path, seconds: float | None, make: Run = run) -> MeshCost:
    """One run of this process."""
    more = [] if seconds is None else ["--seconds", f"{seconds:g}"]
    begun = _cpu_seconds()
    found = make(scene, folder / f"{scene}.usdc", "--set", f"coarse={coarse}", *more)
    spent = _cpu_seconds() - begun
    return MeshCost(
        found["tets"], 1e3 * spent / found["simulated_seconds"], found["real_time_factor"]
    )


def costs(
    scene: str, rounds: int, folder: Path, seconds: float | None = None, make: Run = run
) -> tuple[MeshCost, MeshCost]:
    """Medians on the usual mesh and as it ships, taken in turn."""
    levels = (0, shipped_coarse(scene))
    for coarse in levels:
        cost(scene, coarse, folder, 0.1, make)
    pairs = [[cost(scene, one, folder, seconds, make) for one in levels] for _ in range(rounds)]
    usual, shipped = (_middle(each) for each in zip(*pairs, strict=True))
    return usual, shipped


def line(scene: str, usual: MeshCost, shipped: MeshCost, chart: Stored | None) -> list[str]:
    """A row of the table."""
    case = CASES[scene]
    errors = ", ".join(_error(chart, one) for one in (case.usual, case.default))
    return [
        f"`{scene}`",
        f"{usual.tets}, {shipped.tets}",
        errors,
        f"{plain(usual.cpu, 3)}, {plain(shipped.cpu, 3)}",
        f"{plain(usual.real_time, 2)}, {plain(shipped.real_time, 2)}",
        f"{usual.cpu / shipped.cpu:.1f}",
    ]


def _error(chart: Stored | None, settings: Settings) -> str:
    """That of the chart's own point with these settings; "-" where it has none."""
    wanted = {knob: str(value) for knob, value in cells_of(settings).items()}
    for point in () if chart is None else chart.points:
        same = all(point.get(knob, value) == value for knob, value in wanted.items())
        if point["solver"] == "ours" and same and point["error"]:
            return percent(float(point["error"]))
    return "-"


def _middle(costs: Sequence[MeshCost]) -> MeshCost:
    return MeshCost(
        costs[0].tets, median(one.cpu for one in costs), median(one.real_time for one in costs)
    )


def _cpu_seconds() -> float:
    kinds = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    used = [resource.getrusage(kind) for kind in kinds]
    return sum(one.ru_utime + one.ru_stime for one in used)


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, print the table, write it into the page."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.shipped_meshes",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help="names; default all such")
    parser.add_argument("--rounds", type=count, default=3, help="medians of so many (3)")
    parser.add_argument("--seconds", type=float, help="length of a run; default the scene's")
    parser.add_argument("--charts", type=Path, default=Path("docs/frontier"), metavar="FOLDER")
    parser.add_argument("--write", type=Path, help="page between whose marks the table goes")
    args = parser.parse_args(arguments)
    known = moved()
    if unknown := [name for name in args.scenes if name not in known]:
        parser.error(f"{unknown[0]!r} ships with its usual mesh; others: {', '.join(known)}")
    charts = stored(args.charts)
    head = ["scene", "tets: usual, shipped", "error: usual, shipped"]
    head += ["CPU ms in a simulated s: usual, shipped", "times real time: usual, shipped"]
    table = [[*head, "gain"]]
    with tempfile.TemporaryDirectory() as folder:
        for scene in args.scenes or known:
            pair = costs(scene, args.rounds, Path(folder), args.seconds)
            table.append(line(scene, *pair, charts.get(scene)))
            print("  ".join(table[-1]), flush=True)
    if args.write is not None:
        put(args.write, BEGIN, END, rows(table))


if __name__ == "__main__":
    main()
