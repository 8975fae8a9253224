"""`warp-softbody tune SCENE --error 2%` stores the cheapest settings within an error."""

from __future__ import annotations

import argparse
import json
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from warp_softbody.cli.arguments import key_value, unique
from warp_softbody.cli.chart_command import FOLDER, add_sweep_options, charted, sweep_workers
from warp_softbody.cli.output import say
from warp_softbody.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable
    from concurrent.futures import Executor

    from warp_softbody.accuracy.analysis.tuning import Tuned
    from warp_softbody.accuracy.cases.case import ChartCase
    from warp_softbody.accuracy.cases.settings import Settings
    from warp_softbody.accuracy.runs.outcome import RunOutcome


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Register the subcommand; its handler is `run`."""
    parser = subparsers.add_parser(
        "tune",
        help="find the cheapest settings of a scene for an error",
        description="Chart a scene, or take its chart from the journal, and store the cheapest "
        "settings that hold an error; `run SCENE --error` uses them.",
    )
    parser.add_argument("scene", metavar="SCENE", help="name of a charted scene")
    parser.add_argument(
        "--error", metavar="E", type=share, required=True, help="such as 2%% or 0.02"
    )
    parser.add_argument(
        "--out", metavar="F.json", type=Path, help="file to add them to (the user's own)"
    )
    parser.add_argument(
        "--set",
        metavar="KEY=VALUE",
        type=key_value,
        action="append",
        default=[],
        help="a setting of the scene, which is tried, not charted, where it is passive; may be "
        "repeated",
    )
    add_sweep_options(parser)
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(handler=run)


def share(text: str) -> float:
    """A reader of ``2%`` and ``0.02``."""
    number = text.strip().removesuffix("%")
    try:
        value = float(number) / (100.0 if text.strip().endswith("%") else 1.0)
    except ValueError:
        value = float("nan")
    if not 0.0 < value <= 1.0:
        raise argparse.ArgumentTypeError(
            f"must be a share of 1, such as 2% or 0.02, and at most 100%, got {text!r}"
        )
    return value


def run(args: argparse.Namespace) -> int:
    """Tune, store and print; return 0.

    Raises:
        SoftBodyError: no settings hold the bound, or the sentence for another mistake.
    """
    from warp_softbody.accuracy.analysis.family import Family
    from warp_softbody.accuracy.analysis.store import own_file, require_storable, save
    from warp_softbody.accuracy.analysis.tuning import choose, margin
    from warp_softbody.accuracy.cases.table import case_of

    def told(tuned: Tuned, path: Path) -> list[str]:
        default = case_of(tuned.scene).default
        elsewhere = []
        if tuned.elsewhere is not None:
            most = f"{100.0 * tuned.elsewhere:.2g} %"
            elsewhere = [f"  elsewhere   {most} at most on other floors and to its end"]
        return [
            f"{tuned.scene}: {tuned.settings.differences(default)}",
            f"  error       {100.0 * tuned.error:.2g} %, and {100.0 * tuned.uncertainty:.2g} % "
            f"that the reference is not sure of: within {100.0 * allowed:g} % of the bound of "
            f"{100.0 * tuned.bound:g} %",
            *elsewhere,
            f"  cost        {tuned.cost:.4g} ms of CPU time per simulated second; as shipped "
            f"{tuned.default_cost:.4g} ms at an error of {100.0 * tuned.default_error:.2g} %",
            *(f"  left out    {line}" for line in tuned.left_out),
            f"  stored in   {path}",
        ]

    case = with_settings(case_of(args.scene), args.set)
    # the motions of controlled bodies part, so that a few trials would tell nothing of them
    tried = bool(args.set) and not case.controlled
    journal = args.journal or FOLDER / "journal"
    allowed = 1.0 if tried else margin(case)
    path = args.out or own_file()
    require_storable(path)
    with sweep_workers(args) as executor:
        if tried:
            tuned = _tried(case, args, executor, journal)
        else:
            chart = charted(case, args, executor, journal)
            tuned = choose(chart, args.error, Family(chart, _runner(case, executor, journal)))
    save(tuned, path)
    if args.json:
        say(json.dumps({**tuned.to_dict(), "stored": str(path)}))
    else:
        say("\n".join(told(tuned, path)))
    return 0


def with_settings(case: ChartCase, pairs: list[tuple[str, str]]) -> ChartCase:
    """The case with settings of its scene; those that are knobs are refused."""
    from warp_softbody import scenes
    from warp_softbody.accuracy.cases.settings import SCENE_KNOBS

    values = unique(pairs, "--set")
    if knobs := [name for name in SCENE_KNOBS if name in values]:
        raise InputError(f"{knobs[0]} is what tune chooses, and cannot be set")
    plan = scenes.make(case.scene, {**case.given, **values})
    return replace(case, given={**case.given, **{key: plan.settings[key] for key in values}})


def _tried(case: ChartCase, args: argparse.Namespace, executor: Executor, journal: Path) -> Tuned:
    from warp_softbody.accuracy.analysis.trials import tuned_by_trials

    wanted = case.quickly() if args.quick else case
    run = _runner(wanted, executor, journal)
    return tuned_by_trials(wanted, lambda settings: run(wanted, settings), args.error)


def _runner(
    case: ChartCase, executor: Executor, journal: Path
) -> Callable[[ChartCase, Settings], RunOutcome]:
    """What makes a run of the scene, in any of its settings, or takes it from the journal."""
    from warp_softbody.accuracy.analysis.design import job
    from warp_softbody.accuracy.runs.journal import RunJournal
    from warp_softbody.accuracy.runs.sweep import sweep

    kept = RunJournal(journal, case.scene)

    def run(wanted: ChartCase, settings: Settings) -> RunOutcome:
        made = job(wanted, settings)
        return sweep([made], kept, executor)[made.key]

    return run
