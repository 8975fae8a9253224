"""A scene that is run anew, or goes on, with another gravity, friction or control."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from warp_softbody.controllers.control_options import METHODS, ControlOptions
from warp_softbody.controllers.controller import Controller
from warp_softbody.controllers.inner_controllers import with_inner
from warp_softbody.engine.options import SimulationOptions
from warp_softbody.run.simulation import Simulation
from warp_softbody.world.scene import Scene

NO_CONTROL = "none"


@dataclass(frozen=True, kw_only=True)
class LivePlan:
    """A scene before it is run.

    Attributes:
        name: of the scene.
        scene: what there is.
        controller: what is wanted of it, fresh for one run; None for a passive body.
        options: of the engine.
        control: of the control solver; None where nothing drives the muscles.
        others: controllers of bodies beside the character, by their names, likewise.
    """

    name: str
    scene: Scene
    controller: Controller | None
    options: SimulationOptions
    control: ControlOptions | None
    others: Mapping[str, Controller] = field(default_factory=dict)


class LiveScene:
    """Makes the simulations of a page.

    Attributes:
        plan: of the run in hand.
        method: how muscles are driven, one of `methods`.
        methods: that there are.
        gravity: its size, m/s^2.
        friction: of the ground; None without one.
        steers: whether the controller, or one within it, can be steered.
        steering: shares forward, aside and turning as they were set in this run; None while the
            controller goes as it was made to.
    """

    def __init__(self, make: Callable[[], LivePlan], fps: float) -> None:
        """Of the plan that ``make`` makes, afresh for each run."""
        self._make = make
        self._fps = fps
        self.plan = make()
        scene = self.plan.scene
        driven = self.plan.controller is not None or bool(self.plan.others)
        muscular = driven and scene.whole.segment_count > 0
        self.methods = (*METHODS, NO_CONTROL) if muscular else (NO_CONTROL,)
        control = self.plan.control
        self.method = control.method if muscular and control is not None else NO_CONTROL
        self.gravity = float(np.linalg.norm(scene.gravity))
        self.friction = None if scene.ground is None else float(scene.ground.friction)
        self.steers = bool(self._steered())
        self.steering: tuple[float, float, float] | None = None

    def begun(self) -> Simulation:
        """A simulation from the start pose, as things are set now."""
        self.plan = self._make()
        self.steering = None
        return self._simulation(None)

    def steer(self, forward: float, aside: float, turning: float) -> None:
        """Let the controller go on like this, where it can be steered, and those within it."""
        for controller in self._steered():
            controller.steer_by(forward=forward, aside=aside, turning=turning)
            self.steering = (forward, aside, turning)

    def _steered(self) -> list[Any]:
        """What can be steered of the controller and of all within it, as walks of a sequence."""
        outer = self.plan.controller
        within = () if outer is None else with_inner(outer)
        return [own for own in within if hasattr(own, "steer_by")]

    def continued(self, simulation: Simulation) -> Simulation:
        """The same motion under what is set now."""
        return self._simulation(simulation)

    def _simulation(self, after: Simulation | None) -> Simulation:
        driven = self.method != NO_CONTROL
        control = self.plan.control or ControlOptions()
        chosen: Any = self.method if driven else control.method
        return Simulation(
            self._scene(),
            self.plan.controller if driven else None,
            others=self.plan.others if driven else None,
            options=self.plan.options,
            control_options=replace(control, method=chosen),
            fps=self._fps,
            name=self.plan.name,
            after=after,
        )

    def _scene(self) -> Scene:
        scene = self.plan.scene
        down = np.array(scene.gravity)
        size = float(np.linalg.norm(down))
        way = down / size if size > 0.0 else np.array((0.0, 0.0, -1.0))
        x, y, z = (self.gravity * way).tolist()
        if abs(self.gravity - size) > 1e-12:
            scene = replace(scene, gravity=(x, y, z))
        ground: Any = scene.ground
        if ground is not None and self.friction != ground.friction:
            scene = replace(scene, ground=replace(ground, friction=self.friction))
        return scene
