"""NumPy arrays are converted to USD values; every stored length is single precision."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from pxr import Gf, UsdGeom, Vt

from warp_softbody.stage_exports.camera import Camera


def vectors(array: npt.ArrayLike) -> Any:
    """(n, 3) numbers as float3 array."""
    return Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(array, dtype=np.float32))


def pairs(array: npt.ArrayLike) -> Any:
    """(n, 2) numbers as float2 array."""
    return Vt.Vec2fArray.FromNumpy(np.ascontiguousarray(array, dtype=np.float32))


def floats(array: npt.ArrayLike) -> Any:
    """(n,) numbers as float array."""
    return Vt.FloatArray.FromNumpy(np.ascontiguousarray(array, dtype=np.float32))


def integers(array: npt.ArrayLike) -> Any:
    """Whole numbers, flattened, as int array."""
    return Vt.IntArray.FromNumpy(np.ascontiguousarray(array, dtype=np.int32).reshape(-1))


def triples(array: npt.ArrayLike) -> Any:
    """(n, 3) whole numbers as int3 array."""
    return Vt.Vec3iArray.FromNumpy(np.ascontiguousarray(array, dtype=np.int32))


def quadruples(array: npt.ArrayLike) -> Any:
    """(n, 4) whole numbers as int4 array."""
    return Vt.Vec4iArray.FromNumpy(np.ascontiguousarray(array, dtype=np.int32))


def triple(numbers: npt.ArrayLike) -> Any:
    """(3,) numbers in double precision."""
    return Gf.Vec3d(*np.asarray(numbers, dtype=np.float64).tolist())


def place(camera: Camera) -> Any:
    """Where a camera stands, m."""
    return triple(camera.eye)


def turn(camera: Camera) -> Any:
    """The rotation of a camera's prim, which looks along minus z, y upwards."""
    right, up = camera.axes
    matrix = np.eye(4)
    matrix[:3, :3] = right, up, -camera.forward
    return Gf.Matrix4d(*matrix.reshape(-1).tolist())


def extent(points: Any, width: float = 0.0) -> Any:
    """Box of stored points, grown by half the width of what is drawn: readers trust it blindly."""
    if len(points) == 0:
        return UsdGeom.PointBased.ComputeExtent(points)
    stored = np.asarray(points)
    half = np.float32(width) / np.float32(2.0)
    return vectors(np.stack([stored.min(axis=0) - half, stored.max(axis=0) + half]))
