"""`run SCENE --error 2%`: the stored settings of `tune` in place of the options not given."""

from __future__ import annotations

import argparse
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from warp_softbody.cli.arguments import unique
from warp_softbody.cli.output import note

if TYPE_CHECKING:
    from collections.abc import Mapping

    from warp_softbody.accuracy.analysis.tuning import Tuned
    from warp_softbody.accuracy.cases.settings import Settings
    from warp_softbody.scenes import ScenePlan

OPTIONS = {
    "time_step": None,
    "precision": "auto",
    "tangent": "warped",
    "elements": "linear",
    "cone": "smooth",
    "threads": 1,
    "controller": None,
}
"""Options of `run` that are knobs, with what they are where they are not given."""

OTHERS = {"level": 0, "newton_iterations": 1, "tolerance": None}
"""Knobs that `run` has no options for; those inside the engine are left to `tuned_engine`."""

SCENE_KNOBS = ("cells", "patches")
"""Knobs that are settings of the scene."""


def tuned_plan(args: argparse.Namespace) -> ScenePlan:
    """The scene that ``args`` ask for, with the stored settings where they ask for an error."""
    from warp_softbody import scenes
    from warp_softbody.world.refined_scene import refined_scene

    _take(args)
    plan = scenes.make(args.scene, unique(args.set, "--set"))
    return replace(plan, scene=refined_scene(plan.scene, args.level))


def tuned_engine(args: argparse.Namespace) -> AbstractContextManager[None]:
    """What the stored settings change inside the engine, once `tuned_plan` has been called."""
    if args.tuned is None:
        return nullcontext()
    from warp_softbody.accuracy.cases.settings import Settings
    from warp_softbody.accuracy.runs.inner_knobs import inner_knobs

    return inner_knobs(Settings.from_dict(args.tuned["settings"]))


def _take(args: argparse.Namespace) -> None:
    """Fill ``args`` with the stored settings for ``args.error``, and `OTHERS` in any case.

    Raises:
        InputError: there are none for that bound.
    """
    for name, value in OTHERS.items():
        setattr(args, name, value)
    args.tuned = None
    if args.error is None:
        return
    from warp_softbody import scenes
    from warp_softbody.accuracy.analysis.store import find
    from warp_softbody.accuracy.cases.table import case_of

    case = case_of(args.scene)
    values = scenes.make(args.scene, unique(args.set, "--set")).settings
    given = {key: values[key] for key, _ in args.set if key not in SCENE_KNOBS}
    tuned = find(args.scene, args.error, given)
    knobs: dict[str, Any] = tuned.settings.to_dict()
    knobs["controller"] = knobs["method"] if case.controlled else None
    for name, plain in {**OPTIONS, **OTHERS}.items():
        if getattr(args, name) == plain:
            setattr(args, name, knobs[name])
    for name in SCENE_KNOBS:
        if knobs[name] is not None and name not in dict(args.set):
            args.set = [*args.set, (name, str(knobs[name]))]
    args.tuned = {"bound": tuned.bound, "error": tuned.error, "settings": tuned.settings.to_dict()}
    if not (args.quiet or args.json):
        note(_reminder(tuned, case.default, given) + "\n")


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
