"""`warp-softbody check FILE` reads a scene file and says what is in it, without running it."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from warp_softbody.cli.interruption import held_back
from warp_softbody.cli.output import say

if TYPE_CHECKING:
    from warp_softbody.scene_files import SceneFile


SINGLE = {"pushes": "push", "handles": "handle", "fields": "field"}
"""What acts in a scene, and what one of them is called."""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Register the subcommand; its handler is `run`."""
    parser = subparsers.add_parser(
        "check",
        help="check a scene file",
        description="Read a scene file (.toml) and say what is in it; every key and value is "
        "checked, and the first that is wrong told with its line.",
    )
    parser.add_argument("file", metavar="FILE.toml", type=Path, help="scene file")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(handler=run)


def run(args: argparse.Namespace) -> int:
    """Check and describe the file; return 0.

    Raises:
        InputError: the sentence for the user, with file, line and field.
    """
    with held_back():
        from warp_softbody import scene_files

    facts = _facts(scene_files.read(args.file))
    say(json.dumps({"file": str(args.file), **facts}) if args.json else _as_text(facts))
    return 0


def _facts(file: SceneFile) -> dict[str, Any]:
    """What is told of a scene, in SI units."""
    plan, scene = file.plan, file.plan.scene
    moved = {handle.region for handle in scene.handles}
    return {
        "name": plan.name,
        "seconds": plan.seconds,
        "time_step": plan.time_step,
        "bodies": [
            {
                "name": body.name,
                "nodes": len(body.mesh.points),
                "tets": len(body.mesh.tets),
                "mass": float(body.node_masses.sum()),
                "segments": body.segment_count,
                "moved": body.name in moved,
            }
            for body in scene.characters
        ],
        "ground": None if scene.ground is None else type(scene.ground).__name__,
        "pushes": len(scene.pushes),
        "handles": len(scene.handles),
        "fields": len(scene.fields),
        "controllers": len(plan.others) + (plan.controller is not None),
        "controller": None if plan.controller is None else type(plan.controller).__name__,
    }


def _as_text(facts: dict[str, Any]) -> str:
    lines = [f"{facts['name']}: {facts['seconds']:g} s in steps of {facts['time_step']:.4g} s"]
    for body in facts["bodies"]:
        muscles = f", {body['segments']} muscle segments" if body["segments"] else ""
        lines.append(
            f"  {body['name']}: {body['nodes']} nodes, {body['tets']} tets, "
            f"{body['mass']:.3g} kg{muscles}{', moved along a path' if body['moved'] else ''}"
        )
    ground, controller = facts["ground"] or "no ground", facts["controller"] or "no controller"
    acts = ", ".join(_counted(facts[name], name) for name in SINGLE)
    return "\n".join([*lines, f"  {ground}, {acts}, {controller}"])


def _counted(count: int, plural: str) -> str:
    """A number and what is counted, a single one without the plural's ending."""
    return f"{count} {plural if count != 1 else SINGLE[plural]}"
