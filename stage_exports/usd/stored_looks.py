"""What a stage holds of a character's own skin: places in textures, and materials."""

from __future__ import annotations

from typing import Any, TypedDict

import numpy as np
import numpy.typing as npt

from warp_softbody.errors import InputError
from warp_softbody.stage_exports import conventions
from warp_softbody.stage_exports.usd import watchdog
from warp_softbody.stage_exports.usd.textures import texture

Array = npt.NDArray[Any]

_INPUTS = {"color": "diffuseColor", "roughness": "roughness", "opacity": "opacity"}
"""Inputs of a surface's shader by the fields of `SkinMaterial`."""


class StoredLook(TypedDict):
    """An own skin's places in textures, if any, fields of its materials, and each face's."""

    texture_points: Array | None
    texture_faces: Array | None
    materials: list[dict[str, Any]]
    face_materials: Array


def stored_look(stage: Any, skin: Any, path: str) -> StoredLook | None:
    """What a skin with materials of its own has of them; None where it has its body's alone."""
    parts = [child for child in skin.GetChildren() if child.GetTypeName() == "GeomSubset"]
    bound = [_material_of(stage, part) for part in parts or [skin]]
    textured = skin.HasAttribute(conventions.TEXTURE_PLACES)
    own = skin.GetParent().GetName()
    if any(one is None for one in bound) or (not textured and bound[0].GetName() == own):
        return None
    faces = len(stored_value(skin, "faceVertexIndices")) // 3
    owners = np.zeros(faces, dtype=np.int32)
    for number, part in enumerate(parts):
        owners[stored_value(part, "indices")] = number
    return StoredLook(
        texture_points=stored_value(skin, conventions.TEXTURE_PLACES) if textured else None,
        texture_faces=stored_value(skin, conventions.TEXTURE_CORNERS) if textured else None,
        materials=[_look_of(material, path) for material in bound],
        face_materials=owners,
    )


def _material_of(stage: Any, prim: Any) -> Any:
    targets = prim.GetRelationship("material:binding").GetTargets()
    return stage.GetPrimAtPath(targets[0]) if targets else None


def _look_of(material: Any, path: str) -> dict[str, Any]:
    """Fields of a `SkinMaterial` by name."""
    look: dict[str, Any] = {"name": material.GetName()}
    surface = material.GetChild(conventions.SURFACE)
    for field, name in _INPUTS.items():
        attribute = surface.GetAttribute(f"inputs:{name}") if surface else None
        if attribute and attribute.Get() is not None:
            value = np.asarray(attribute.Get(), dtype=np.float64)
            look[field] = tuple(value.tolist()) if value.ndim else float(value)
    picture = material.GetChild(conventions.TEXTURE)
    asset = picture.GetAttribute("inputs:file").Get() if picture else None
    look["texture"] = texture(path, asset.path) if asset else b""
    return look


def stored_value(prim: Any, name: str, code: float | None = None) -> Array:
    """A copy of a value; what USD hands out may be a view of the file."""
    watchdog.feed()
    attribute = prim.GetAttribute(name)
    value = attribute.Get() if code is None else attribute.Get(code)
    if value is None:
        raise InputError(f"{prim.GetPath()} has no value of {name!r}")
    array = np.array(value)
    if array.dtype.kind not in "fiu":
        raise InputError(f"{prim.GetPath()} has a value of {name!r} that is no number")
    return array
