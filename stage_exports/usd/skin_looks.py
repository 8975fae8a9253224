"""A character's own skin has places in its textures, and a material for each of its parts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from pxr import Gf, Sdf, Tf, UsdGeom, UsdShade

from warp_softbody.body.skin import Skin, SkinMaterial
from warp_softbody.stage_exports import conventions
from warp_softbody.stage_exports.bodies import StagedBody
from warp_softbody.stage_exports.usd import usd_arrays as values

_TYPES = Sdf.ValueTypeNames


def texture_files(bodies: Sequence[StagedBody], folder: str) -> Mapping[str, bytes]:
    """Textures of all bodies by the path, from the stage's folder, at which they are kept."""
    return {
        f"{folder}/{_file_name(body, number)}": material.texture
        for body in bodies
        if body.character.skin is not None
        for number, material in enumerate(body.character.skin.materials)
        if material.texture
    }


def define_look(stage: Any, body: StagedBody, mesh: Any, skin: Skin, folder: str) -> None:
    """Author places in textures and bind the skin's materials, to parts where there are several."""
    if skin.textured:
        st = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(
            "st", _TYPES.TexCoord2fArray, UsdGeom.Tokens.faceVarying
        )
        st.Set(values.pairs(skin.texture_points))
        st.SetIndices(values.integers(skin.texture_faces))
    materials = [
        _define_material(stage, body, number, material, folder, textured=skin.textured)
        for number, material in enumerate(skin.materials)
    ]
    binding = UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim())
    used = np.unique(skin.face_materials)
    binding.Bind(materials[used[0]])
    if len(used) == 1:
        return
    for number in used.tolist():
        faces = values.integers(np.flatnonzero(skin.face_materials == number))
        name = materials[number].GetPrim().GetName()
        subset = binding.CreateMaterialBindSubset(name, faces, UsdGeom.Tokens.face)
        UsdShade.MaterialBindingAPI.Apply(subset.GetPrim()).Bind(materials[number])
    binding.SetMaterialBindSubsetsFamilyType(UsdGeom.Tokens.partition)


def _file_name(body: StagedBody, number: int) -> str:
    assert body.character.skin is not None
    ending = body.character.skin.materials[number].texture_ending
    return f"{body.character.name}_{number}{ending}"


def _define_material(
    stage: Any, body: StagedBody, number: int, given: SkinMaterial, folder: str, *, textured: bool
) -> Any:
    """A preview surface, whose colour comes out of the texture where there is one."""
    name = Tf.MakeValidIdentifier(f"{body.character.name}_{number}_{given.name}"[:200])
    path = f"{conventions.MATERIALS}/{name}"
    material = UsdShade.Material.Define(stage, path)
    surface = UsdShade.Shader.Define(stage, f"{path}/{conventions.SURFACE}")
    surface.CreateIdAttr("UsdPreviewSurface")
    color = surface.CreateInput("diffuseColor", _TYPES.Color3f)
    color.Set(Gf.Vec3f(*given.color))
    surface.CreateInput("roughness", _TYPES.Float).Set(given.roughness)
    if given.opacity < 1.0:
        surface.CreateInput("opacity", _TYPES.Float).Set(given.opacity)
    output = surface.CreateOutput("surface", _TYPES.Token)
    material.CreateSurfaceOutput().ConnectToSource(output)
    if given.texture and textured:
        reader = UsdShade.Shader.Define(stage, f"{path}/Coordinates")
        reader.CreateIdAttr("UsdPrimvarReader_float2")
        reader.CreateInput("varname", _TYPES.String).Set("st")
        picture = UsdShade.Shader.Define(stage, f"{path}/{conventions.TEXTURE}")
        picture.CreateIdAttr("UsdUVTexture")
        asset = Sdf.AssetPath(f"./{folder}/{_file_name(body, number)}")
        picture.CreateInput("file", _TYPES.Asset).Set(asset)
        picture.CreateInput("sourceColorSpace", _TYPES.Token).Set("sRGB")
        for wrap in ("wrapS", "wrapT"):
            picture.CreateInput(wrap, _TYPES.Token).Set("repeat")
        places = reader.CreateOutput("result", _TYPES.Float2)
        picture.CreateInput("st", _TYPES.Float2).ConnectToSource(places)
        color.ConnectToSource(picture.CreateOutput("rgb", _TYPES.Float3))
    return material
