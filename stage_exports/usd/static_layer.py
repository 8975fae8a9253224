"""The part of a take that does not move is written as one layer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from pxr import Sdf, Usd

from warp_softbody.stage_exports.bodies import StagedBody
from warp_softbody.stage_exports.camera import Camera
from warp_softbody.stage_exports.usd import surroundings
from warp_softbody.stage_exports.usd.grounds import define_ground
from warp_softbody.stage_exports.usd.physics import define_physics
from warp_softbody.stage_exports.usd.physics_names import Profile
from warp_softbody.stage_exports.usd.prims import define_body
from warp_softbody.world.scene import Scene


def static_layer(
    scene: Scene,
    bodies: Sequence[StagedBody],
    fps: float,
    metadata: Mapping[str, str | float],
    view: Camera,
    profile: Profile,
    textures: str,
) -> Any:
    """Everything of a stage but its time samples, with textures in a folder of that name.

    The layer is made first and the stage opened on it: a layer taken from a stage that goes out of
    scope is an expired handle, and touching that ends the interpreter.
    """
    layer = Sdf.Layer.CreateAnonymous(".usda")
    stage = Usd.Stage.Open(layer)
    surroundings.define_root(stage, bodies[0].character.name, fps, metadata)
    for body in bodies:
        define_body(stage, body, surroundings.define_skin_material(stage, body), textures)
    if scene.ground is not None:
        define_ground(stage, scene, scene.ground, surroundings.define_ground_materials(stage))
    surroundings.define_camera(stage, view)
    surroundings.define_lights(stage)
    define_physics(stage, scene, bodies, profile)
    return layer
