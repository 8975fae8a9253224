"""Longitudinal fibres along limbs, four around the axis of each."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.body.making.limbs import Limb
from warp_softbody.body.making.shape_regions import QUADRANTS
from warp_softbody.body.mesh import TetMesh
from warp_softbody.body.muscles import Fiber, FiberKind
from warp_softbody.body.point_location import locate

BUDGET = 96
"""Segments that all fibres have together, about: each is an unknown of every control step."""

LEAST_SEGMENTS, MOST_SEGMENTS = 2, 12
"""Segments of one fibre."""

OFF_AXIS = 0.62
"""Distance of a fibre from the axis over that of the skin, in each of two directions."""

PARALLEL = 1e-3
"""Sine of an angle below which two ways have none between them."""

PULLED_IN = 0.85
"""Factor by which a vertex that lies outside comes nearer to the axis, until it lies inside."""

NEAR = 64
"""Tets that are tried for a vertex, those whose middles are nearest."""


def limb_fibers(mesh: TetMesh, limbs: Sequence[Limb]) -> tuple[Fiber, ...]:
    """Fibres of all limbs, named by limb and strand; their segments are about equally long."""
    total = sum(limb.length for limb in limbs) * len(QUADRANTS)
    return tuple(
        fiber
        for number, limb in enumerate(limbs)
        for fiber in _strands(mesh, limb, number, total / BUDGET)
    )


def _strands(mesh: TetMesh, limb: Limb, number: int, segment: float) -> list[Fiber]:
    count = int(np.clip(round(limb.length / segment), LEAST_SEGMENTS, MOST_SEGMENTS))
    axis = _stations(_smooth(limb.axis), count + 1)
    frames = _frames(mesh, limb, axis)
    fibers = []
    for strand, sides in enumerate(QUADRANTS):
        offset = OFF_AXIS * np.einsum("k,skx->sx", np.array(sides), frames)
        vertices = _inside(mesh, axis, offset)
        apart = np.linalg.norm(np.diff(vertices, axis=0), axis=1) > 1e-3 * limb.length
        kept = vertices[np.concatenate([[True], apart])]
        if len(kept) > 1:
            name = f"longitudinal_{number}_{strand}"
            fibers.append(Fiber(vertices=kept, kind=FiberKind.LONGITUDINAL, name=name))
    return fibers


def _smooth(axis: FloatArray) -> FloatArray:
    """The axis without the jitter of slices: each inner point nearer to between its neighbours."""
    smooth: FloatArray = axis.copy()
    smooth[1:-1] = 0.5 * axis[1:-1] + 0.25 * (axis[:-2] + axis[2:])
    return smooth


def _stations(axis: FloatArray, count: int) -> FloatArray:
    """Points (count, 3) at equal distances along a polyline."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(axis, axis=0), axis=1))])
    at = np.linspace(0.0, along[-1], count)
    return np.stack([np.interp(at, along, axis[:, k]) for k in range(3)], axis=1)


def _frames(mesh: TetMesh, limb: Limb, axis: FloatArray) -> FloatArray:
    """At each station (s,) the two ways (2, 3) m across the limb to its skin, without twist.

    The first way is the level one, so that strands of mirrored limbs mirror each other.
    """
    tangents = _tangents(axis)
    first = _across(tangents[0])
    points = mesh.points[limb.nodes]
    station = np.linalg.norm(points[:, None] - axis[None], axis=2).argmin(axis=1)
    frames = np.zeros((len(axis), 2, 3))
    for index, tangent in enumerate(tangents):
        first = first - (first @ tangent) * tangent
        length = float(np.linalg.norm(first))
        # at a right angle to the last way the axis goes along that way
        first = first / length if length > PARALLEL else _perpendicular(tangent)
        second = np.cross(tangent, first)
        around = points[abs(station - index) <= 1] - axis[index]
        if not len(around):
            around = points - axis[index]
        # A limb so thin that the mesh has no node within it is as its slices are, and round.
        wide = np.full(2, np.sqrt(0.5) * limb.radius)
        if len(around):
            wide = np.sqrt(np.square(around @ np.stack([first, second]).T).mean(axis=0))
        # The skin of a solid section is sqrt(3) (box) to 2 (round) standard deviations away.
        reach = 1.8 * wide
        frames[index] = np.stack([first, second]) * reach[:, None]
    return frames


def _tangents(axis: FloatArray) -> FloatArray:
    """Unit tangents (s, 3) of an axis; where it turns back on itself, the way it came."""
    tangents: FloatArray = np.gradient(axis, axis=0)
    came = np.diff(axis, axis=0, prepend=axis[:1])
    back = np.linalg.norm(tangents, axis=1) < PARALLEL * np.linalg.norm(came, axis=1)
    tangents[back] = came[back]
    unit: FloatArray = tangents / np.linalg.norm(tangents, axis=1, keepdims=True)
    return unit


def _perpendicular(tangent: FloatArray) -> FloatArray:
    """A unit way at right angles to a tangent."""
    way = np.cross(tangent, np.eye(3)[abs(tangent).argmin()])
    return np.asarray(way / np.linalg.norm(way))


def _across(tangent: FloatArray) -> FloatArray:
    """A level way across a tangent; x where the tangent is vertical."""
    level = np.cross(np.array([0.0, 0.0, 1.0]), tangent)
    length = float(np.linalg.norm(level))
    return level / length if length > 0.2 else np.array([1.0, 0.0, 0.0])


def _inside(mesh: TetMesh, axis: FloatArray, offset: FloatArray) -> FloatArray:
    """Vertices axis + offset, brought towards the axis until they lie in the mesh."""
    vertices = axis + offset
    nearest = min(NEAR, len(mesh.tets))
    for _ in range(12):
        found = locate(mesh.points, mesh.tets, vertices, nearest=nearest)
        outside = found.weights.min(axis=1) < 0.0
        if not outside.any():
            return vertices
        offset = np.where(outside[:, None], PULLED_IN * offset, offset)
        vertices = axis + offset
    # An axis that leaves the body itself is taken to the middle of the nearest tet.
    middles = mesh.points[mesh.tets[found.tets]].mean(axis=1)
    return np.where(outside[:, None], middles, vertices)
