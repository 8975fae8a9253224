"""A `SceneFile` is what a file says: a scene, its controller, and how it is run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from types import MappingProxyType
from typing import Any

from warp_softbody.controllers.control_options import ControlOptions
from warp_softbody.engine.options import SimulationOptions
from warp_softbody.errors import InputError
from warp_softbody.inputs import checks, input_kinds
from warp_softbody.run.simulation import Simulation
from warp_softbody.scenes.plan import ScenePlan

ENDINGS = {
    "stage": (".usdc", ".usda", ".usd", ".usdz"),
    "movie": (".gif", ".mp4"),
    "picture": (".png",),
    "plots": (),
    "html": (".html",),
}
"""Of the files that a run can write; none of a folder. They are those of `stage_exports`, which is
not loaded to read a file."""

FILES = tuple(ENDINGS)
SIDES = {"low": 16, "high": 8192}
"""Pixels of a picture's sides, as `stage_exports` draws them."""


@dataclass(frozen=True, kw_only=True)
class RunOutput:
    """What a run of a scene file writes, beside the file or below it.

    Attributes:
        stage, movie, picture, plots, html: paths, as those of `warp-softbody run`; None for none.
        fps: frames per simulated second.
        camera: "follow", "still", or the place (x, y, z) m of one that looks at the start pose.
        size: (width, height), pixels of movie and picture.
    """

    stage: str | None = None
    movie: str | None = None
    picture: str | None = None
    plots: str | None = None
    html: str | None = None
    fps: float = 30.0
    camera: str | tuple[float, ...] = "follow"
    size: tuple[int, int] | None = None

    def __post_init__(self) -> None:
        """Refuse paths that lead out of the file's folder, and files that no run writes."""
        taken: dict[Path, str] = {}
        for name in FILES:
            given = getattr(self, name)
            if given is None:
                continue
            if not isinstance(given, str) or not given:
                checks.refuse(f"RunOutput.{name}", "a path beside the scene file", given)
            path = Path(input_kinds.text(f"RunOutput.{name}", given))
            if path.is_absolute() or ".." in path.parts:
                raise InputError(
                    f"RunOutput.{name} must stay in the folder of the scene file, "
                    f"but {given!r} leads out of it"
                )
            endings = ENDINGS[name]
            if endings and path.suffix.lower() not in endings:
                checks.refuse(f"RunOutput.{name}", f"a name in {' or '.join(endings)}", given)
            if path in taken:
                raise InputError(
                    f"RunOutput.{name} and RunOutput.{taken[path]} have the same name {given!r}"
                )
            taken[path] = name
        checks.keep(self, fps=checks.number("RunOutput.fps", self.fps, low=0.1, high=1e4))
        if isinstance(self.camera, str):
            checks.choice("RunOutput.camera", self.camera, ("follow", "still"))
        else:
            checks.keep(self, camera=checks.vector("RunOutput.camera", self.camera, unit="m"))
        if self.size is not None:
            sides = checks.vector("RunOutput.size", self.size, 2)
            size = tuple(checks.whole("RunOutput.size", side, **SIDES) for side in sides)
            checks.keep(self, size=size)
            if self.movie and self.movie.lower().endswith(".mp4") and any(s % 2 for s in size):
                raise InputError(f"RunOutput.size of an .mp4 must be even numbers, not {size}")


@dataclass(frozen=True, kw_only=True)
class SceneFile:
    """A scene out of a file, ready to be run.

    Attributes:
        plan: scene, controller, length and time step.
        options: of the engine, those that the file gives.
        control: of the control solver, likewise.
        output: what a run writes.
    """

    plan: ScenePlan
    options: Mapping[str, Any] = field(default_factory=dict)
    control: Mapping[str, Any] = field(default_factory=dict)
    output: RunOutput = field(default_factory=RunOutput)

    def __post_init__(self) -> None:
        """Refuse what cannot be run."""
        checks.instance("SceneFile.plan", self.plan, ScenePlan)
        checks.instance("SceneFile.output", self.output, RunOutput)
        for name, kind in (("options", SimulationOptions), ("control", ControlOptions)):
            given = input_kinds.mapping(f"SceneFile.{name}", getattr(self, name))
            known = [entry.name for entry in fields(kind)]
            for key in given:
                if key not in known:
                    wanted = f"options of {kind.__name__} by their names"
                    checks.refuse(f"SceneFile.{name}", wanted, key)
            kind(**given)
            checks.keep(self, **{name: MappingProxyType(dict(given))})

    def simulation(self) -> Simulation:
        """The scene in motion, with the controller of the plan, so for one run."""
        options = SimulationOptions(**{"time_step": self.plan.time_step, **self.options})
        controlled = self.plan.controller is not None or bool(self.plan.others)
        return Simulation(
            self.plan.scene,
            self.plan.controller,
            others=self.plan.others,
            options=options,
            control_options=ControlOptions(**self.control) if controlled else None,
            fps=self.output.fps,
            name=self.plan.name,
        )
