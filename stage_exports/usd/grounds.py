"""A stage holds the ground as a mesh to look at, with the exact numbers to measure beside it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
from pxr import Gf, Sdf, UsdGeom, UsdShade, Vt

from warp_softbody.arrays import BoolArray, FloatArray
from warp_softbody.errors import InputError
from warp_softbody.stage_exports import conventions, palette
from warp_softbody.stage_exports.conventions import IntArray
from warp_softbody.stage_exports.round_lengths import round_length
from warp_softbody.stage_exports.usd import usd_arrays as values
from warp_softbody.stage_exports.usd.ground_friction import (
    bind_levels,
    friction_of_faces,
    map_numbers,
    read_map,
    shaded,
)
from warp_softbody.stage_exports.usd.stored_arrays import indices
from warp_softbody.world.friction_map import map_of
from warp_softbody.world.ground import Ground, Plane
from warp_softbody.world.height_field import HeightField
from warp_softbody.world.scene import Scene
from warp_softbody.world.triangle_ground import TriangleGround

_TYPES = Sdf.ValueTypeNames
_SHADES = ("Light", "Dark")

_TILE = 0.5
"""Side of a tile over the bodies' longest, before it is rounded down."""

_REACH, _MOST_TILES = 10.0, 40
"""Half the side of the tiled square over the bodies' longest, and tiles along it at most."""


def define_ground(stage: Any, scene: Scene, ground: Ground, materials: tuple[Any, Any]) -> None:
    """Tiles of a plane under the bodies, or the triangles of any other ground, in two shades."""
    points, faces, dark = _surface(scene, ground)
    mesh = UsdGeom.Mesh.Define(stage, conventions.GROUND)
    stored = values.vectors(points)
    mesh.CreatePointsAttr(stored)
    mesh.CreateExtentAttr(values.extent(stored))
    mesh.CreateFaceVertexCountsAttr(values.integers(np.full(len(faces), faces.shape[1])))
    mesh.CreateFaceVertexIndicesAttr(values.integers(faces))
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    flat = isinstance(ground, Plane)
    normals = [ground.normal] if flat else _normals(points, faces)
    mesh.CreateNormalsAttr(values.vectors(normals))
    mesh.SetNormalsInterpolation(UsdGeom.Tokens.constant if flat else UsdGeom.Tokens.uniform)
    shades = np.where(dark[:, None], palette.GROUND_DARK, palette.GROUND)
    placed = map_of(ground)
    friction = None if placed is None else friction_of_faces(placed, points, faces)
    if friction is not None:
        shades = shaded(shades, friction)
    mesh.CreateDisplayColorPrimvar(UsdGeom.Tokens.uniform).Set(values.vectors(shades))
    prim = mesh.GetPrim()
    for name, type_name, value in _numbers(ground):
        attribute = prim.CreateAttribute(name, type_name, custom=True)
        attribute.Set(value)
        attribute.SetDocumentation(conventions.MEANINGS[name])
    if friction is None or len(friction.levels) == 1:
        _bind(prim, materials, dark)
    else:
        UsdShade.MaterialBindingAPI.Apply(prim).Bind(materials[0])
        bind_levels(stage, prim, ground.friction, friction, dark)


def _bind(prim: Any, materials: tuple[Any, Any], dark: BoolArray) -> None:
    """The first material for the whole, and each for the faces of its shade."""
    binding = UsdShade.MaterialBindingAPI.Apply(prim)
    binding.Bind(materials[0])
    if not dark.any():
        return
    for name, material, chosen in zip(_SHADES, materials, (~dark, dark), strict=True):
        faces = values.integers(np.flatnonzero(chosen))
        subset = binding.CreateMaterialBindSubset(name, faces, UsdGeom.Tokens.face)
        UsdShade.MaterialBindingAPI.Apply(subset.GetPrim()).Bind(material)
    binding.SetMaterialBindSubsetsFamilyType(UsdGeom.Tokens.partition)


def _normals(points: FloatArray, faces: IntArray) -> FloatArray:
    """(f, 3) unit normals of flat faces of three or four corners."""
    diagonals = (
        points[faces[:, 2]] - points[faces[:, 0]],
        points[faces[:, -1]] - points[faces[:, 1]],
    )
    crossed = np.cross(*diagonals)
    return np.asarray(crossed / np.linalg.norm(crossed, axis=1, keepdims=True))


def read_ground(stored: Mapping[str, npt.NDArray[Any]] | None) -> Ground | None:
    """The ground that a prim was made from, out of its values by name; None for no prim.

    Raises:
        ValueError: a value is missing or cannot be one.
    """
    if stored is None:
        return None
    for name in (conventions.GROUND_FRICTION, conventions.GROUND_NORMAL):
        if name not in stored:
            raise ValueError(f"its ground has no value of {name!r}")
    friction = float(stored[conventions.GROUND_FRICTION])
    normal = _triple(stored[conventions.GROUND_NORMAL])
    placed = read_map(stored)
    if conventions.GROUND_OFFSET in stored:
        offset = float(stored[conventions.GROUND_OFFSET])
        return Plane(normal=normal, offset=offset, friction=friction, friction_map=placed)
    if conventions.GROUND_HEIGHTS in stored:
        return replace(_read_heights(stored, friction), friction_map=placed)
    faces = stored["faceVertexIndices"]
    return TriangleGround(
        vertices=np.asarray(stored["points"], dtype=np.float64),
        faces=indices("triangles of the ground", faces, 3, len(stored["points"])),
        friction=friction,
        normal=normal,
        friction_map=placed,
    )


