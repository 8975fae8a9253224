"""`warp-softbody new NAME.toml` writes a scene file to begin with."""

from __future__ import annotations

import argparse
import shlex
from pathlib import Path

from warp_softbody.cli.arguments import key_value, unique
from warp_softbody.cli.interruption import held_back
from warp_softbody.cli.output import say
from warp_softbody.errors import InputError, OutputError


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Register the subcommand; its handler is `run`."""
    parser = subparsers.add_parser(
        "new",
        help="write a scene file to begin with",
        description="Write a scene file (.toml) with a first scene and all that may be added to "
        "it, or one that is a shipped scene or that of a character's file (--from). "
        "`warp-softbody run NAME.toml` runs it.",
    )
    parser.add_argument("file", metavar="NAME.toml", type=Path, help="file to write")
    parser.add_argument(
        "--from", dest="origin", metavar="SCENE", help="a shipped scene, or a file NAME.char"
    )
    parser.add_argument(
        "--set",
        metavar="KEY=VALUE",
        type=key_value,
        action="append",
        default=[],
        help="a setting of that scene, such as push=0.3; may be repeated",
    )
    parser.add_argument(
        "--do",
        metavar="WHAT",
        help="what the character of a file, NAME.char, does: balance (default), walk, crawl, jump, "
        "hop or roll, or several in turn, as walk:2m,jump,balance",
    )
    parser.set_defaults(handler=run)


def run(args: argparse.Namespace) -> int:
    """Write the file; return 0.

    Raises:
        SoftBodyError: the file is there already, cannot be written, or there is no such scene.
    """
    with held_back():
        from warp_softbody import scene_files, scenes
        from warp_softbody.scene_files.first_scene import write_first_scene

    if args.file.exists():
        raise OutputError(f"{args.file} is there already; give another name")
    if args.origin is None:
        if args.set or args.do:
            flag = "--set" if args.set else "--do"
            raise InputError(f"{flag} goes with --from SCENE")
        write_first_scene(args.file)
    else:
        scene_files.write(
            args.file, scenes.make(args.origin, unique(args.set, "--set"), do=args.do)
        )
    say(f"{args.file}: `warp-softbody run {shlex.quote(str(args.file))}` runs it")
    return 0
