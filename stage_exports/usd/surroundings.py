"""Root metadata, ground, camera, lights and materials of a stage are defined here."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from pxr import Gf, Kind, Sdf, Usd, UsdGeom, UsdLux, UsdShade

from warp_softbody.stage_exports import conventions, palette
from warp_softbody.stage_exports.bodies import StagedBody
from warp_softbody.stage_exports.camera import Camera
from warp_softbody.stage_exports.usd import usd_arrays as values

Color = tuple[float, float, float]

ASPECT = 4.0 / 3.0
# Horizontal aperture of a 35 mm film camera, 20.955 mm, in tenths of a metre as USD counts it.
_APERTURE = 0.20955

_CLEAR = 0.4
"""Opacity of a body with muscles, which are seen inside it."""


def define_root(stage: Any, name: str, fps: float, metadata: Mapping[str, str | float]) -> None:
    """Units, clock and the root of the model hierarchy."""
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    stage.SetTimeCodesPerSecond(fps)
    stage.SetFramesPerSecond(fps)
    world = UsdGeom.Xform.Define(stage, conventions.WORLD)
    model = Usd.ModelAPI(world)
    model.SetKind(Kind.Tokens.assembly)
    model.SetAssetName(name)
    stage.SetDefaultPrim(world.GetPrim())
    if metadata:
        stage.GetRootLayer().customLayerData = {conventions.METADATA_KEY: dict(metadata)}


def define_material(
    stage: Any, name: str, color: Color, *, roughness: float, opacity: float = 1.0
) -> Any:
    """A preview surface of one colour: few viewers take a colour out of a primvar."""
    UsdGeom.Scope.Define(stage, conventions.MATERIALS)
    material = UsdShade.Material.Define(stage, f"{conventions.MATERIALS}/{name}")
    surface = UsdShade.Shader.Define(stage, material.GetPath().AppendChild("Surface"))
    surface.CreateIdAttr("UsdPreviewSurface")
    surface.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(*color))
    surface.CreateInput("roughness", Sdf.ValueTypeNames.Float).Set(roughness)
    if opacity < 1.0:
        surface.CreateInput("opacity", Sdf.ValueTypeNames.Float).Set(opacity)
        # what is seen through a body is seen where it is
        surface.CreateInput("ior", Sdf.ValueTypeNames.Float).Set(1.0)
    output = surface.CreateOutput("surface", Sdf.ValueTypeNames.Token)
    material.CreateSurfaceOutput().ConnectToSource(output)
    return material


def define_skin_material(stage: Any, body: StagedBody) -> Any:
    """The material of a body's skin, through which its muscles are seen."""
    character = body.character
    opacity = _CLEAR if character.segment_count else 1.0
    return define_material(stage, character.name, character.color, roughness=0.45, opacity=opacity)


def define_ground_materials(stage: Any) -> tuple[Any, Any]:
    """Two shades, in which a ground is laid out so that motion and distance are seen on it."""
    light, dark = (
        define_material(stage, name, color, roughness=0.9)
        for name, color in (("Ground", palette.GROUND), ("GroundDark", palette.GROUND_DARK))
    )
    return light, dark


def define_camera(stage: Any, view: Camera) -> None:
    """The camera of the pictures, as a USD camera; frames move it."""
    camera = UsdGeom.Camera.Define(stage, conventions.CAMERA)
    camera.AddTranslateOp().Set(values.place(view))
    camera.AddTransformOp().Set(values.turn(view))
    vertical = _APERTURE / ASPECT
    slope = float(np.tan(np.radians(view.vertical_field) / 2.0))
    camera.CreateHorizontalApertureAttr(_APERTURE)
    camera.CreateVerticalApertureAttr(vertical)
    camera.CreateFocalLengthAttr(vertical / (2.0 * slope))
    camera.CreateClippingRangeAttr(Gf.Vec2f(0.01, 1000.0))


def define_lights(stage: Any) -> None:
    """A sun from behind the camera's left shoulder and an even sky.

    Without `normalize` some renderers multiply the sun's intensity by its tiny solid angle, others
    do not; with it they agree.
    """
    sun = UsdLux.DistantLight.Define(stage, conventions.LIGHT)
    sun.CreateIntensityAttr(2.5)
    sun.CreateAngleAttr(3.0)
    sun.CreateNormalizeAttr(True)
    sun.AddRotateXYZOp().Set(Gf.Vec3f(38.0, -24.0, 0.0))
    sky = UsdLux.DomeLight.Define(stage, conventions.SKY)
    sky.CreateIntensityAttr(0.6)
    # without one of its own, some programs take black
    sky.CreateColorAttr(Gf.Vec3f(1.0, 1.0, 1.0))
