"""`warp-softbody run NAME`: simulate a scene; write a stage, a movie, a picture and a summary."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from warp_softbody.cli.arguments import key_value, number, whole
from warp_softbody.cli.interruption import Interrupted, Interruption, exit_code, held_back
from warp_softbody.cli.output import complain, say
from warp_softbody.cli.progress import ProgressBar
from warp_softbody.cli.tune_command import share
from warp_softbody.cli.tuned_options import tuned_engine, tuned_plan
from warp_softbody.engine.options import CONES, ELEMENTS, PRECISIONS, TANGENTS
from warp_softbody.errors import InputError, NotFiniteError
from warp_softbody.run.warp_session import warp_engine

if TYPE_CHECKING:
    from warp_softbody.cli.recorder import Recorder
    from warp_softbody.run.simulation import Simulation
    from warp_softbody.scenes import ScenePlan

DOUBTFUL = 4
"""Ran to its end, but something in the result should not be believed; the summary says what."""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Register the subcommand; its handler is `run`."""
    parser = subparsers.add_parser(
        "run",
        help="simulate a scene",
        description="Simulate a scene. `warp-softbody list` shows the scenes and their settings.",
    )
    parser.add_argument("scene", metavar="NAME", help="name of a scene, such as balance-i")
    _add_files(parser)
    _add_numbers(parser)
    parser.add_argument("--json", action="store_true", help="print one JSON object on stdout")
    parser.add_argument("--quiet", action="store_true", help="no progress bar and no summary")
    parser.set_defaults(handler=run)


def _add_files(parser: argparse.ArgumentParser) -> None:
    for option, target, text in (
        ("--out", "F.usdc", "stage to write (.usdc, .usda or .usd)"),
        ("--picture", "F.png", "picture of the last frame"),
        ("--movie", "F.gif", "movie of the run (.gif or .mp4)"),
    ):
        parser.add_argument(option, metavar=target, type=Path, help=text)