def _read_heights(stored: Mapping[str, npt.NDArray[Any]], friction: float) -> HeightField:
    names = (conventions.GROUND_ROWS, conventions.GROUND_ORIGIN, conventions.GROUND_SPACING)
    if any(name not in stored for name in names):
        raise ValueError("its height field has no rows, origin or spacing")
    rows, origin, spacing = (stored[name] for name in names)
    heights = np.asarray(stored[conventions.GROUND_HEIGHTS], dtype=np.float64)
    if rows < 1 or heights.size % int(rows) or heights.size == 0:
        raise ValueError(f"its height field of {heights.size} heights cannot have {rows} rows")
    (x, y), (dx, dy) = origin.tolist(), spacing.tolist()
    return HeightField(
        heights=heights.reshape(int(rows), -1), origin=(x, y), spacing=(dx, dy), friction=friction
    )


def surface_of(ground: Ground) -> tuple[FloatArray, IntArray]:
    """Vertices (v, 3) and faces (f, 3) of a ground that is not a plane."""
    if isinstance(ground, HeightField | TriangleGround):
        return ground.triangles()
    raise InputError(f"a stage cannot show a ground of the type {type(ground).__name__}")


def _surface(scene: Scene, ground: Ground) -> tuple[FloatArray, IntArray, BoolArray]:
    """Points, faces, and which faces are dark."""
    if isinstance(ground, Plane):
        return _tiles(scene, ground)
    points, faces = surface_of(ground)
    return points, faces, np.zeros(len(faces), dtype=bool)


def _numbers(ground: Ground) -> list[tuple[str, Any, Any]]:
    numbers = [
        (conventions.GROUND_NORMAL, _TYPES.Vector3d, Gf.Vec3d(*ground.normal)),
        (conventions.GROUND_FRICTION, _TYPES.Double, ground.friction),
    ]
    placed = map_of(ground)
    if placed is not None:
        numbers += map_numbers(placed)
    if isinstance(ground, Plane):
        numbers.append((conventions.GROUND_OFFSET, _TYPES.Double, ground.offset))
    if isinstance(ground, HeightField):
        heights = Vt.DoubleArray.FromNumpy(np.ascontiguousarray(ground.heights.ravel()))
        numbers += [
            (conventions.GROUND_HEIGHTS, _TYPES.DoubleArray, heights),
            (conventions.GROUND_ROWS, _TYPES.Int, len(ground.heights)),
            (conventions.GROUND_ORIGIN, _TYPES.Double2, Gf.Vec2d(*ground.origin)),
            (conventions.GROUND_SPACING, _TYPES.Double2, Gf.Vec2d(*ground.spacing)),
        ]
    return numbers


def _tiles(scene: Scene, plane: Plane) -> tuple[FloatArray, IntArray, BoolArray]:
    """Square tiles of a round length around the bodies' shadow on the plane, light and dark.

    Corners run counter-clockwise seen from above.
    """
    points = np.asarray(scene.whole.mesh.points)
    normal = np.array(plane.normal)
    size = float(np.ptp(points, axis=0).max())
    side = round_length(_TILE * size)
    count = 2 * max(1, round(max(5.0, _REACH * size) / side))
    count = min(count, _MOST_TILES)
    first, second = _axes(normal)
    middle = points.mean(axis=0)
    # tiles begin at the foot of the origin, so that their edges tell distances
    corner = [np.floor(middle @ axis / side) - count // 2 for axis in (first, second)]
    ticks = [side * (start + np.arange(count + 1)) for start in corner]
    across, along = (grid.reshape(-1, 1) for grid in np.meshgrid(*ticks, indexing="ij"))
    made = plane.offset * normal + across * first + along * second
    rows, columns = (grid.reshape(-1) for grid in np.indices((count, count)))
    start = rows * (count + 1) + columns
    faces = np.stack([start, start + count + 1, start + count + 2, start + 1], axis=1)
    dark = (rows + columns + int(corner[0] + corner[1])) % 2 == 1
    return made, faces.astype(np.int32), dark


def _axes(normal: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Unit vectors along a plane, right-handed with its normal; the first along x where it can."""
    helper = np.array([1.0, 0.0, 0.0]) if abs(normal[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    first = helper - (helper @ normal) * normal
    first /= np.linalg.norm(first)
    return first, np.cross(normal, first)


def _triple(value: npt.ArrayLike) -> tuple[float, float, float]:
    x, y, z = np.asarray(value, dtype=np.float64).tolist()
    return x, y, z
