"""The ground in a stage: a mesh to look at, and beside it the exact numbers to measure against."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from pxr import Gf, Sdf, UsdGeom, UsdShade, Vt

from warp_softbody.errors import InputError
from warp_softbody.ground import Ground, Plane
from warp_softbody.ground_heights import HeightField
from warp_softbody.ground_triangles import TriangleGround
from warp_softbody.scene import Scene
from warp_softbody.stage_exports import conventions, palette, values
from warp_softbody.stage_exports.conventions import FloatArray, IntArray

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


def read_ground(prim: Any) -> Ground | None:
    """The ground that a prim was made from; None where there is no prim."""
    if not prim:
        return None
    friction = float(_value(prim, conventions.GROUND_FRICTION))
    normal = _triple(_value(prim, conventions.GROUND_NORMAL))
    if prim.HasAttribute(conventions.GROUND_OFFSET):
        offset = float(_value(prim, conventions.GROUND_OFFSET))
        return Plane(normal=normal, offset=offset, friction=friction)
    if prim.HasAttribute(conventions.GROUND_HEIGHTS):
        rows = int(_value(prim, conventions.GROUND_ROWS))
        x, y = _value(prim, conventions.GROUND_ORIGIN)
        dx, dy = _value(prim, conventions.GROUND_SPACING)
        heights = np.asarray(_value(prim, conventions.GROUND_HEIGHTS), dtype=np.float64)
        return HeightField(
            heights=heights.reshape(rows, -1), origin=(x, y), spacing=(dx, dy), friction=friction
        )
    return TriangleGround(
        vertices=np.asarray(_value(prim, "points"), dtype=np.float64),
        faces=np.asarray(_value(prim, "faceVertexIndices"), dtype=np.int32).reshape(-1, 3),
        friction=friction,
        normal=normal,
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


def _value(prim: Any, name: str) -> Any:
    value = prim.GetAttribute(name).Get()
    if value is None:
        raise InputError(f"{prim.GetPath()} has no value of {name!r}")
    return value


def _triple(value: npt.ArrayLike) -> tuple[float, float, float]:
    x, y, z = np.asarray(value, dtype=np.float64).tolist()
    return x, y, z
