"""`warp-softbody completion SHELL` prints what lets a shell complete command lines."""

from __future__ import annotations

import argparse

from warp_softbody.cli.output import say
from warp_softbody.inputs.extras import require_package

SHELLS = ("bash", "zsh", "tcsh")


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Register the subcommand; its handler is `run`."""
    parser = subparsers.add_parser(
        "completion",
        help="let a shell complete command lines",
        description="Print a script for a shell. For bash: warp-softbody completion bash > "
        "~/.local/share/bash-completion/completions/warp-softbody",
    )
    parser.add_argument("shell", choices=SHELLS, help="which shell")
    parser.set_defaults(handler=run)


def run(args: argparse.Namespace) -> int:
    """Print the script for the command line ``args.program``; return 0.

    Raises:
        MissingExtraError: shtab is not installed.
    """
    require_package("shtab", "completions", "completion")
    import shtab

    say(shtab.complete(args.program, shell=args.shell).rstrip("\n"))
    return 0
