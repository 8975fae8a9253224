"""Muscle-driven soft-body characters that move by physics.

The public names are loaded when they are first used, so that importing the package starts neither
Warp nor USD.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from warp_softbody import characters, controllers, scenes
    from warp_softbody.bodies import Body, placed
    from warp_softbody.bridge import Bridge, ControlProblem
    from warp_softbody.character import Character
    from warp_softbody.frame import ContactMode, ContactSample, Frame
    from warp_softbody.ground import Plane
    from warp_softbody.ground_friction import DirectionalFriction
    from warp_softbody.ground_heights import HeightField
    from warp_softbody.ground_triangles import TriangleGround
    from warp_softbody.material import Material
    from warp_softbody.mesh import TetMesh
    from warp_softbody.model import Model, build_model
    from warp_softbody.muscles import Fiber, FiberKind, MuscleGroup
    from warp_softbody.options import SimulationOptions
    from warp_softbody.scene import Push, Scene
    from warp_softbody.simulation import Simulation
    from warp_softbody.stage_exports import StageWriter
    from warp_softbody.state import Contacts, Control, State
    from warp_softbody.stepper import Stepper

__version__ = "0.1.0"

_MODULES = ("characters", "controllers", "scenes", "stage_exports")
_NAMES = {
    "Body": "bodies",
    "Bridge": "bridge",
    "Character": "character",
    "ContactMode": "frame",
    "ContactSample": "frame",
    "Contacts": "state",
    "Control": "state",
    "ControlProblem": "bridge",
    "DirectionalFriction": "ground_friction",
    "Fiber": "muscles",
    "FiberKind": "muscles",
    "Frame": "frame",
    "HeightField": "ground_heights",
    "Material": "material",
    "Model": "model",
    "MuscleGroup": "muscles",
    "Plane": "ground",
    "Push": "scene",
    "Scene": "scene",
    "Simulation": "simulation",
    "SimulationOptions": "options",
    "StageWriter": "stage_exports",
    "State": "state",
    "Stepper": "stepper",
    "TetMesh": "mesh",
    "TriangleGround": "ground_triangles",
    "build_model": "model",
    "placed": "bodies",
}

__all__ = [
    "Body",
    "Bridge",
    "Character",
    "ContactMode",
    "ContactSample",
    "Contacts",
    "Control",
    "ControlProblem",
    "DirectionalFriction",
    "Fiber",
    "FiberKind",
    "Frame",
    "HeightField",
    "Material",
    "Model",
    "MuscleGroup",
    "Plane",
    "Push",
    "Scene",
    "Simulation",
    "SimulationOptions",
    "StageWriter",
    "State",
    "Stepper",
    "TetMesh",
    "TriangleGround",
    "build_model",
    "characters",
    "controllers",
    "placed",
    "scenes",
]


def __getattr__(name: str) -> Any:
    """Load a public name on first use (PEP 562)."""
    if name in _MODULES:
        return import_module(f"{__name__}.{name}")
    if name in _NAMES:
        return getattr(import_module(f"{__name__}.{_NAMES[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    """Public names."""
    return sorted([*__all__, "__version__"])
