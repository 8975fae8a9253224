"""`warp-softbody run NAME` simulates a scene; it writes stage, movie, picture, page and summary."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from warp_softbody.cli.arguments import camera, key_value, number, size
from warp_softbody.cli.interruption import Interrupted, Interruption, exit_code, held_back
from warp_softbody.cli.option_flags import add_option_flags
from warp_softbody.cli.output import complain, say
from warp_softbody.cli.progress import ProgressBar
from warp_softbody.cli.run_plan import RunPlan, plan_run
from warp_softbody.cli.scene_file_runs import refuse_one_name_twice, take_output
from warp_softbody.cli.tune_command import share
from warp_softbody.controllers.control_options import METHODS, ControlOptions
from warp_softbody.engine.options import SimulationOptions
from warp_softbody.errors import NotFiniteError
from warp_softbody.run.warp_session import warp_engine

if TYPE_CHECKING:
    from warp_softbody.cli.run_files import RunFiles
    from warp_softbody.run.recorder import Recorder
    from warp_softbody.run.simulation import Simulation

OWN_DEFAULTS = {"time_step": "that of the scene"}
"""Of options that a run does not take from their class."""

DOUBTFUL = 4
"""Ran to its end, but something in the result should not be believed; the summary says what."""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Register the subcommand; its handler is `run`."""
    parser = subparsers.add_parser(
        "run",
        help="simulate a scene",
        description="Simulate a scene. `warp-softbody list` shows the scenes and their settings.",
    )
    parser.add_argument(
        "scene",
        metavar="NAME",
        help="name of a scene, such as balance-i, or a file of one (.toml) or of a character "
        "(.char)",
    )
    _add_files(parser)
    _add_numbers(parser)
    add_option_flags(parser, SimulationOptions, "simulation options", OWN_DEFAULTS)
    add_option_flags(parser, ControlOptions, "control options")
    parser.add_argument("--json", action="store_true", help="print one JSON object on stdout")
    parser.add_argument("--quiet", action="store_true", help="no progress bar and no summary")
    parser.set_defaults(handler=run)


def _add_files(parser: argparse.ArgumentParser) -> None:
    for option, target, text in (
        ("--out", "F.usdc", "stage to write (.usdc, .usda, .usd or .usdz)"),
        ("--picture", "F.png", "picture of the last frame"),
        ("--movie", "F.gif", "movie of the run (.gif or .mp4)"),
        ("--plots", "FOLDER", "plots of every step, .png and .csv"),
        ("--html", "F.html", "page that plays the run in any browser, without a connection"),
    ):
        parser.add_argument(option, metavar=target, type=Path, help=text)
    parser.add_argument(
        "--camera",
        metavar="C",
        type=camera,
        help="of stage and movie: follow (default) keeps the bodies in the picture, still frames "
        "the start pose, X,Y,Z is the place in m of one that looks at the start pose; where X is "
        "negative, --camera=-X,Y,Z",
    )
    parser.add_argument(
        "--size",
        metavar="WxH",
        type=size,
        help="pixels of movie and picture (640x480 and 960x720)",
    )
    parser.add_argument(
        "--physics",
        choices=("newton", "omni", "none"),
        default="newton",
        help="names under which other programs find in the stage what bodies are made of (newton)",
    )


