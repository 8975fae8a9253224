"""Checks of an exported file: USD's own validators, and what they do not see.

They are also run in a process of their own (`isolation.py`).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from pxr import Sdf, Tf, Usd, UsdGeom, UsdValidation

from warp_softbody.stage_exports import conventions
from warp_softbody.stage_exports.usd import usd_arrays as values
from warp_softbody.stage_exports.usd import watchdog
from warp_softbody.stage_exports.usd.extraction import body_prims, open_stage
from warp_softbody.stage_exports.usd.merging import reason
from warp_softbody.stage_exports.usd.textures import named_textures

_POINT_TYPES = (Sdf.ValueTypeNames.Point3fArray, Sdf.ValueTypeNames.Float3Array)
_INDICES = ("faceVertexIndices", "tetVertexIndices", "surfaceFaceVertexIndices")
_REFERENCES = "usdUtilsValidators:MissingReferenceValidator"
"""Looks for files from a place that a stage has not which is opened without its name."""
_STATIC = (*_INDICES, "faceVertexCounts", "curveVertexCounts")


def find_faults(path: str) -> list[str]:
    """What `validate` tells of a file, in the process that reads it.

    Raises:
        InputError: it cannot be opened at all.
    """
    stage = open_stage(path)
    prims = list(stage.Traverse(Usd.PrimAllPrimsPredicate))
    geometry = [prim for prim in prims if prim.IsA(UsdGeom.PointBased)]
    checks = [_usd_findings(stage), _check_clock(stage), _check_motion(stage)]
    checks += [_check_textures(stage, path)]
    checks += [_check_geometry(prim) for prim in geometry]
    return [sentence for check in checks for sentence in _whole(check)]


def _whole(check: Iterator[str]) -> Iterator[str]:
    """What a check finds, with what damage in the file made of it."""
    try:
        yield from check
    except Tf.ErrorException as error:
        yield f"the stage is damaged: {' '.join(reason(error).split())}"
    except (
        ArithmeticError,
        LookupError,
        MemoryError,
        RuntimeError,
        TypeError,
        ValueError,
    ) as error:
        yield f"the stage is damaged: {' '.join(str(error).split())}"


def _usd_findings(stage: Any) -> Iterator[str]:
    registry = UsdValidation.ValidationRegistry()
    wanted = [
        one for one in registry.GetOrLoadAllValidators() if one.GetMetadata().name != _REFERENCES
    ]
    context = UsdValidation.ValidationContext(wanted)
    for error in context.Validate(stage):
        if not error.HasNoError():
            yield f"{error.GetErrorAsString()}"


def _check_textures(stage: Any, path: str) -> Iterator[str]:
    for name, data in named_textures(stage.GetRootLayer(), path).items():
        if not data:
            yield f"the texture {name!r} is not in the stage's folder"


def _check_clock(stage: Any) -> Iterator[str]:
    layer = stage.GetRootLayer()
    if UsdGeom.GetStageUpAxis(stage) != UsdGeom.Tokens.z:
        yield "the stage's up axis is not Z"
    if UsdGeom.GetStageMetersPerUnit(stage) != 1.0:
        yield "the stage's unit is not the metre"
    codes = sorted(layer.ListAllTimeSamples())
    if not codes:
        yield "the stage holds no time sample"
    elif (layer.startTimeCode, layer.endTimeCode) != (codes[0], codes[-1]):
        yield f"start and end time codes are not those of the samples, {codes[0]} and {codes[-1]}"


def _check_motion(stage: Any) -> Iterator[str]:
    bodies = body_prims(stage)
    if not bodies:
        yield "the stage holds no character with a skin and tets"
    frozen = [_frozen(body) for body in bodies]
    # one body may stand still among others, but not its skin around moving tets
    nothing_moves = all(len(names) == 2 for names in frozen)
    for body, names in zip(bodies, frozen, strict=True):
        if nothing_moves or len(names) == 1:
            yield from (f"{body.GetPath()}/{name} is the same in every frame" for name in names)


def _frozen(body: Any) -> list[str]:
    """Which of a body's skin and tets are the same in every frame."""
    names = []
    for name in (conventions.SKIN, conventions.TETS):
        watchdog.feed()
        points = body.GetChild(name).GetAttribute("points")
        codes = points.GetTimeSamples()
        first = points.Get(codes[0]) if codes else None
        if len(codes) > 1 and all(points.Get(code) == first for code in codes[1:]):
            names.append(name)
    return names


def _check_geometry(prim: Any) -> Iterator[str]:
    path = prim.GetPath()
    points = prim.GetAttribute("points")
    # The schema answers for the attribute, so only the authored specs tell what is stored.
    stored = {spec.typeName for spec in points.GetPropertyStack()}
    if not stored <= set(_POINT_TYPES):
        names = ", ".join(sorted(str(name) for name in stored))
        yield f"{path} has points of the type {names} and not float3"
        return
    for name in _STATIC:
        if prim.GetAttribute(name) and prim.GetAttribute(name).GetNumTimeSamples():
            yield f"{path} changes its {name} over time"
    for code in points.GetTimeSamples() or [Usd.TimeCode.Default()]:
        yield from _check_sample(prim, code)


def _check_sample(prim: Any, code: Any) -> Iterator[str]:
    watchdog.feed()
    place = f"{prim.GetPath()} at {code}"
    points = prim.GetAttribute("points").Get(code)
    if not np.isfinite(np.asarray(points)).all():
        yield f"{place} has points that are not finite"
        return
    stored = prim.GetAttribute("extent").Get(code)
    if (
        stored is None
        or len(stored) != 2
        or not _same_box(stored, _expected_extent(prim, points, code))
    ):
        yield f"{place} has an extent that is not the box of its points"
    velocity = prim.GetAttribute(conventions.VELOCITY)
    if velocity and len(velocity.Get(code)) != len(points):
        yield f"{place} has {len(velocity.Get(code))} velocities for {len(points)} points"
    for name in _INDICES:
        indices = np.asarray(prim.GetAttribute(name).Get() or values.integers([]))
        if indices.size and not (0 <= indices.min() and indices.max() < len(points)):
            yield f"{place} has {name} out of the range of its points"


def _expected_extent(prim: Any, points: Any, code: Any) -> Any:
    """The box as USD computes it, widths included; it computes none for an empty set of points."""
    if len(points) == 0:
        return UsdGeom.PointBased.ComputeExtent(points)
    return UsdGeom.Boundable.ComputeExtentFromPlugins(UsdGeom.Boundable(prim), code)


def _same_box(stored: Any, expected: Any) -> bool:
    if expected is None or len(expected) != 2:
        return False
    return np.allclose(np.asarray(stored), np.asarray(expected), rtol=1e-5, atol=1e-7)
