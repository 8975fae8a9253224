"""One way in which a motion is run otherwise than shipped, its gains untouched."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

from benchmarks.gains.cases import changed_character
from benchmarks.robustness.other_meshes import meshes_of
from benchmarks.robustness.turned_world import turned_plan, turned_pushes
from warp_softbody import scenes
from warp_softbody.controllers.control_options import ControlOptions
from warp_softbody.engine.options import SimulationOptions
from warp_softbody.run.simulation import Simulation
from warp_softbody.scenes import ScenePlan

FPS = 60.0
"""Frames a second of a stage; fewer where a step is longer than a frame."""

Make = Callable[[str, Mapping[str, float]], ScenePlan]
"""A scene by its name and settings, as `scenes.make` makes it."""


@dataclass(frozen=True, kw_only=True)
class Variation:
    """Factors on a scene's own numbers, another mesh, options of the engine, or a turn.

    Attributes:
        name: of the column.
        friction, stiffness, time_step: factors.
        edges: of the mesh, over those of the shipped one; another is meshed anew.
        levels: how often every tet is cut into eight.
        turn: degrees by which the world is turned about the vertical.
        side: degrees by which the pushes alone are turned about it.
        settings: of the scene.
        options: of `SimulationOptions`, beside the time step.
        control: of `ControlOptions`.
    """

    name: str
    friction: float = 1.0
    stiffness: float = 1.0
    time_step: float = 1.0
    edges: float = 1.0
    levels: int = 0
    turn: float = 0.0
    side: float = 0.0
    settings: Mapping[str, float] = field(default_factory=dict)
    options: Mapping[str, Any] = field(default_factory=dict)
    control: Mapping[str, Any] = field(default_factory=dict)

    def plan(self, scene: str, meshes: Path, make: Make = scenes.make) -> ScenePlan:
        """The scene so changed; the folder has the other meshes."""
        from warp_softbody.world.refined_scene import refined_scene

        friction = make(scene, self.settings).settings["friction"] * self.friction
        with meshes_of(meshes, self.edges):
            plan = make(scene, {**self.settings, "friction": friction})
        modulus = plan.scene.character.material.young_modulus * self.stiffness
        plan = _with_material(plan, "young_modulus", modulus)
        plan = replace(plan, scene=refined_scene(plan.scene, self.levels))
        plan = replace(plan, scene=turned_pushes(plan.scene, self.side)) if self.side else plan
        plan = turned_plan(plan, self.turn) if self.turn else plan
        return replace(plan, time_step=plan.time_step * self.time_step)

    def simulation(self, plan: ScenePlan) -> Simulation:
        """The plan ready to be run.

        Raises:
            InputError: the engine refuses this combination.
        """
        options, fps = self.settings_of(plan)
        control = ControlOptions(**self.control)
        return Simulation(
            plan.scene, plan.controller, options=options, control_options=control, fps=fps
        )

    def settings_of(self, plan: ScenePlan) -> tuple[SimulationOptions, float]:
        """Options of the engine and frames a second with which a plan is run."""
        options = SimulationOptions(**{**self.options, "time_step": plan.time_step})
        return options, min(FPS, 1.0 / plan.time_step)

    def cost(self, scene: str) -> float:
        """About how many tets are assembled in all steps; only their order matters."""
        plan = scenes.make(scene)
        steps = plan.seconds / (plan.time_step * self.time_step)
        tets = len(plan.scene.character.mesh.tets) * 8.0**self.levels / self.edges**3
        return float(steps * tets * self.options.get("newton_iterations", 1))

    def to_dict(self) -> dict[str, Any]:
        """Plain values that say what it does, without its name."""
        values = asdict(self)
        del values["name"]
        return values


def _with_material(plan: ScenePlan, name: str, value: Any) -> ScenePlan:
    character = changed_character(plan.scene.character, f"material.{name}", value)
    return replace(plan, scene=replace(plan.scene, character=character))
