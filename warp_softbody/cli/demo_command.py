"""`warp-softbody demo` pushes a letter that keeps its balance, and shows it."""

from __future__ import annotations

import argparse
from importlib.util import find_spec
from pathlib import Path

from warp_softbody.cli import run_command
from warp_softbody.cli.arguments import Parser
from warp_softbody.cli.output import say
from warp_softbody.errors import OutputError

SCENE, PUSH, SECONDS = "balance-i", 0.45, 3.0
"""What is shown: a push of body weights, and for how long, s."""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Register the subcommand; its handler is `run`."""
    parser = subparsers.add_parser(
        "demo",
        help="see a character that is pushed, in a movie and a page",
        description=f"Simulates {SECONDS:g} s of {SCENE} and writes a page that plays it in any "
        "browser, and a movie where the extra 'view' is installed.",
    )
    parser.add_argument(
        "folder", metavar="FOLDER", type=Path, nargs="?", default=Path("demo"), help="(demo)"
    )
    parser.add_argument("--quiet", action="store_true", help="no progress bar and no summary")
    parser.set_defaults(handler=run)


def run(args: argparse.Namespace) -> int:
    """Make the folder and the files; return the exit code of the run.

    Raises:
        SoftBodyError: the folder cannot be made, or a file cannot be written.
    """
    try:
        args.folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"{args.folder}: cannot be made: {error.strerror or error}") from error
    page, movie = args.folder / "demo.html", args.folder / "demo.gif"
    line = ["run", SCENE, "--set", f"push={PUSH}", "--seconds", f"{SECONDS:g}"]
    line += ["--html", str(page)]
    if find_spec("embreex") is not None:
        line += ["--movie", str(movie), "--size", "480x360"]
    code = _as_typed([*line, "--quiet"] if args.quiet else line)
    if code == 0 and not args.quiet:
        say(f"open {page} in a browser; `warp-softbody list` shows what else there is")
    return code


def _as_typed(line: list[str]) -> int:
    """What a line of `run` does."""
    parser: argparse.ArgumentParser = Parser(prog="warp-softbody")
    run_command.add_parser(parser.add_subparsers(required=True))
    return run_command.run(parser.parse_args(line))
