"""How far ahead the plans of a run look: the same time at every time step, in units of the body.

What muscles do reaches the ground within a step of 1/60 s, but hardly within a quarter of it. A
plan for so short a step moves whatever is nearest to its contacts, and another one in every step.
"""

from __future__ import annotations

from dataclasses import replace

from warp_softbody.controllers.body_units import BodyUnits
from warp_softbody.device.workspace import Workspace
from warp_softbody.engine.model import build_model
from warp_softbody.engine.state import Control, State
from warp_softbody.engine.stepper import Stepper
from warp_softbody.world.scene import Scene


def steps_ahead(horizon: float, scene: Scene, time_step: float) -> int:
    """The whole number of time steps, s, that a horizon in sqrt(L/g) comes nearest to; 1 or more.

    ``scene`` has the body whose length L is.
    """
    return max(1, round(horizon * BodyUnits.of_scene(scene).time / time_step))


class Lookahead:
    """The steppers that assemble what plans are made with, by how many steps these look ahead."""

    def __init__(self, stepper: Stepper) -> None:
        """Of plans for what a stepper steps."""
        self._own = stepper
        self._longer: dict[int, Stepper] = {}

    def stepper(self, steps: int) -> Stepper:
        """The stepper whose matrix is that of a time step as long as ``steps``."""
        if steps == 1:
            return self._own
        if steps not in self._longer:
            model = self._own.model
            options = replace(model.options, time_step=steps * model.options.time_step)
            work = self._own.workspace.shared("lookahead", (steps,), (), Workspace)
            self._longer[steps] = Stepper(
                build_model(model.scene, options, like=model), workspace=work
            )
        return self._longer[steps]

    def assemble(self, state: State, control: Control) -> None:
        """Make the matrices of longer steps from a state, and note that a plan is followed."""
        for stepper in self._longer.values():
            stepper.handled = getattr(control, "handled", None)
            stepper.assemble(state)
        if self._longer:
            self._own.follow_plan()
