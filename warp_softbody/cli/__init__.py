"""The command line `warp-softbody`: a user's mistake is answered with one sentence, no traceback.

Exit codes: 0 done, 2 bad input or output, 3 the numbers stopped being finite, 128 + n ended by
signal n (130 for Ctrl-C), 141 nobody took the output.
"""

from __future__ import annotations

from collections.abc import Sequence

from warp_softbody import __version__
from warp_softbody.cli import (
    character_command,
    chart_command,
    check_command,
    completion_command,
    convert_command,
    demo_command,
    doctor_command,
    list_command,
    mesh_command,
    new_command,
    output,
    picture_command,
    recover_command,
    run_command,
    teach_command,
    tune_command,
    view_command,
)
from warp_softbody.cli.arguments import Parser
from warp_softbody.cli.interruption import Interrupted, exit_code, interruptible
from warp_softbody.errors import NotFiniteError, SoftBodyError

FAILED = 2
NOT_FINITE = 3
COMMANDS = (
    demo_command,
    list_command,
    run_command,
    new_command,
    check_command,
    view_command,
    recover_command,
    convert_command,
    picture_command,
    mesh_command,
    character_command,
    teach_command,
    chart_command,
    tune_command,
    doctor_command,
    completion_command,
)


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command line and return its exit code; nothing is raised for a user's mistake."""
    output.begin()
    try:
        with interruptible(), output.warnings_as_lines():
            code = _run(argv)
    except Interrupted as interrupted:
        code = _tell(str(interrupted), exit_code(interrupted.number))
    return output.finish(code)


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


def _tell(error: SoftBodyError | str, code: int) -> int:
    output.complain(str(error))
    return code


def _parser() -> Parser:
    parser = Parser(
        prog="warp-softbody",
        description="Muscle-driven soft-body characters that move by physics.",
    )
    parser.add_argument("--version", action="version", version=f"warp-softbody {__version__}")
    parser.set_defaults(program=parser)
    subparsers = parser.add_subparsers(required=True, metavar="COMMAND")
    for command in COMMANDS:
        command.add_parser(subparsers)
    return parser
