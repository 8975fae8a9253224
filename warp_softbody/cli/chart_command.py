"""`warp-softbody chart SCENE` measures error over cost of a scene, as a table and a picture."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from warp_softbody.cli.arguments import whole
from warp_softbody.cli.output import complain, note, say
from warp_softbody.errors import InputError, MissingExtraError, OutputError, SoftBodyError

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from warp_softbody.accuracy.analysis.chart import Chart
    from warp_softbody.accuracy.cases.case import ChartCase
    from warp_softbody.accuracy.runs.sweep import Progress

FOLDER = Path("frontier")
FAILED = 2


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Register the subcommand; its handler is `run`."""
    parser = subparsers.add_parser(
        "chart",
        help="chart the error of a scene over its cost",
        description="Run a scene over its knobs, short, and chart error over CPU time.",
    )
    parser.add_argument("scene", metavar="SCENE", help="name of a charted scene, or all")
    parser.add_argument(
        "--out",
        metavar="FOLDER",
        type=Path,
        default=FOLDER,
        help=f"where SCENE.csv, .json and .png go ({FOLDER})",
    )
    add_sweep_options(parser)
    parser.add_argument("--peers", action="store_true", help="other programs as well (extra bench)")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(handler=run)


def add_sweep_options(parser: argparse.ArgumentParser) -> None:
    """Those of every command that makes many runs."""
    parser.add_argument(
        "--journal",
        metavar="FOLDER",
        type=Path,
        help="where finished runs are kept and found again (journal in the folder of --out)",
    )
    parser.add_argument(
        "--workers", metavar="N", type=whole(1, 256), help="processes (one for each core)"
    )
    parser.add_argument("--dask", metavar="ADDRESS", help="a Dask cluster instead, tcp://...")
    parser.add_argument("--quick", action="store_true", help="shorter runs, fewer and coarser")


def run(args: argparse.Namespace) -> int:
    """Make the charts and write their files; return 0, or 2 where a scene of all failed.

    Raises:
        SoftBodyError: the sentence for the user.
    """
    from warp_softbody.accuracy.analysis.files import require_folder
    from warp_softbody.accuracy.analysis.picture import require_matplotlib
    from warp_softbody.accuracy.runs.peer_runs import require_peers

    cases = _cases(args.scene)
    require_matplotlib()
    require_folder(args.out)
    if args.peers:
        require_peers()
    told: list[dict[str, Any]] = []
    failed: list[str] = []
    for case in cases:
        try:
            # processes of their own, so that one that is ended from outside costs one scene
            with sweep_workers(args) as executor:
                told.append(_made(case, args, executor))
        except (InputError, MissingExtraError, OutputError):
            # the next scene would meet the same
            raise
        except Exception as error:
            # an hour's other scenes are not lost by a mistake in one
            if len(cases) == 1:
                raise
            failed.append(case.scene)
            kind = "" if isinstance(error, SoftBodyError) else f"{type(error).__name__}: "
            complain(f"no chart of {case.scene}: {kind}{error}")
    if args.json:
        say(json.dumps({"charts": told, "failed": failed}, allow_nan=False))
    if failed:
        complain(f"failed: {', '.join(failed)}")
    return FAILED if failed else 0


def _made(case: ChartCase, args: argparse.Namespace, executor: Executor) -> dict[str, Any]:
    """A scene's chart and its files."""
    from warp_softbody.accuracy.analysis.files import as_dict, write_tables
    from warp_softbody.accuracy.analysis.picture import draw

    chart = charted(case, args, executor, args.journal or args.out / "journal")
    picture = args.out / f"{case.scene}.png"
    files = [str(path) for path in (*write_tables(chart, args.out), draw(chart, picture))]
    if not args.json:
        say("\n".join([*lines(chart), *(f"  {path}" for path in files)]))
    return {**as_dict(chart), "files": files}


def _cases(scene: str) -> list[ChartCase]:
    from warp_softbody.accuracy.cases.table import CASES, case_of

    return list(CASES.values()) if scene == "all" else [case_of(scene)]


@contextmanager
def sweep_workers(args: argparse.Namespace) -> Iterator[Executor]:
    """Those that ``args`` ask for."""
    from warp_softbody.accuracy.runs.workers import cores, workers

    with workers(args.workers or cores(), args.dask) as executor:
        yield executor


def charted(case: ChartCase, args: argparse.Namespace, executor: Executor, journal: Path) -> Chart:
    """Run what the journal lacks of a case; progress goes to a terminal's stderr."""
    from warp_softbody.accuracy.analysis.chart import make_chart
    from warp_softbody.accuracy.runs.journal import RunJournal

    wanted = case.quickly() if args.quick else case

    def tell(what: str) -> Progress:
        return lambda done, total: _progress(f"{case.scene}: {what}, {done} of {total}")

    chart = make_chart(
        wanted,
        RunJournal(journal, case.scene),
        executor,
        tell,
        peers=getattr(args, "peers", False),
    )
    _progress("")
    return chart


def _progress(text: str) -> None:
    if sys.stderr.isatty():
        note(f"\r\033[K{text}")


def lines(chart: Chart) -> list[str]:
    """The reference with its evidence, and the frontier."""
    reference, default = chart.reference, chart.case.default
    finest, beside = reference.finest, reference.beside
    told = [
        f"{chart.case.scene}: {len(chart.points)} points of {chart.case.seconds:g} s",
        f"  reference   {finest.differences(default)}; "
        + ("beside it " if chart.case.controlled else "the rest of the way to dt = 0 as ")
        + beside.differences(finest),
        f"              the coarser mesh differs by {_percent(reference.mesh_change)}, twice the "
        f"least time step by {_percent(reference.time_change)}",
    ]
    if not chart.case.controlled:
        told[-1] += (
            f", what a time step changes on either mesh by {_percent(reference.mixed_change)}"
        )
    told += [
        f"  as shipped  {chart.default.outcome.cost:.4g} ms per simulated second, "
        f"error {_percent(chart.default.error)}",
        "  frontier",
    ]
    told += [
        f"    {point.outcome.cost:8.4g} ms  {_percent(point.error):>8}  "
        f"{point.settings.differences(default)}"
        for point in chart.frontier
    ]
    return told


def _percent(value: float | None) -> str:
    return "-" if value is None else f"{float(f'{100.0 * value:.2g}'):g} %"
