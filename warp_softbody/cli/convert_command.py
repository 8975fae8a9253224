"""`warp-softbody convert STAGE -o FILE` writes a stage in the form of another program."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from warp_softbody.cli.interruption import held_back
from warp_softbody.cli.output import say


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Register the subcommand; its handler is `run`."""
    parser = subparsers.add_parser(
        "convert",
        help="write a stage in another form",
        description="Write a stage as NumPy arrays (.npz), for ParaView (.pvd with a .vtu a frame "
        "and body), as glTF (.glb) or as another kind of USD file (.usdc, .usda, .usd, .usdz).",
    )
    parser.add_argument("stage", metavar="STAGE", type=Path, help="the stage")
    parser.add_argument(
        "-o", "--out", metavar="FILE", type=Path, required=True, help="the new file"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(handler=run)


def run(args: argparse.Namespace) -> int:
    """Write the file and name it; return 0.

    Raises:
        SoftBodyError: the stage is none, or the file cannot be written.
    """
    with held_back():
        from warp_softbody.stage_exports import convert

    path = convert(args.stage, args.out)
    if args.json:
        say(json.dumps({"stage": str(args.stage), "file": str(path)}))
    else:
        say(f"converted {args.stage}: {path}")
    return 0
