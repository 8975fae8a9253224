"""Muscle-driven soft-body characters that move by physics.

The public names are loaded when they are first used, so that importing the package starts neither
Warp nor USD.
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from warp_softbody import characters, controllers, live, scene_files, scenes
    from warp_softbody.body import muscle_paths as muscles
    from warp_softbody.body import region_masks as regions
    from warp_softbody.body.character import Character
    from warp_softbody.body.directional_friction import DirectionalFriction
    from warp_softbody.body.material import Material
    from warp_softbody.body.mesh import TetMesh
    from warp_softbody.body.muscles import Fiber, FiberKind, MuscleGroup
    from warp_softbody.body.skin import Skin, SkinMaterial
    from warp_softbody.contact_mode import ContactMode
    from warp_softbody.controllers.control_options import ControlOptions
    from warp_softbody.engine.model import Model, build_model
    from warp_softbody.engine.options import SimulationOptions
    from warp_softbody.engine.reduced_dynamics import Bridge, ControlProblem, ReducedDynamics
    from warp_softbody.engine.state import Contacts, Control, State
    from warp_softbody.engine.stepper import Stepper
    from warp_softbody.environment.environment import Environment
    from warp_softbody.environment.vector_environment import VectorEnvironment
    from warp_softbody.run.batch import Batch
    from warp_softbody.run.batch_member import BatchMember
    from warp_softbody.run.goal_report import GoalReport
    from warp_softbody.run.muscle_authority import Authority, muscle_authority
    from warp_softbody.run.recorder import Recorder
    from warp_softbody.run.simulation import Simulation
    from warp_softbody.stage_exports import StageWriter
    from warp_softbody.world.force_fields import (
        DragField,
        ForceField,
        RadialField,
        UniformField,
    )
    from warp_softbody.world.frame import ContactSample, Frame
    from warp_softbody.world.friction_map import FrictionMap
    from warp_softbody.world.ground import Plane
    from warp_softbody.world.handles import Handle
    from warp_softbody.world.height_field import HeightField
    from warp_softbody.world.joined_bodies import Body, placed
    from warp_softbody.world.motion_path import MotionPath
    from warp_softbody.world.movers import mover
    from warp_softbody.world.scene import Push, Scene
    from warp_softbody.world.triangle_ground import TriangleGround

__version__ = "0.1.0"

_MODULES = ("characters", "controllers", "live", "scene_files", "scenes", "stage_exports")
_PLACES = {"muscles": "body.muscle_paths", "regions": "body.region_masks"}
"""Modules that are found under another name."""

_NAMES = {
    "Authority": "run.muscle_authority",
    "Batch": "run.batch",
    "BatchMember": "run.batch_member",
    "Body": "world.joined_bodies",
    "Bridge": "engine.reduced_dynamics",
    "Character": "body.character",
    "ContactMode": "contact_mode",
    "ContactSample": "world.frame",
    "Contacts": "engine.state",
    "Control": "engine.state",
    "ControlOptions": "controllers.control_options",
    "ControlProblem": "engine.reduced_dynamics",
    "DirectionalFriction": "body.directional_friction",
    "DragField": "world.force_fields",
    "Environment": "environment.environment",
    "Fiber": "body.muscles",
    "FiberKind": "body.muscles",
    "ForceField": "world.force_fields",
    "Frame": "world.frame",
    "FrictionMap": "world.friction_map",
    "Handle": "world.handles",
    "GoalReport": "run.goal_report",
    "HeightField": "world.height_field",
    "Material": "body.material",
    "Model": "engine.model",
    "MotionPath": "world.motion_path",
    "MuscleGroup": "body.muscles",
    "Plane": "world.ground",
    "Push": "world.scene",
    "RadialField": "world.force_fields",
    "Recorder": "run.recorder",
    "ReducedDynamics": "engine.reduced_dynamics",
    "Scene": "world.scene",
    "Simulation": "run.simulation",
    "SimulationOptions": "engine.options",
    "Skin": "body.skin",
    "SkinMaterial": "body.skin",
    "StageWriter": "stage_exports",
    "State": "engine.state",
    "Stepper": "engine.stepper",
    "TetMesh": "body.mesh",
    "TriangleGround": "world.triangle_ground",
    "UniformField": "world.force_fields",
    "VectorEnvironment": "environment.vector_environment",
    "build_model": "engine.model",
    "mover": "world.movers",
    "muscle_authority": "run.muscle_authority",
    "placed": "world.joined_bodies",
}

__all__ = [
    "Authority",
    "Batch",
    "BatchMember",
    "Body",
    "Bridge",
    "Character",
    "ContactMode",
    "ContactSample",
    "Contacts",
    "Control",
    "ControlOptions",
    "ControlProblem",
    "DirectionalFriction",
    "DragField",
    "Environment",
    "Fiber",
    "FiberKind",
    "ForceField",
    "Frame",
    "FrictionMap",
    "GoalReport",
    "Handle",
    "HeightField",
    "Material",
    "Model",
    "MotionPath",
    "MuscleGroup",
    "Plane",
    "Push",
    "RadialField",
    "Recorder",
    "ReducedDynamics",
    "Scene",
    "Simulation",
    "SimulationOptions",
    "Skin",
    "SkinMaterial",
    "StageWriter",
    "State",
    "Stepper",
    "TetMesh",
    "TriangleGround",
    "UniformField",
    "VectorEnvironment",
    "build_model",
    "characters",
    "controllers",
    "live",
    "mover",
    "muscle_authority",
    "muscles",
    "placed",
    "quiet",
    "regions",
    "scene_files",
    "scenes",
]


def read_usd_surfaces() -> None:
    """Let `Character.from_surface` read USD files, whose libraries are loaded when one is read."""
    from warp_softbody.body import other_surfaces
    from warp_softbody.body.skin import USD

    def read(path: Path) -> Skin:
        from warp_softbody.stage_exports import read_skin

        return read_skin(path)

    other_surfaces.READERS.update(dict.fromkeys(USD, read))


def quiet(silent: bool = True) -> None:
    """Let Warp tell errors alone; or, not ``silent``, all that it loads and compiles.

    Without it Warp's warnings are told, and no lines about modules.
    """
    from warp_softbody.device.warp_runtime import set_quiet
    from warp_softbody.inputs import checks

    set_quiet(silent=checks.truth("silent of quiet", silent))


def __getattr__(name: str) -> Any:
    """Load a public name on first use (PEP 562)."""
    if name in _MODULES:
        return import_module(f"{__name__}.{name}")
    if name in _PLACES:
        return import_module(f"{__name__}.{_PLACES[name]}")
    if _NAMES.get(name, "").startswith("environment."):
        from warp_softbody.inputs.extras import require_package

        require_package("gymnasium", "environments", "learn")
    if name == "Character":
        read_usd_surfaces()
    if name in _NAMES:
        return getattr(import_module(f"{__name__}.{_NAMES[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    """Public names."""
    return sorted([*__all__, "__version__"])
