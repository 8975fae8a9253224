"""`HeightField` is an uneven ground given by heights on a regular grid."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.errors import InputError
from warp_softbody.inputs import array_checks, checks
from warp_softbody.inputs.records import FrozenValue
from warp_softbody.world.creases import creases
from warp_softbody.world.friction_map import FrictionMap, checked_map
from warp_softbody.world.ground import Vector, measurable

IntArray = npt.NDArray[np.int32]


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class HeightField(FrozenValue):
    """A ground z = h(x, y) with two flat triangles per cell; beyond the grid it is level.

    Attributes:
        heights: (rows, columns) m, h at x = origin[0] + row * spacing[0] and
            y = origin[1] + column * spacing[1]; at least two of each.
        spacing: m, of the grid along x and y.
        origin: m, x and y of heights[0, 0].
        friction: Coulomb coefficient mu, >= 0.
        friction_map: factors on it by place; None where it is the same everywhere.
    """

    heights: FloatArray
    spacing: tuple[float, float] = (0.1, 0.1)
    origin: tuple[float, float] = (0.0, 0.0)
    friction: float = 0.8
    normal: Vector = (0.0, 0.0, 1.0)
    friction_map: FrictionMap | None = None

    def __post_init__(self) -> None:
        """Check shape and numbers; keep an own copy of the heights."""
        friction = checks.number("HeightField.friction", self.friction, low=0.0)
        heights = np.array(array_checks.array("HeightField.heights", self.heights, (None, None)))
        if min(heights.shape) < 2:
            raise InputError(
                f"HeightField.heights must be a grid of at least 2 x 2 heights, not of "
                f"shape {heights.shape}"
            )
        spacing = checks.vector("HeightField.spacing", self.spacing, 2, unit="m")
        if min(spacing) <= 0.0:
            raise InputError(f"HeightField.spacing must be positive, not {spacing}")
        origin = checks.vector("HeightField.origin", self.origin, 2, unit="m")
        if checks.vector("HeightField.normal", self.normal) != (0.0, 0.0, 1.0):
            raise InputError("HeightField.normal must be (0, 0, 1): a height field stands upright")
        heights.setflags(write=False)
        checks.keep(self, heights=heights, spacing=spacing, origin=origin, friction=friction)
        given = checked_map("HeightField.friction_map", self.friction_map)
        checks.keep(self, normal=(0.0, 0.0, 1.0), friction_map=given)

    @cached_property
    def creases(self) -> IntArray:
        """(rows, columns) bits of the sharp convex edges of the triangles, as of `creases`."""
        return creases(self.heights, self.spacing)

    def surface(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Heights (k,) m of the ground under points (k, 2 or 3), and its slopes (k, 2) there."""
        last = np.array(self.heights.shape) - 1
        place = (points[:, :2] - self.origin) / self.spacing
        inner = np.clip(place, 0.0, last)
        i, j = np.minimum(inner.astype(int), last - 1).T
        a, b = (inner - np.stack([i, j], axis=1)).T
        h = self.heights
        lower = np.stack([h[i + 1, j] - h[i, j], h[i + 1, j + 1] - h[i + 1, j]], axis=1)
        upper = np.stack([h[i + 1, j + 1] - h[i, j + 1], h[i, j + 1] - h[i, j]], axis=1)
        along = np.where((a < b)[:, None], upper, lower)
        height = h[i, j] + a * along[:, 0] + b * along[:, 1]
        return height, np.where(inner == place, along / self.spacing, 0.0)

    def measure(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Signed distances (k,) m to the plane of the triangle below, and its normals (k, 3)."""
        points = measurable("points of HeightField.measure", points)
        height, slopes = self.surface(points)
        normals = np.column_stack([-slopes, np.ones(len(points))])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        return (points[:, 2] - height) * normals[:, 2], normals

    def triangles(self) -> tuple[FloatArray, IntArray]:
        """Vertices (rows * columns, 3) m and faces (f, 3), counter-clockwise seen from above."""
        rows, columns = self.heights.shape
        x = self.origin[0] + self.spacing[0] * np.arange(rows)
        y = self.origin[1] + self.spacing[1] * np.arange(columns)
        flat = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
        index = np.arange(rows * columns, dtype=np.int32).reshape(rows, columns)
        near, right = index[:-1, :-1].ravel(), index[1:, :-1].ravel()
        up, far = index[:-1, 1:].ravel(), index[1:, 1:].ravel()
        faces = np.stack([near, right, far, near, far, up], axis=1).reshape(-1, 3)
        return np.column_stack([flat, self.heights.ravel()]), faces
