"""`warp-softbody recover STAGE` makes a stage of the frames that a killed run has left."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from warp_softbody.cli.interruption import held_back
from warp_softbody.cli.output import say


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Register the subcommand; its handler is `run`."""
    parser = subparsers.add_parser(
        "recover",
        help="make a stage of what a killed run left",
        description="Make a stage of the frames that a run which was killed, or whose disk was "
        "full, left beside the stage it was to write.",
    )
    parser.add_argument(
        "stage", metavar="STAGE", type=Path, help="the file that the run was to write"
    )
    parser.add_argument(
        "--out", metavar="F.usdc", type=Path, help="where to write the stage instead of STAGE"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(handler=run)


def run(args: argparse.Namespace) -> int:
    """Write the stage and say how many frames it has; return 0.

    Raises:
        SoftBodyError: nothing was left, a chunk is damaged, the stage cannot be written, or a
            file stands there that the run was not to replace.
    """
    with held_back():
        from warp_softbody.stage_exports.usd.recovery import recovered

    path, frames = recovered(args.stage, args.out)
    if args.json:
        say(json.dumps({"stage": str(path), "frames": frames}))
    else:
        say(f"recovered {frames} frames: {path}")
    return 0
