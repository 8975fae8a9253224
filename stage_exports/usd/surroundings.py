"""Root metadata, ground, camera, lights and materials of a stage are defined here."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from pxr import Gf, Kind, Sdf, Usd, UsdGeom, UsdLux, UsdShade

from warp_softbody.stage_exports import conventions
from warp_softbody.stage_exports.camera import Camera, start_box
from warp_softbody.world.scene import Scene

ASPECT = 4.0 / 3.0
# Horizontal aperture of a 35 mm film camera, in tenths of a scene unit as USD counts it.
_APERTURE = 20.955


def define_root(stage: Any, fps: float, metadata: Mapping[str, str | float]) -> None:
    """Units, clock and the root of the model hierarchy."""
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    stage.SetTimeCodesPerSecond(fps)
    stage.SetFramesPerSecond(fps)
    world = UsdGeom.Xform.Define(stage, conventions.WORLD)
    Usd.ModelAPI(world).SetKind(Kind.Tokens.assembly)
    stage.SetDefaultPrim(world.GetPrim())
    if metadata:
        stage.GetRootLayer().customLayerData = {conventions.METADATA_KEY: dict(metadata)}


def define_material(stage: Any, name: str, roughness: float) -> Any:
    """A preview surface that takes its colour from displayColor."""
    UsdGeom.Scope.Define(stage, conventions.MATERIALS)
    material = UsdShade.Material.Define(stage, f"{conventions.MATERIALS}/{name}")
    reader = UsdShade.Shader.Define(stage, material.GetPath().AppendChild("Color"))
    reader.CreateIdAttr("UsdPrimvarReader_float3")
    reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set("displayColor")
    color = reader.CreateOutput("result", Sdf.ValueTypeNames.Float3)
    surface = UsdShade.Shader.Define(stage, material.GetPath().AppendChild("Surface"))
    surface.CreateIdAttr("UsdPreviewSurface")
    surface.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).ConnectToSource(color)
    surface.CreateInput("roughness", Sdf.ValueTypeNames.Float).Set(roughness)
    output = surface.CreateOutput("surface", Sdf.ValueTypeNames.Token)
    material.CreateSurfaceOutput().ConnectToSource(output)
    return material


def define_camera(stage: Any, scene: Scene) -> None:
    """The camera of the pictures, as a USD camera."""
    view = Camera.framing(*start_box(np.asarray(scene.whole.mesh.points)), aspect=ASPECT)
    right, up = view.axes
    matrix = np.eye(4)
    matrix[:3, :3] = right, up, -view.forward
    matrix[3, :3] = view.eye
    camera = UsdGeom.Camera.Define(stage, conventions.CAMERA)
    camera.AddTransformOp().Set(Gf.Matrix4d(*matrix.reshape(-1).tolist()))
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
