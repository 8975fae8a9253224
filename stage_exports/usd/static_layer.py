"""The part of a take that does not move is written as one layer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from pxr import Sdf, Usd

from warp_softbody.stage_exports.bodies import StagedBody
from warp_softbody.stage_exports.usd import surroundings
from warp_softbody.stage_exports.usd.grounds import define_ground
from warp_softbody.stage_exports.usd.prims import define_body
from warp_softbody.world.scene import Scene


def static_layer(
    scene: Scene,
    bodies: Sequence[StagedBody],
    fps: float,
    metadata: Mapping[str, str | float],
) -> Any:
    """Everything of a stage but its time samples.

    The layer is made first and the stage opened on it: a layer taken from a stage that goes out of
    scope is an expired handle, and touching that ends the interpreter.
    """
    layer = Sdf.Layer.CreateAnonymous(".usda")
    stage = Usd.Stage.Open(layer)
    surroundings.define_root(stage, fps, metadata)
    flesh = surroundings.define_material(stage, "Body", roughness=0.45)
    for body in bodies:
        define_body(stage, body, flesh)
    if scene.ground is not None:
        matt = surroundings.define_material(stage, "Ground", roughness=0.9)
        define_ground(stage, scene, scene.ground, matt)
    surroundings.define_camera(stage, scene)
    surroundings.define_lights(stage)
    return layer
