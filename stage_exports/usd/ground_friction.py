"""A stage shows and tells friction that differs from place to place on its ground."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from pxr import Gf, Sdf, UsdGeom, UsdShade, Vt

from warp_softbody.arrays import BoolArray, FloatArray
from warp_softbody.stage_exports import conventions, palette
from warp_softbody.stage_exports.conventions import IntArray
from warp_softbody.stage_exports.usd import usd_arrays as values
from warp_softbody.stage_exports.usd.surroundings import define_material
from warp_softbody.world.friction_map import FrictionMap

_TYPES = Sdf.ValueTypeNames

MOST_LEVELS = 8
"""Of friction that have a material of their own; more are put together by nearness."""


class FaceFriction(NamedTuple):
    """Levels of a map's factors (l,), and the level (f,) of each face by its middle."""

    levels: FloatArray
    faces: IntArray


def friction_of_faces(placed: FrictionMap, points: FloatArray, faces: IntArray) -> FaceFriction:
    """Of faces (f, 3 or 4) over points (v, 3) m."""
    factors = placed.at(points[faces].mean(axis=1))
    levels, found = np.unique(factors, return_inverse=True)
    if len(levels) > MOST_LEVELS:
        levels = np.linspace(levels[0], levels[-1], MOST_LEVELS)
        found = np.abs(factors[:, None] - levels).argmin(axis=1)
    return FaceFriction(levels, found.astype(np.int32).ravel())


def shaded(colors: FloatArray, friction: FaceFriction) -> FloatArray:
    """Colours (f, 3) of faces, the brighter the more slippery."""
    return np.asarray(colors * palette.friction_shade(friction.levels[friction.faces])[:, None])


def bind_levels(
    stage: Any, mesh: Any, coefficient: float, friction: FaceFriction, dark: BoolArray
) -> None:
    """A subset of the faces with a material for each level and shade, which tells its friction."""
    binding = UsdShade.MaterialBindingAPI.Apply(mesh)
    for level, factor in enumerate(friction.levels):
        for shade, color in (("Light", palette.GROUND), ("Dark", palette.GROUND_DARK)):
            chosen = np.flatnonzero((friction.faces == level) & (dark == (shade == "Dark")))
            if not len(chosen):
                continue
            bright = float(palette.friction_shade(np.array([factor]))[0])
            red, green, blue = (bright * part for part in color)
            name = f"Ground{shade}Friction{level}"
            material = define_material(stage, name, (red, green, blue), roughness=0.9)
            faces = values.integers(chosen)
            subset = binding.CreateMaterialBindSubset(
                f"{shade}Friction{level}", faces, UsdGeom.Tokens.face
            )
            UsdShade.MaterialBindingAPI.Apply(subset.GetPrim()).Bind(material)
            attribute = subset.GetPrim().CreateAttribute(
                conventions.GROUND_FRICTION, _TYPES.Double, custom=True
            )
            attribute.Set(coefficient * float(factor))
            attribute.SetDocumentation(conventions.MEANINGS[conventions.GROUND_FRICTION])
    binding.SetMaterialBindSubsetsFamilyType(UsdGeom.Tokens.partition)


def map_numbers(placed: FrictionMap) -> list[tuple[str, Any, Any]]:
    """Attributes of a ground that hold its map: name, type and value of each."""
    factors = Vt.DoubleArray.FromNumpy(np.ascontiguousarray(placed.factors.ravel()))
    return [
        (conventions.FRICTION_FACTORS, _TYPES.DoubleArray, factors),
        (conventions.FRICTION_ROWS, _TYPES.Int, len(placed.factors)),
        (conventions.FRICTION_ORIGIN, _TYPES.Double2, Gf.Vec2d(*placed.origin)),
        (conventions.FRICTION_SPACING, _TYPES.Double2, Gf.Vec2d(*placed.spacing)),
    ]


def read_map(stored: Mapping[str, npt.NDArray[Any]]) -> FrictionMap | None:
    """The map out of a ground's values by name; None where there is none.

    Raises:
        ValueError: a value is missing or cannot be one.
    """
    if conventions.FRICTION_FACTORS not in stored:
        return None
    names = (conventions.FRICTION_ROWS, conventions.FRICTION_ORIGIN, conventions.FRICTION_SPACING)
    if any(name not in stored for name in names):
        raise ValueError("its map of friction has no rows, origin or spacing")
    rows, origin, spacing = (stored[name] for name in names)
    factors = np.asarray(stored[conventions.FRICTION_FACTORS], dtype=np.float64)
    if rows < 1 or factors.size % int(rows) or factors.size == 0:
        raise ValueError(f"its map of {factors.size} factors cannot have {rows} rows")
    (x, y), (dx, dy) = origin.tolist(), spacing.tolist()
    return FrictionMap(factors=factors.reshape(int(rows), -1), origin=(x, y), spacing=(dx, dy))
