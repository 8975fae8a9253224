"""The command line `warp-softbody`: a user's mistake is answered with one sentence, no traceback.

Exit codes: 0 done, 2 bad input or output, 3 the numbers stopped being finite, 130 interrupted.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from contextlib import suppress

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
    _open_closed_streams()
    try:
        code = _run(argv)
        sys.stdout.flush()
    except BrokenPipeError:
        # Whoever read our output has gone (`warp-softbody list | head -1`): nothing is left to say.
        _drop_output()
        return BROKEN_PIPE
    except OSError as error:
        # what was computed stands in its files; only the text about it is lost
        _drop_output()
        place = "output" if error.filename is None else repr(error.filename)
        return _tell(f"{place} could not be written: {error.strerror or error}", FAILED)
    return code


def _open_closed_streams() -> None:
    """Let stdin, stdout and stderr that are closed lead nowhere.

    A file opened later would get their number, and what a library prints would end in it.
    """
    for number, name, mode in ((0, "stdin", "r"), (1, "stdout", "w"), (2, "stderr", "w")):
        try:
            os.fstat(number)
        except OSError:
            nowhere = os.open(os.devnull, os.O_RDWR)
            if nowhere != number:
                os.dup2(nowhere, number)
                os.close(nowhere)
        if getattr(sys, name) is None:
            setattr(sys, name, open(number, mode, closefd=False))


def _drop_output() -> None:
    """Let what is still to be printed lead nowhere, so that the exit does not stumble on it."""
    with suppress(OSError, ValueError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
        os.close(nowhere)


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
    with suppress(OSError):
        # a full or closed stderr takes no sentence; the code tells
        print(f"warp-softbody: {' '.join(str(error).split())}", file=sys.stderr, flush=True)
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
