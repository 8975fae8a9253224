"""`warp-softbody list` prints the shipped scenes and the settings that each takes."""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict
from typing import TYPE_CHECKING

from warp_softbody.cli.output import say

if TYPE_CHECKING:
    from warp_softbody.scenes import SceneRecipe, Setting


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Register the subcommand; its handler is `run`."""
    parser = subparsers.add_parser(
        "list",
        help="list the scenes and their settings",
        description="List the scenes, and the settings that `run --set key=value` takes.",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(handler=run)


def run(args: argparse.Namespace) -> int:
    """Print every scene; return 0."""
    from warp_softbody import scenes

    recipes = [scenes.recipe(name) for name in scenes.names()]
    if args.json:
        say(json.dumps({"scenes": [_as_dict(recipe) for recipe in recipes]}))
    else:
        say("\n".join(_as_text(recipe) for recipe in recipes))
    return 0


def _as_dict(recipe: SceneRecipe) -> dict[str, object]:
    return {
        "name": recipe.name,
        "description": recipe.description,
        "seconds": recipe.seconds,
        "time_step": recipe.time_step,
        "settings": [asdict(setting) for setting in recipe.settings],
    }


def _as_text(recipe: SceneRecipe) -> str:
    lines = [f"{recipe.name:<12} {recipe.description} ({recipe.seconds:g} s)"]
    return "\n".join(lines + [_setting_line(setting) for setting in recipe.settings])


def _setting_line(setting: Setting) -> str:
    given = f"{setting.name}={setting.default:g}"
    unit = f" {setting.unit}" if setting.unit else ""
    return f"    {given:<18} {setting.help} ({setting.low:g} to {setting.high:g}{unit})"
