"""Runs of scene files: what the command line leaves open is as the file says."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from warp_softbody.errors import InputError

if TYPE_CHECKING:
    from warp_softbody.scene_files import SceneFile

EXTENSION = ".toml"
FPS, CAMERA = 30.0, "follow"


def scene_file(args: argparse.Namespace) -> SceneFile | None:
    """The file that a command line runs, read anew, as a controller is for one run.

    None for a scene that ships.

    Raises:
        InputError: the file cannot be run, or goes without what the command line asks for.
    """
    if Path(args.scene).suffix.lower() != EXTENSION:
        return None
    from warp_softbody import scene_files

    for flag, given in (("--set", args.set), ("--error", args.error), ("--do", args.do)):
        if given:
            raise InputError(f"{flag} is for scenes that ship; {args.scene} says itself what it is")
    return scene_files.read(args.scene)


def take_output(args: argparse.Namespace) -> None:
    """Fill in the files, frames and camera that a run's command line leaves open."""
    file = scene_file(args)
    if file is not None:
        output, folder = file.output, Path(args.scene).parent
        for name in ("movie", "picture", "plots", "html"):
            given = getattr(output, name)
            if getattr(args, name) is None and given is not None:
                setattr(args, name, folder / given)
        if args.out is None and output.stage is not None:
            args.out = folder / output.stage
        for name in ("fps", "camera", "size"):
            if getattr(args, name) is None:
                setattr(args, name, getattr(output, name))
    args.fps = FPS if args.fps is None else args.fps
    args.camera = CAMERA if args.camera is None else args.camera


def refuse_one_name_twice(args: argparse.Namespace) -> None:
    """Refuse two files of a run in one place: the second would be refused after the simulation.

    Raises:
        InputError: with both flags.
    """
    taken: dict[Path, str] = {}
    for name in ("out", "picture", "movie", "plots", "html"):
        given = getattr(args, name)
        if given is None:
            continue
        place = Path(given).expanduser().resolve()
        if place in taken:
            raise InputError(f"--{name} and --{taken[place]} are both {str(given)!r}")
        taken[place] = name
