"""The meshes of any USD file as one surface with materials, to be a character's skin."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from pxr import Usd, UsdGeom, UsdShade

from warp_softbody.body.skin_formats.contents import NO_TEXTURE, SkinContents
from warp_softbody.errors import InputError
from warp_softbody.stage_exports.usd import watchdog
from warp_softbody.stage_exports.usd.extraction import open_stage
from warp_softbody.stage_exports.usd.textures import LARGEST, texture

Numbers = npt.NDArray[Any]
_COLOR = ("diffuseColor", "roughness", "opacity")
_NAMES = {"diffuseColor": "color"}


def extract_skin(path: str) -> tuple[Any, ...]:
    """Fields of `SkinContents`: all meshes that are drawn, where they are at first, in m, z up.

    Raises:
        InputError: it is no USD file, or holds no mesh.
    """
    stage = open_stage(path)
    turn = _to_metres_and_z(stage)
    cache = UsdGeom.XformCache(Usd.TimeCode.EarliestTime())
    found = _Collected(path)
    for prim in stage.Traverse():
        watchdog.feed()
        if prim.IsA(UsdGeom.Mesh) and UsdGeom.Imageable(prim).ComputePurpose() != "guide":
            matrix = np.array(cache.GetLocalToWorldTransform(prim)) @ turn
            found.add(UsdGeom.Mesh(prim), matrix)
    if not found.faces:
        raise InputError(f"{path!r} holds no mesh")
    return tuple(found.contents())


def _to_metres_and_z(stage: Any) -> Numbers:
    """(4, 4) for rows: the stage's unit becomes the metre, and its up axis z."""
    matrix = np.eye(4)
    if UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.y:
        matrix[:3, :3] = ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, -1.0, 0.0))
    matrix[:3, :3] *= UsdGeom.GetStageMetersPerUnit(stage)
    return matrix


class _Collected:
    """Meshes one after the other."""

    def __init__(self, path: str) -> None:
        self._path = path
        self._points: list[Numbers] = []
        self.faces: list[Numbers] = []
        self._places: list[Numbers | None] = []
        self._owners: list[Numbers] = []
        self._materials: dict[str, dict[str, Any]] = {}

    def add(self, mesh: Any, matrix: Numbers) -> None:
        time = Usd.TimeCode.EarliestTime()
        points = np.array(mesh.GetPointsAttr().Get(time), dtype=np.float64).reshape(-1, 3)
        counts = np.array(mesh.GetFaceVertexCountsAttr().Get(time) or [], dtype=np.int64)
        indices = np.array(mesh.GetFaceVertexIndicesAttr().Get(time) or [], dtype=np.int64)
        if not len(counts) or counts.min() < 3 or counts.sum() != len(indices):
            raise InputError(f"{self._path!r}: mesh {mesh.GetPath()} has faces that are none")
        if indices.min() < 0 or indices.max() >= len(points):
            raise InputError(f"{self._path!r}: mesh {mesh.GetPath()} names a point that is none")
        corners, polygons = _fans(counts)
        if mesh.GetOrientationAttr().Get() == UsdGeom.Tokens.leftHanded:
            corners = corners[:, ::-1]
        if np.linalg.det(matrix[:3, :3]) < 0.0:
            corners = corners[:, ::-1]
        start = sum(len(one) for one in self._points)
        self._points.append(points @ matrix[:3, :3] + matrix[3, :3])
        self.faces.append(indices[corners] + start)
        self._places.append(_places(mesh, indices, corners))
        self._owners.append(self._materials_of(mesh, len(counts))[polygons])

    def contents(self) -> SkinContents:
        texture_points, texture_faces = NO_TEXTURE
        places = [one for one in self._places if one is not None]
        if len(places) == len(self._places):
            texture_points = np.concatenate(places).reshape(-1, 2)
            texture_faces = np.arange(len(texture_points)).reshape(-1, 3)
        return SkinContents(
            np.concatenate(self._points),
            np.concatenate(self.faces),
            texture_points,
            texture_faces,
            list(self._materials.values()),
            np.concatenate(self._owners),
        )

    def _materials_of(self, mesh: Any, faces: int) -> Numbers:
        """The number of each polygon's material."""
        owners = np.full(faces, self._number(mesh.GetPrim()))
        for subset in UsdShade.MaterialBindingAPI(mesh).GetMaterialBindSubsets():
            chosen = np.array(subset.GetIndicesAttr().Get() or [], dtype=np.int64)
            owners[chosen] = self._number(subset.GetPrim())
        return owners

    def _number(self, prim: Any) -> int:
        material, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()
        name = str(material.GetPath()) if material else ""
        if name not in self._materials:
            self._materials[name] = self._look(material, prim)
        return list(self._materials).index(name)

    def _look(self, material: Any, prim: Any) -> dict[str, Any]:
        if not material:
            color = (
                UsdGeom.Gprim(prim).GetDisplayColorAttr().Get() if prim.IsA(UsdGeom.Gprim) else []
            )
            return {"name": "skin", **({"color": tuple(color[0])} if color else {})}
        look: dict[str, Any] = {"name": material.GetPrim().GetName()}
        surface, _, _ = material.ComputeSurfaceSource()
        for name in _COLOR if surface else ():
            given = surface.GetInput(name)
            if not given:
                continue
            source = given.GetConnectedSources()[0]
            if source and name == "diffuseColor":
                look["texture"] = self._texture(UsdShade.Shader(source[0].source.GetPrim()))
            elif given.Get() is not None:
                value = np.asarray(given.Get(), dtype=np.float64)
                look[_NAMES.get(name, name)] = tuple(value.tolist()) if value.ndim else float(value)
        return look

    def _texture(self, shader: Any) -> bytes:
        given = shader.GetInput("file") if shader else None
        asset = given.Get() if given else None
        data = _picture(self._path, asset.path) if asset else b""
        return data if data.startswith((b"\x89PNG", b"\xff\xd8\xff")) else b""


def _picture(path: str, asset: str) -> bytes:
    """The bytes of a file, which a scene of another program may have anywhere."""
    file = Path(path).parent / asset
    if path.lower().endswith(".usdz") or not file.is_file() or file.stat().st_size > LARGEST:
        return texture(path, asset)
    return file.read_bytes()


def _fans(counts: Numbers) -> tuple[Numbers, Numbers]:
    """Places (t, 3) of polygons' corners that make triangles, and each one's polygon (t,)."""
    starts = np.cumsum(counts) - counts
    polygons = np.repeat(np.arange(len(counts)), counts - 2)
    within = np.arange(len(polygons)) - np.repeat(np.cumsum(counts - 2) - (counts - 2), counts - 2)
    first = starts[polygons]
    return np.stack([first, first + within + 1, first + within + 2], axis=1), polygons


def _places(mesh: Any, indices: Numbers, corners: Numbers) -> Numbers | None:
    """(3 t, 2) places in the texture of triangles' corners."""
    primvar = UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st")
    flat = primvar.ComputeFlattened(Usd.TimeCode.EarliestTime()) if primvar else None
    if flat is None:
        return None
    values = np.array(flat, dtype=np.float64).reshape(-1, 2)
    if primvar.GetInterpolation() == UsdGeom.Tokens.faceVarying and len(values) == len(indices):
        return values[corners.reshape(-1)]
    if len(values) > indices.max():
        return values[indices[corners.reshape(-1)]]
    return None
