"""`warp-softbody picture STAGE -o FILE` draws a frame of a finished stage, or a sheet of them."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from warp_softbody.cli.arguments import camera, number, size, whole
from warp_softbody.cli.interruption import held_back
from warp_softbody.cli.output import say
from warp_softbody.errors import InputError


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Register the subcommand; its handler is `run`."""
    parser = subparsers.add_parser(
        "picture",
        help="draw a frame of a stage",
        description="Draw a frame of a finished stage as PNG, the last one by default, or frames "
        "at even intervals side by side.",
    )
    parser.add_argument("stage", metavar="STAGE", type=Path, help="the stage")
    parser.add_argument(
        "-o", "--out", metavar="F.png", type=Path, required=True, help="the picture"
    )
    parser.add_argument(
        "--frame", metavar="N", type=whole(0, 10**9), help="number of the frame, from 0"
    )
    parser.add_argument(
        "--time", metavar="S", type=number(0.0, 1e9, "s"), help="draw the frame nearest to it"
    )
    parser.add_argument(
        "--sheet", metavar="N", type=whole(1, 10_000), help="N frames side by side instead of one"
    )
    parser.add_argument("--size", metavar="WxH", type=size, help="pixels, of each frame in a sheet")
    parser.add_argument(
        "--camera", metavar="C", type=camera, default="follow", help="as of `run`, of one frame"
    )
    parser.add_argument(
        "--layers",
        metavar="L",
        type=lambda text: tuple(text.split(",")),
        default=("skin", "muscles", "ground"),
        help="which of skin,muscles,ground are drawn in one frame (all)",
    )
    parser.add_argument(
        "--transparent", action="store_true", help="leave ground and background out"
    )
    parser.add_argument(
        "--caption", action="store_true", help="tell the time, and the way along the ground"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(handler=run)


def run(args: argparse.Namespace) -> int:
    """Draw the picture and name it; return 0.

    Raises:
        SoftBodyError: the stage is none, or the picture cannot be drawn or written.
    """
    with held_back():
        from warp_softbody.stage_exports import draw_frame, draw_take

    chosen = {} if args.size is None else {"size": args.size}
    if args.sheet is not None:
        if args.frame is not None or args.time is not None or args.transparent:
            raise InputError("--sheet goes with --size and --caption alone")
        path = draw_take(args.out, args.stage, count=args.sheet, captions=args.caption, **chosen)
    else:
        path = draw_frame(
            args.out,
            args.stage,
            frame=args.frame,
            time=args.time,
            camera=args.camera,
            layers=args.layers,
            transparent=args.transparent,
            caption=args.caption,
            **chosen,
        )
    if args.json:
        say(json.dumps({"stage": str(args.stage), "file": str(path)}))
    else:
        say(f"drew {args.stage}: {path}")
    return 0