def _add_numbers(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--seconds", metavar="S", type=number(1e-3, 1e5, "s"), help="length (default: the scene's)"
    )
    parser.add_argument(
        "--fps", metavar="N", type=number(0.1, 1e4), default=30.0, help="frames a second (30)"
    )
    parser.add_argument(
        "--time-step",
        metavar="DT",
        type=number(1e-6, 1.0, "s"),
        help="longest time step in s (default: the scene's); shortened to fit whole frames",
    )
    parser.add_argument(
        "--precision",
        choices=PRECISIONS,
        default="auto",
        help="floating-point type; auto takes float32 where its rounding hides nothing (auto)",
    )
    parser.add_argument(
        "--tangent",
        choices=TANGENTS,
        default="warped",
        help="stiffness matrix of the implicit step; conserving keeps the angular momentum of a "
        "free body (warped)",
    )
    parser.add_argument(
        "--elements",
        choices=ELEMENTS,
        default="linear",
        help="four-node tets as they are, or smoothed ones, which hardly lock (linear)",
    )
    parser.add_argument(
        "--cone",
        choices=CONES,
        default="smooth",
        help="friction cone of the ground, or the number of directions of a polygon (smooth)",
    )
    parser.add_argument(
        "--threads", type=whole(1, 64), default=1, help="threads that assemble forces (1)"
    )
    parser.add_argument(
        "--error", metavar="E", type=share, help="take the stored settings that hold it, as 2%%"
    )
    parser.add_argument("--device", default="cpu", help="Warp device, such as cpu or cuda:0 (cpu)")
    parser.add_argument(
        "--controller",
        choices=("qpcc", "static", "none"),
        help="how muscles are driven: by the contact QPCC (default), by a QP that takes all "
        "contacts for static, or not at all",
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
    plan, method = _planned(args)
    recorder = _recorder(args, plan, method)
    with (
        tuned_engine(args),
        Interruption() as interruption,
        ProgressBar(plan.name, args.seconds, quiet=args.quiet) as progress,
        warp_engine(args.device, progress.compiling),
    ):
        simulation = _simulation(args, plan, method)
        try:
            failure = _record(simulation, args.seconds, recorder, interruption, progress)
        except Interrupted as interrupted:
            if args.out is not None and recorder.has_frames:
                interrupted.left = (
                    f" before {str(args.out)!r} was whole; `warp-softbody recover` makes a stage "
                    "of the frames that were kept"
                )
            raise
    status = _report(args, simulation, plan, method, recorder)
    if failure is not None:
        raise failure
    if interruption.asked:
        return exit_code(interruption.number)
    return DOUBTFUL if status == "doubtful" else 0


def _planned(args: argparse.Namespace) -> tuple[ScenePlan, str]:
    """The scene and how its muscles are driven; the scene's numbers fill what was not given."""
    plan = tuned_plan(args)
    args.seconds = plan.seconds if args.seconds is None else args.seconds
    args.time_step = plan.time_step if args.time_step is None else args.time_step
    if args.seconds <= 0.5 / args.fps:
        raise InputError(
            f"--seconds {args.seconds:g} is less than half a frame at --fps {args.fps:g}"
        )
    args.precision = _precision(args, plan)
    if plan.controller is None and args.controller not in (None, "none"):
        raise InputError(
            f"--controller {args.controller}: scene {plan.name!r} has no controller, "
            "its body is passive"
        )
    return plan, "none" if plan.controller is None else args.controller or "qpcc"


def _precision(args: argparse.Namespace, plan: ScenePlan) -> str:
    """The precision asked for, or the one that suits the scene."""
    from warp_softbody.engine.options import SimulationOptions
    from warp_softbody.engine.precision_choice import with_precision

    options = SimulationOptions(time_step=args.time_step, precision=args.precision)
    return with_precision(options, plan.scene).precision


def _recorder(args: argparse.Namespace, plan: ScenePlan, method: str) -> Recorder:
    with held_back():
        from warp_softbody.cli.recorder import Recorder

    return Recorder(
        plan.scene,
        fps=args.fps,
        stage=args.out,
        movie=args.movie,
        picture=args.picture,
        metadata={
            "scene": plan.name,
            "controller": method,
            "precision": args.precision,
            "tangent": args.tangent,
            "elements": args.elements,
            "cone": args.cone,
            "time_step": args.time_step,
            **{f"set_{key}": value for key, value in plan.settings.items()},
        },
    )


def _simulation(args: argparse.Namespace, plan: ScenePlan, method: str) -> Simulation:
    from warp_softbody.engine.options import SimulationOptions
    from warp_softbody.run.simulation import Simulation

    return Simulation(
        plan.scene,
        None if method == "none" else plan.controller,
        options=SimulationOptions(
            time_step=args.time_step,
            precision=args.precision,
            tangent=args.tangent,
            elements=args.elements,
            cone=args.cone,
            newton_iterations=args.newton_iterations,
            tolerance=args.tolerance,
            threads=args.threads,
            device=args.device,
        ),
        fps=args.fps,
        method="static" if method == "static" else "qpcc",
        name=plan.name,
    )


def _record(
    simulation: Simulation,
    seconds: float,
    recorder: Recorder,
    interruption: Interruption,
    progress: ProgressBar,
) -> NotFiniteError | None:
    """Run the simulation into the files; whatever stops it, they keep the frames so far."""
    failure = None
    with recorder:
        try:
            for frame in simulation.run(seconds):
                interruption.patient = True
                recorder.write(frame)
                simulation.count_export(recorder.last_seconds)
                progress.reached(frame.time)
                interruption.patient = frame.index > 0
                if interruption.asked:
                    break
        except KeyboardInterrupt:
            interruption.asked = True
        except NotFiniteError as error:
            failure = error
        progress.closing()
    simulation.count_export(recorder.last_seconds)
    if interruption.asked:
        simulation.interrupt()
    return failure


def _report(
    args: argparse.Namespace,
    simulation: Simulation,
    plan: ScenePlan,
    method: str,
    recorder: Recorder,
) -> str:
    """Print the summary; return its status."""
    from warp_softbody.cli.report import as_json, as_text

    def path(target: Path | None) -> str | None:
        return str(target) if target is not None and recorder.has_frames else None

    summary = simulation.summary(stage=path(args.out))
    more: dict[str, Any] = {
        "picture": path(args.picture),
        "movie": path(args.movie),
        "controller": method,
        "precision": simulation.model.options.precision,
        "tangent": args.tangent,
        "elements": args.elements,
        "cone": args.cone,
        "device": args.device,
        "fps": args.fps,
        "settings": dict(plan.settings),
        "tuned": args.tuned,
    }
    if args.json:
        say(as_json(summary, more))
    elif not args.quiet:
        say(as_text(summary, more, asked_time_step=args.time_step))
    if args.json or args.quiet:
        for doubt in summary.findings.doubts:
            complain(f"in doubt: {doubt}")
    return summary.status
