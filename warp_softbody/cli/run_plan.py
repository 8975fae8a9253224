"""The arguments of a `run` command are turned into a scene, its options and its controller."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from warp_softbody.cli.option_flags import given_options
from warp_softbody.cli.scene_file_runs import scene_file
from warp_softbody.cli.tuned_options import scene_settings, stored_settings
from warp_softbody.controllers.control_options import ControlOptions
from warp_softbody.engine.options import SimulationOptions
from warp_softbody.errors import InputError
from warp_softbody.inputs.option_fields import recorded

if TYPE_CHECKING:
    from warp_softbody.accuracy.analysis.tuning import Tuned
    from warp_softbody.scenes import ScenePlan


@dataclass(frozen=True, kw_only=True)
class RunPlan:
    """A run before it begins.

    Attributes:
        scene: with the settings that were given.
        options: of the engine, with the precision that suits the scene.
        control: options of the control solver; None where nothing drives the muscles.
        seconds: length, s.
        tuned: the stored settings that it takes, or None.
    """

    scene: ScenePlan
    options: SimulationOptions
    control: ControlOptions | None
    seconds: float
    tuned: Tuned | None

    @property
    def controller(self) -> str:
        """How the muscles are driven: "qpcc", "static" or "none"."""
        return "none" if self.control is None else self.control.method

    def recorded(self, options: SimulationOptions, *, motion_only: bool = False) -> dict[str, Any]:
        """What is told of ``options`` and of the control solver's, by name."""
        control = self.control
        own = {} if control is None else recorded(control, motion_only=motion_only)
        told = {**recorded(options, motion_only=motion_only), **own}
        return {"controller": self.controller, **told}


def plan_run(args: argparse.Namespace) -> RunPlan:
    """What the command line asks for; the scene and the stored settings fill what it leaves open.

    Raises:
        InputError: it asks for what does not go together, or for stored settings that are not.
    """
    from warp_softbody import scenes
    from warp_softbody.engine.option_choice import with_choices
    from warp_softbody.world.refined_scene import refined_scene

    file = scene_file(args)
    tuned = stored_settings(args) if file is None else None
    if file is not None:
        plan = file.plan
    else:
        plan = scenes.make(args.scene, scene_settings(args, tuned), do=args.do)
    plan = replace(
        plan, scene=refined_scene(plan.scene, tuned.settings.refinements if tuned else 0)
    )
    seconds = plan.seconds if args.seconds is None else args.seconds
    if seconds <= 0.5 / args.fps:
        raise InputError(f"--seconds {seconds:g} is less than half a frame at --fps {args.fps:g}")
    stored = tuned.settings.chosen(SimulationOptions) if tuned else {}
    own = {} if file is None else file.options
    chosen = {"time_step": plan.time_step, **own, **stored}
    chosen |= given_options(args, SimulationOptions)
    return RunPlan(
        scene=plan,
        options=with_choices(SimulationOptions(**chosen), plan.scene),
        control=_control(args, plan, tuned, {} if file is None else file.control),
        seconds=seconds,
        tuned=tuned,
    )


def _control(
    args: argparse.Namespace, plan: ScenePlan, tuned: Tuned | None, own: Mapping[str, Any]
) -> ControlOptions | None:
    given = given_options(args, ControlOptions)
    controlled = plan.controller is not None or bool(plan.others)
    if not controlled and args.controller not in (None, "none"):
        raise InputError(
            f"--controller {args.controller}: scene {plan.name!r} has no controller, "
            "its body is passive"
        )
    if not controlled or args.controller == "none":
        if given:
            flag = "--" + next(iter(given)).replace("_", "-")
            raise InputError(f"{flag} is for a controller, and nothing drives {plan.name!r} here")
        return None
    stored = tuned.settings.chosen(ControlOptions) if tuned else {}
    method = {} if args.controller is None else {"method": args.controller}
    return ControlOptions(**{**own, **stored, **method, **given})
