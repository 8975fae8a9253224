"""`run SCENE --error 2%` takes stored settings of `tune` for the options that are not given."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from warp_softbody.cli.arguments import unique
from warp_softbody.cli.output import note

if TYPE_CHECKING:
    from collections.abc import Mapping

    from warp_softbody.accuracy.analysis.tuning import Tuned
    from warp_softbody.accuracy.cases.settings import Settings


def stored_settings(args: argparse.Namespace) -> Tuned | None:
    """The stored settings for the error that ``args`` ask for; None where they ask for none.

    Raises:
        InputError: there are none for that bound.
    """
    if args.error is None:
        return None
    from warp_softbody import scenes
    from warp_softbody.accuracy.analysis.store import find
    from warp_softbody.accuracy.cases.settings import SCENE_KNOBS
    from warp_softbody.accuracy.cases.table import case_of

    case = case_of(args.scene)
    values = scenes.make(args.scene, unique(args.set, "--set")).settings
    given = {key: values[key] for key, _ in args.set if key not in SCENE_KNOBS}
    tuned = find(args.scene, args.error, given)
    if not (args.quiet or args.json):
        note(_reminder(tuned, case.default, given) + "\n")
    return tuned


def scene_settings(args: argparse.Namespace, tuned: Tuned | None) -> dict[str, str]:
    """The scene's settings of ``--set``, and those that are knobs of the stored ones."""
    chosen = unique(args.set, "--set")
    if tuned is not None:
        for name, value in tuned.settings.of_scene(tuned.scene).items():
            chosen.setdefault(name, str(value))
    return chosen


def _reminder(tuned: Tuned, default: Settings, given: Mapping[str, float]) -> str:
    """What was tuned, and how to tune what is run where that is something else."""
    made_with = "".join(f", {key}={value:g}" for key, value in tuned.given.items())
    text = (
        f"tuned for an error of {100.0 * tuned.bound:g} % in {tuned.seconds:g} s{made_with}: "
        f"{tuned.settings.differences(default)}"
    )
    if any(tuned.given.get(key) != value for key, value in given.items()):
        sets = "".join(f" --set {key}={value:g}" for key, value in given.items())
        text += (
            f"; `warp-softbody tune {tuned.scene} --error {100.0 * tuned.bound:g}%{sets}` tries "
            "these settings of the scene"
        )
    return text
