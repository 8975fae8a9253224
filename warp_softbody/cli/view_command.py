"""`warp-softbody view SCENE|STAGE` shows a running scene, or a finished stage, in a browser."""

from __future__ import annotations

import argparse
import math
import time
import webbrowser
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from warp_softbody.cli.arguments import key_value, number, whole
from warp_softbody.cli.display import has_display
from warp_softbody.cli.interruption import Interruption, exit_code, held_back
from warp_softbody.cli.option_flags import add_option_flags
from warp_softbody.cli.output import complain, note, say
from warp_softbody.cli.run_plan import plan_run
from warp_softbody.controllers.control_options import METHODS, ControlOptions
from warp_softbody.engine.options import SimulationOptions
from warp_softbody.errors import InputError, OutputError
from warp_softbody.run.warp_session import warp_engine

if TYPE_CHECKING:
    from warp_softbody.live.live_scene import LivePlan
    from warp_softbody.live.server import PageServer

OWN_DEFAULTS = {"time_step": "that of the scene"}
PAUSE = 0.2
"""Seconds between looks at whether to end."""
STAGES = (".usd", ".usda", ".usdc", ".usdz")


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Register the subcommand; its handler is `run`."""
    parser = subparsers.add_parser(
        "view",
        help="show and touch a running scene, or play a stage, in a browser",
        description="Run a scene on a page that only this machine can open, to be paused, pulled, "
        "pushed and recorded there; or play a finished stage. Ctrl-C ends it.",
    )
    parser.add_argument("shown", metavar="SCENE|STAGE", help="name of a scene, or path of a stage")
    parser.add_argument(
        "--port",
        metavar="N",
        type=whole(0, 65535),
        default=0,
        help="of 127.0.0.1 (default: 0, any free one)",
    )
    parser.add_argument("--open", action="store_true", help="open the page in the browser")
    parser.add_argument(
        "--record",
        metavar="FOLDER",
        type=Path,
        default=Path(),
        help="where the page records stages to (default: the current folder)",
    )
    parser.add_argument(
        "--controller",
        choices=(*METHODS, "none"),
        help="how muscles are driven at the start, as for `run`",
    )
    parser.add_argument(
        "--set",
        metavar="KEY=VALUE",
        type=key_value,
        action="append",
        default=[],
        help="a setting of the scene, such as push=0.3; may be repeated",
    )
    parser.add_argument(
        "--do",
        metavar="WHAT",
        help="what the character of a file, NAME.char, does: balance (default), walk, crawl, jump, "
        "hop or roll, or several in turn, as walk:2m,jump,balance",
    )
    parser.add_argument(
        "--seconds",
        metavar="S",
        type=number(1e-3, 1e5, "s"),
        help="end after so long, of real time (default: Ctrl-C)",
    )
    add_option_flags(parser, SimulationOptions, "simulation options", OWN_DEFAULTS)
    add_option_flags(parser, ControlOptions, "control options")
    parser.set_defaults(handler=run)


def run(args: argparse.Namespace) -> int:
    """Serve until Ctrl-C; return the exit code.

    Raises:
        SoftBodyError: the sentence for the user.
    """
    path = Path(args.shown)
    if args.do is not None and path.suffix.lower() in STAGES:
        raise InputError("--do is for the character of a file, and a finished stage has none")
    return _play(args, path) if path.suffix.lower() in STAGES else _live(args)


def _play(args: argparse.Namespace, path: Path) -> int:
    """A stage is played by the page alone; the program only hands it out."""
    with held_back():
        from warp_softbody.live.server import PageServer
        from warp_softbody.live.stage_view import stage_page

    server = PageServer(args.port, finished=stage_page(path))
    with Interruption() as interruption:
        ended = _ended(args, interruption)
        _begin(args, server)
        while not ended():
            time.sleep(PAUSE)
        server.end()
    return exit_code(interruption.number) if interruption.asked else 0


def _live(args: argparse.Namespace) -> int:
    with held_back():
        from warp_softbody.live.live_scene import LiveScene
        from warp_softbody.live.server import PageServer
        from warp_softbody.live.session import FPS, LiveSession

    # of `run`, whose arguments these are
    given = argparse.Namespace(
        **vars(args), scene=args.shown, fps=FPS, error=None, quiet=True, json=False
    )
    given.seconds = None
    plan = _plan(given)
    if args.record.is_file():
        raise OutputError(f"--record: {str(args.record)!r} is a file and no folder")
    if not args.record.is_dir():
        raise OutputError(f"--record: there is no folder {str(args.record)!r}")
    with (
        Interruption() as interruption,
        warp_engine(plan.options.device, lambda: note("compiling kernels (first run only)\n")),
    ):
        session = LiveSession(LiveScene(lambda: _plan(given), FPS), args.record)
        server = PageServer(args.port, session=session)
        _begin(args, server)
        interruption.patient = True
        session.run(_ended(args, interruption))
        server.end()
    return exit_code(interruption.number) if interruption.asked else 0


def _plan(args: argparse.Namespace) -> LivePlan:
    from warp_softbody.live.live_scene import LivePlan

    plan = plan_run(args)
    return LivePlan(
        name=plan.scene.name,
        scene=plan.scene.scene,
        controller=plan.scene.controller,
        others=plan.scene.others,
        options=plan.options,
        control=plan.control,
    )


def _ended(args: argparse.Namespace, interruption: Interruption) -> Callable[[], bool]:
    """Whether the user has asked for the end, or the time given is over."""
    interruption.patient = True
    end = math.inf if args.seconds is None else time.monotonic() + args.seconds
    return lambda: interruption.asked or time.monotonic() > end


def _begin(args: argparse.Namespace, server: PageServer) -> None:
    """Answer, tell the address, and open it where that is asked for and there is a display."""
    server.begin()
    address = server.access.address
    say(address)
    note("Open this address in a browser on this machine; Ctrl-C ends.\n")
    if not args.open:
        return
    if not has_display() or not webbrowser.open(address):
        complain("no browser could be opened, as there is no display; open the address above")
