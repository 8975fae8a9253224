"""Fibres by hand: along a line or a region, round a limb, winding about it, and from OBJ curves.

Vertices just outside the mesh are moved onto its surface, with a `MeshWarning`; others are refused.
A `MeshWarning` also tells of a segment that leaves the mesh between its vertices.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.body.fiber_embedding import embed, tell_of_gaps
from warp_softbody.body.mesh import TetMesh
from warp_softbody.body.mesh_formats.obj_curves import read_polylines
from warp_softbody.body.muscles import Fiber, FiberKind
from warp_softbody.errors import InputError
from warp_softbody.inputs import array_checks, checks, input_kinds

__all__ = ["along", "helix", "read_curves", "ring"]

MOST_SEGMENTS = 1000

LEAST_A_TURN = 6
"""Segments of one turn of a helix: fewer cut through what they wind about."""

DEPTH = 0.38
"""Usual depth of a ring or helix below the skin, over the distance from its axis to the skin."""


def along(
    mesh: TetMesh,
    path: npt.ArrayLike | str,
    *,
    segments: int | None = None,
    name: str = "along",
    kind: FiberKind = FiberKind.LONGITUDINAL,
) -> Fiber:
    """A fibre along a polyline, or along the middle of a region.

    Args:
        mesh: that it lies in.
        path: (k, 3) m, points of the polyline; or the name of a region of the mesh, or its nodes,
            whose slices across its longest way have the fibre in their middles.
        segments: equally long, along the polyline; None for those of the polyline, and for six
            along a region.
        name: of the fibre.
        kind: of the fibre.

    Raises:
        InputError: no such region, a vertex far outside, or no such number of segments.
    """
    mesh = checks.instance("mesh of along", mesh, TetMesh)
    if segments is not None:
        segments = checks.whole("segments of along", segments, low=1, high=MOST_SEGMENTS)
    if isinstance(path, str) or np.ndim(path) == 1:
        points = _middles(mesh, path, 6 if segments is None else segments)
    else:
        points = array_checks.array("path of along", path, (None, 3), unit="m")
        if len(points) < 2:
            raise InputError("path of along must be two points or more, or a region")
        if segments is not None:
            points = _evenly(points, segments)
    return _embedded(mesh, points, name, kind)


def ring(
    mesh: TetMesh,
    centre: npt.ArrayLike,
    axis: npt.ArrayLike,
    *,
    segments: int = 12,
    depth: float = DEPTH,
    name: str = "ring",
) -> Fiber:
    """A closed fibre round a limb, across its axis: it makes the limb thinner, and so longer.

    Args:
        mesh: that it lies in.
        centre: (3,) m, within the mesh.
        axis: (3,) of the limb.
        segments: of the ring.
        depth: below the skin, over the distance from the centre to the skin; 0 lies on it.
        name: of the fibre.

    Raises:
        InputError: the centre lies outside.
    """
    middle = np.array(checks.vector("centre of ring", centre, unit="m"))
    way = np.array(checks.direction("axis of ring", axis))
    count = checks.whole("segments of ring", segments, low=3, high=MOST_SEGMENTS)
    turns = 2.0 * np.pi * np.arange(count + 1) / count
    points = _around(mesh, np.tile(middle, (count + 1, 1)), way, turns, depth, "ring")
    points[-1] = points[0]
    return _embedded(mesh, points, name, FiberKind.RADIAL)


def helix(
    mesh: TetMesh,
    start: npt.ArrayLike,
    end: npt.ArrayLike,
    *,
    turns: float = 2.0,
    segments: int = 24,
    depth: float = DEPTH,
    name: str = "helix",
) -> Fiber:
    """A fibre that winds about a straight axis: it twists the limb, and shortens it.

    Args:
        mesh: that it lies in.
        start: (3,) m, of the axis, within the mesh.
        end: (3,) m, likewise.
        turns: counterclockwise as seen from the end; negative ones wind the other way.
        segments: of the fibre, at least six a turn.
        depth: as of a ring.
        name: of the fibre.

    Raises:
        InputError: the axis leaves the mesh or has no length, or the segments are too few.
    """
    first, last = (
        np.array(checks.vector(f"{which} of helix", place, unit="m"))
        for which, place in (("start", start), ("end", end))
    )
    if not np.linalg.norm(last - first) > 0.0:
        raise InputError("start and end of helix must be two places")
    wound = checks.number("turns of helix", turns)
    count = checks.whole("segments of helix", segments, low=2, high=MOST_SEGMENTS)
    # but for rounding of the turns
    needed = int(np.ceil(LEAST_A_TURN * abs(wound) - 1e-9))
    if count < needed:
        raise InputError(
            f"segments of helix must be at least {needed} for {wound:g} turns, {LEAST_A_TURN} a "
            f"turn, not {count}"
        )
    share = np.linspace(0.0, 1.0, count + 1)
    axis = first + share[:, None] * (last - first)
    way = (last - first) / np.linalg.norm(last - first)
    points = _around(mesh, axis, way, 2.0 * np.pi * wound * share, depth, "helix")
    return _embedded(mesh, points, name, FiberKind.HELICAL)


def read_curves(
    path: str | Path,
    *,
    unit: float = 1.0,
    kind: FiberKind = FiberKind.LONGITUDINAL,
) -> tuple[Fiber, ...]:
    """Fibres of the polylines (``l``) of an OBJ file, named by its objects and groups.

    Args:
        path: of the file.
        unit: of its coordinates, m.
        kind: of the fibres.

    Raises:
        MeshError: the file cannot be read, or holds no polyline.
    """
    path = input_kinds.path("path of read_curves", path)
    factor = checks.number("unit of read_curves", unit, above=0.0, unit="m")
    return tuple(
        Fiber(vertices=factor * points, kind=kind, name=name)
        for name, points in read_polylines(path)
    )


def _embedded(mesh: TetMesh, points: FloatArray, name: str, kind: FiberKind) -> Fiber:
    fiber = Fiber(vertices=points, kind=kind, name=name)
    moved = embed(mesh, np.array(fiber.vertices), [name] * len(points)).points
    tell_of_gaps(mesh, moved, name)
    return Fiber(vertices=moved, kind=kind, name=name)


def _middles(mesh: TetMesh, region: Any, segments: int) -> FloatArray:
    """Middles of slices of a region across its longest way, (segments + 1, 3) m."""
    if isinstance(region, str):
        nodes = mesh.regions.get(region)
        if nodes is None:
            known = ", ".join(sorted(mesh.regions)) or "none"
            raise InputError(f"the mesh has no region {region!r}; its regions are: {known}")
    else:
        nodes = input_kinds.node_set("path of along", region, len(mesh.points))
    if len(nodes) < 2:
        raise InputError("a fibre along a region needs two nodes of it or more")
    points = mesh.points[nodes]
    way = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2][0]
    # from below, or from behind, so that mirrored limbs have alike ones
    way = way if (way[2], way[0], way[1]) >= (-way[2], -way[0], -way[1]) else -way
    height = points @ way
    at = np.linspace(height.min(), height.max(), segments + 1)
    spacing = max(float(at[1] - at[0]), 1e-9)
    found = []
    for station in at:
        # a hat, so that no node enters or leaves a slice at once
        weights = np.maximum(1.0 - np.abs(height - station) / spacing, 0.0)
        if weights.any():
            middle = weights @ points / weights.sum()
            found.append(middle + 0.9 * (station - middle @ way) * way)
    return np.array(found)


def _evenly(points: FloatArray, segments: int) -> FloatArray:
    """Points at equal distances along a polyline."""
    reached = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
    at = np.linspace(0.0, reached[-1], segments + 1)
    return np.stack([np.interp(at, reached, points[:, k]) for k in range(3)], axis=1)


def _around(
    mesh: TetMesh, axis: FloatArray, way: FloatArray, angles: FloatArray, depth: float, what: str
) -> FloatArray:
    """Points (k, 3) m at angles (k,) about an axis, at a depth below the skin."""
    checks.instance(f"mesh of {what}", mesh, TetMesh)
    share = 1.0 - checks.number(f"depth of {what}", depth, low=0.0, high=0.99)
    level = np.eye(3)[int(np.abs(way).argmin())]
    first = np.cross(way, level)
    first /= np.linalg.norm(first)
    second = np.cross(way, first)
    ways = np.cos(angles)[:, None] * first + np.sin(angles)[:, None] * second
    return np.asarray(axis + share * _to_skin(mesh, axis, ways, what)[:, None] * ways)


def _to_skin(mesh: TetMesh, places: FloatArray, ways: FloatArray, what: str) -> FloatArray:
    """Distances (k,) m from places along ways to the skin (Moeller and Trumbore 1997)."""
    a, b, c = (mesh.points[corner] for corner in mesh.surface.T)
    one, other = b - a, c - a
    found = np.zeros(len(places))
    for index, (place, way) in enumerate(zip(places, ways, strict=True)):
        across = np.cross(way, other)
        volume = (one * across).sum(axis=1)
        flat = np.abs(volume) < 1e-300
        inverse = 1.0 / np.where(flat, 1.0, volume)
        arm = place - a
        u = inverse * (arm * across).sum(axis=1)
        turned = np.cross(arm, one)
        v = inverse * (turned @ way)
        far = inverse * (other * turned).sum(axis=1)
        hit = ~flat & (u >= -1e-9) & (v >= -1e-9) & (u + v <= 1.0 + 1e-9) & (far > 0.0)
        # as often out as in, seen from outside
        leaving = (np.cross(one, other) @ way)[hit] > 0.0
        if not hit.any() or not leaving[far[hit].argmin()]:
            told = ", ".join(f"{value:g}" for value in place)
            raise InputError(f"the axis of {what} must lie in the mesh, but ({told}) m does not")
        found[index] = far[hit].min()
    return found
