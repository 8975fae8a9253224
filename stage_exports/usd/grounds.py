"""A stage holds the ground as a mesh to look at, with the exact numbers to measure beside it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
from pxr import Gf, Sdf, UsdGeom, UsdShade, Vt

from warp_softbody.arrays import FloatArray
from warp_softbody.errors import InputError
from warp_softbody.stage_exports import conventions, palette
from warp_softbody.stage_exports.conventions import IntArray
from warp_softbody.stage_exports.usd import usd_arrays as values
from warp_softbody.stage_exports.usd.stored_arrays import indices
from warp_softbody.world.ground import Ground, Plane
from warp_softbody.world.height_field import HeightField
from warp_softbody.world.scene import Scene
from warp_softbody.world.triangle_ground import TriangleGround

_TYPES = Sdf.ValueTypeNames


def define_ground(stage: Any, scene: Scene, ground: Ground, material: Any) -> None:
    """A large square of a plane under the bodies, or the triangles of any other ground."""
    points, faces = _surface(scene, ground)
    mesh = UsdGeom.Mesh.Define(stage, conventions.GROUND)
    stored = values.vectors(points)
    mesh.CreatePointsAttr(stored)
    mesh.CreateExtentAttr(values.extent(stored))
    mesh.CreateFaceVertexCountsAttr(values.integers(np.full(len(faces), faces.shape[1])))
    mesh.CreateFaceVertexIndicesAttr(values.integers(faces))
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    mesh.CreateDisplayColorAttr([Gf.Vec3f(*palette.GROUND)])
    prim = mesh.GetPrim()
    for name, type_name, value in _numbers(ground):
        prim.CreateAttribute(name, type_name, custom=True).Set(value)
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(material)


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
    if conventions.GROUND_OFFSET in stored:
        offset = float(stored[conventions.GROUND_OFFSET])
        return Plane(normal=normal, offset=offset, friction=friction)
    if conventions.GROUND_HEIGHTS in stored:
        return _read_heights(stored, friction)
    faces = stored["faceVertexIndices"]
    return TriangleGround(
        vertices=np.asarray(stored["points"], dtype=np.float64),
        faces=indices("triangles of the ground", faces, 3, len(stored["points"])),
        friction=friction,
        normal=normal,
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


def _surface(scene: Scene, ground: Ground) -> tuple[FloatArray, IntArray]:
    if isinstance(ground, Plane):
        return _square(scene, ground), np.array([[0, 1, 2, 3]], dtype=np.int32)
    return surface_of(ground)


def _numbers(ground: Ground) -> list[tuple[str, Any, Any]]:
    numbers = [
        (conventions.GROUND_NORMAL, _TYPES.Vector3d, Gf.Vec3d(*ground.normal)),
        (conventions.GROUND_FRICTION, _TYPES.Double, ground.friction),
    ]
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


def _square(scene: Scene, plane: Plane) -> FloatArray:
    """Corners, counter-clockwise seen from above, around the bodies' shadow on the plane."""
    points = np.asarray(scene.whole.mesh.points)
    normal = np.array(plane.normal)
    middle = points.mean(axis=0)
    middle -= (middle @ normal - plane.offset) * normal
    half = max(5.0, 10.0 * float(np.ptp(points, axis=0).max()))
    helper = np.eye(3)[int(np.argmin(np.abs(normal)))]
    first = np.cross(helper, normal)
    first /= np.linalg.norm(first)
    second = np.cross(normal, first)
    signs = ((-1, -1), (1, -1), (1, 1), (-1, 1))
    return np.array([middle + half * (a * first + b * second) for a, b in signs])


def _triple(value: npt.ArrayLike) -> tuple[float, float, float]:
    x, y, z = np.asarray(value, dtype=np.float64).tolist()
    return x, y, z
