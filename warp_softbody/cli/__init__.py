"""The command line `warp-softbody`: a user's mistake is answered with one sentence, no traceback.

Exit codes: 0 done, 2 bad input or output, 3 the numbers stopped being finite, 130 interrupted.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

from warp_softbody import __version__
from warp_softbody.cli import chart_command, list_command, mesh_command, run_command, tune_command
from warp_softbody.cli.arguments import Parser
from warp_softbody.errors import NotFiniteError, SoftBodyError

FAILED = 2
NOT_FINITE = 3
INTERRUPTED = 130
BROKEN_PIPE = 141


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command line and return its exit code; nothing is raised for a user's mistake."""
    try:
        code = _run(argv)
        sys.stdout.flush()
    except BrokenPipeError:
        # Whoever read our output has gone (`warp-softbody list | head -1`): nothing is left to say.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return BROKEN_PIPE
    return code


def _run(argv: Sequence[str] | None) -> int:
    try:
        args = _parser().parse_args(argv)
        return int(args.handler(args))
    except SystemExit as stop:
        # argparse, after --help and --version
        return int(stop.code or 0)
    except NotFiniteError as error:
        return _tell(error, NOT_FINITE)
    except SoftBodyError as error:
        return _tell(error, FAILED)
    except KeyboardInterrupt:
        return _tell("interrupted", INTERRUPTED)


def _tell(error: SoftBodyError | str, code: int) -> int:
    """One line on stderr, whatever line breaks a library has put into it."""
    print(f"warp-softbody: {' '.join(str(error).split())}", file=sys.stderr)
    return code


def _parser() -> Parser:
    parser = Parser(
        prog="warp-softbody",
        description="Muscle-driven soft-body characters that move by physics.",
    )
    parser.add_argument("--version", action="version", version=f"warp-softbody {__version__}")
    subparsers = parser.add_subparsers(required=True, metavar="COMMAND")
    for command in (list_command, run_command, mesh_command, chart_command, tune_command):
        command.add_parser(subparsers)
    return parser