def _add_numbers(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--seconds", metavar="S", type=number(1e-3, 1e5, "s"), help="length (default: the scene's)"
    )
    parser.add_argument("--fps", metavar="N", type=number(0.1, 1e4), help="frames a second (30)")
    parser.add_argument(
        "--error", metavar="E", type=share, help="take the stored settings that hold it, as 2%%"
    )
    parser.add_argument(
        "--controller",
        choices=(*METHODS, "none"),
        help="how muscles are driven: by the contact QPCC (default), by a QP that takes all "
        "contacts for static, or not at all",
    )
    parser.add_argument(
        "--do",
        metavar="WHAT",
        help="what the character of a file, NAME.char, does: balance (default), walk, crawl, jump, "
        "hop or roll, or several in turn, as walk:2m,jump,balance",
    )
    parser.add_argument(
        "--set",
        metavar="KEY=VALUE",
        type=key_value,
        action="append",
        default=[],
        help="a setting of the scene, such as push=0.3; may be repeated",
    )


def run(args: argparse.Namespace) -> int:
    """Check everything, simulate, write the files and the summary; return the exit code.

    Raises:
        SoftBodyError: the sentence for the user; a NotFiniteError's frames so far are saved.
    """
    take_output(args)
    plan = plan_run(args)
    files = _files(args, plan)
    with (
        Interruption() as interruption,
        ProgressBar(plan.scene.name, plan.seconds, quiet=args.quiet) as progress,
        warp_engine(plan.options.device, progress.compiling),
    ):
        simulation = _simulation(plan, args.fps)
        steps = _recorder(args, simulation)
        try:
            failure = _record(simulation, plan.seconds, files, interruption, progress)
        except Interrupted as interrupted:
            if args.out is not None and files.has_frames:
                interrupted.left = (
                    f" before {str(args.out)!r} was whole; `warp-softbody recover` makes a stage "
                    "of the frames that were kept"
                )
            raise
    if steps is not None and len(steps):
        steps.plot(args.plots)
    status = _report(args, simulation, plan, files)
    if failure is not None:
        raise failure
    if interruption.asked:
        return exit_code(interruption.number)
    return DOUBTFUL if status == "doubtful" else 0


def _recorder(args: argparse.Namespace, simulation: Simulation) -> Recorder | None:
    """What keeps the steps for plots; None where none are asked for."""
    if args.plots is None:
        return None
    from warp_softbody.run.recorder import Recorder

    return Recorder(simulation)


def _files(args: argparse.Namespace, plan: RunPlan) -> RunFiles:
    with held_back():
        from warp_softbody.cli.run_files import RunFiles

    refuse_one_name_twice(args)
    if args.plots is not None:
        from warp_softbody.run.plots import check_plots

        check_plots(args.plots)
    options = plan.recorded(plan.options, motion_only=True)
    return RunFiles(
        plan.scene.scene,
        fps=args.fps,
        stage=args.out,
        movie=args.movie,
        picture=args.picture,
        page=args.html,
        name=plan.scene.name,
        camera=args.camera,
        size=args.size,
        physics=args.physics,
        metadata={
            "scene": plan.scene.name,
            **{name: value for name, value in options.items() if value is not None},
            **{f"set_{key}": value for key, value in plan.scene.settings.items()},
        },
    )


def _simulation(plan: RunPlan, fps: float) -> Simulation:
    from warp_softbody.run.simulation import Simulation

    return Simulation(
        plan.scene.scene,
        None if plan.control is None else plan.scene.controller,
        others=None if plan.control is None else plan.scene.others,
        options=plan.options,
        control_options=plan.control,
        fps=fps,
        name=plan.scene.name,
    )


def _record(
    simulation: Simulation,
    seconds: float,
    files: RunFiles,
    interruption: Interruption,
    progress: ProgressBar,
) -> NotFiniteError | None:
    """Run the simulation into the files; whatever stops it, they keep the frames so far."""
    failure = None
    with files:
        try:
            for frame in simulation.run(seconds):
                interruption.patient = True
                files.write(frame)
                simulation.count_export(files.last_seconds)
                progress.reached(frame.time)
                interruption.patient = frame.index > 0
                if interruption.asked:
                    break
        except KeyboardInterrupt:
            interruption.asked = True
        except NotFiniteError as error:
            failure = error
        progress.closing()
    simulation.count_export(files.last_seconds)
    if interruption.asked:
        simulation.interrupt()
    return failure


def _report(
    args: argparse.Namespace, simulation: Simulation, plan: RunPlan, files: RunFiles
) -> str:
    """Print the summary; return its status."""
    from warp_softbody.cli.report import as_json, as_text

    def path(target: Path | None) -> str | None:
        return str(target) if target is not None and files.has_frames else None

    summary = simulation.summary(stage=path(args.out))
    more: dict[str, Any] = {
        "picture": path(args.picture),
        "movie": path(args.movie),
        "plots": path(args.plots),
        "html": path(args.html),
        **plan.recorded(simulation.model.options),
        "fps": args.fps,
        "settings": dict(plan.scene.settings),
        "tuned": None if plan.tuned is None else plan.tuned.taken(),
    }
    if args.json:
        say(as_json(summary, more))
    elif not args.quiet:
        say(as_text(summary, more, asked_time_step=plan.options.time_step))
    if args.json or args.quiet:
        for doubt in summary.findings.doubts:
            complain(f"in doubt: {doubt}")
    return summary.status
