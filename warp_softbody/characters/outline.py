"""A letter's closed surface is an outline in the x-z plane, extruded along y.

The caps are Delaunay triangulations that hold every edge of the outline. An edge that Delaunay
leaves out is split at its middle until none is missing, so outlines may turn inward and have holes.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.errors import InputError

if TYPE_CHECKING:
    import trimesh

IntArray = npt.NDArray[np.int64]

SPLIT_ROUNDS = 12
"""Halvings of one side before the outline is called crossed."""

CLEARANCE = 0.6
"""Least distance of a grid point inside the cap from the outline, over the size."""

FLAT = 1e-9
"""A triangle of the cap with less area than this times the size squared is none."""


def extruded_outline(
    outline: npt.ArrayLike,
    y_range: tuple[float, float],
    size: float,
    *,
    holes: Sequence[npt.ArrayLike] = (),
) -> trimesh.Trimesh:
    """Close the surface swept by an outline in the x-z plane between two values of y.

    Args:
        outline: (k, 2) corners x, z in m, in order around the outline, either way round.
        y_range: lower and upper y of the two caps, m.
        size: longest piece of the outline and spacing of the points inside the caps, m; longer
            sides are divided evenly.
        holes: outlines of holes, each (k, 2) m, strictly inside and apart from each other.

    Returns:
        A closed surface with outward triangles.

    Raises:
        InputError: fewer than three corners, values that are not finite, an empty range or size,
            or loops that cross.
    """
    low, high = y_range
    if not (np.isfinite([low, high, size]).all() and size > 0.0 and high > low):
        raise InputError(
            f"an extruded outline needs a positive size and a rising y_range, "
            f"got size {size!r} and y_range {y_range!r}"
        )
    loops = [_divided(_checked_loop("outline", outline, turn=1.0), size)]
    loops += [
        _divided(_checked_loop(f"holes[{i}]", hole, turn=-1.0), size)
        for i, hole in enumerate(holes)
    ]
    loops, cap_points, cap = _triangulated_cap(loops, size)
    rows = np.linspace(low, high, max(1, int(np.ceil((high - low) / size - 1e-9))) + 1)
    return _swept(loops, cap_points, cap, rows)


def _checked_loop(name: str, corners: npt.ArrayLike, *, turn: float) -> FloatArray:
    """Corners (k, 2), turned anticlockwise (turn 1: outside) or clockwise (turn -1: a hole)."""
    loop = np.array(corners, dtype=np.float64)
    if loop.ndim != 2 or loop.shape[1] != 2 or len(loop) < 3:
        raise InputError(f"{name} needs corners of shape (k >= 3, 2), got {loop.shape}")
    if not np.isfinite(loop).all():
        raise InputError(f"{name} has corners that are not finite")
    area = _area(loop)
    if area == 0.0:
        raise InputError(f"{name} encloses no area")
    return loop if area * turn > 0.0 else loop[::-1].copy()


def _area(loop: FloatArray) -> float:
    """Signed area of a polygon (k, 2), positive when anticlockwise."""
    following = np.roll(loop, -1, axis=0)
    return 0.5 * float(np.sum(loop[:, 0] * following[:, 1] - loop[:, 1] * following[:, 0]))


def _divided(loop: FloatArray, size: float) -> FloatArray:
    """Divide every side evenly into pieces no longer than size."""
    pieces = []
    for start, end in zip(loop, np.roll(loop, -1, axis=0), strict=True):
        count = max(1, int(np.ceil(np.linalg.norm(end - start) / size - 1e-9)))
        pieces.append(start + np.arange(count)[:, None] / count * (end - start))
    return np.concatenate(pieces)


def _edges(loops: Sequence[FloatArray]) -> IntArray:
    """Edges (e, 2) of all loops, as indices into their concatenated points."""
    edges, first = [], 0
    for loop in loops:
        index = first + np.arange(len(loop))
        edges.append(np.stack([index, np.roll(index, -1)], axis=1))
        first += len(loop)
    return np.concatenate(edges)


def _inside(points: FloatArray, loops: Sequence[FloatArray]) -> npt.NDArray[np.bool_]:
    """Which points (n, 2) lie inside, by the even-odd rule over all loops."""
    inside = np.zeros(len(points), dtype=bool)
    x, z = points[:, 0], points[:, 1]
    for loop in loops:
        for (x0, z0), (x1, z1) in zip(loop, np.roll(loop, -1, axis=0), strict=True):
            if z0 != z1:
                crossing = x0 + (z - z0) * (x1 - x0) / (z1 - z0)
                inside ^= ((z0 > z) != (z1 > z)) & (x < crossing)
    return inside


def _distance(points: FloatArray, loops: Sequence[FloatArray]) -> FloatArray:
    """Distance in m of each point (n, 2) to the nearest side of any loop."""
    nearest = np.full(len(points), np.inf)
    for loop in loops:
        for start, end in zip(loop, np.roll(loop, -1, axis=0), strict=True):
            side = end - start
            along = np.clip((points - start) @ side / (side @ side), 0.0, 1.0)
            gap = np.linalg.norm(points - start - along[:, None] * side, axis=1)
            np.minimum(nearest, gap, out=nearest)
    return nearest


def _interior_points(loops: Sequence[FloatArray], size: float) -> FloatArray:
    """Triangular grid inside the outline, mirrored about its middle in x, clear of its sides."""
    low, high = loops[0].min(axis=0), loops[0].max(axis=0)
    middle = 0.5 * (low + high)
    reach = int(np.ceil((high[0] - low[0]) / size)) + 1
    row_height = size * np.sqrt(0.75)
    row_reach = int(np.ceil((high[1] - low[1]) / row_height)) + 1
    grid = [
        (middle[0] + (i + 0.5 * (row % 2)) * size, middle[1] + row * row_height)
        for row in range(-row_reach, row_reach + 1)
        for i in range(-reach, reach + 1)
    ]
    points = np.array(grid)
    clear = _distance(points, loops) > CLEARANCE * size
    return points[_inside(points, loops) & clear]


def _triangulated_cap(
    loops: list[FloatArray], size: float
) -> tuple[list[FloatArray], FloatArray, IntArray]:
    """Loops (split where needed), points (loops first) and anticlockwise triangles of the cap."""
    # stored meshes need no outline, and the library takes a while to load
    from scipy.spatial import Delaunay

    interior = _interior_points(loops, size)
    for _ in range(SPLIT_ROUNDS):
        points = np.concatenate([*loops, interior])
        triangles = Delaunay(points).simplices.astype(np.int64)
        triangles = _anticlockwise(points, triangles, size)
        triangles = triangles[_inside(points[triangles].mean(axis=1), loops)]
        pairs = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        present = {(int(a), int(b)) for a, b in pairs}
        missing = [(int(min(edge)), int(max(edge))) not in present for edge in _edges(loops)]
        if not any(missing):
            return loops, points, triangles
        loops = _split(loops, np.array(missing))
    raise InputError("the outline cannot be triangulated: its loops cross or touch")


def _anticlockwise(points: FloatArray, triangles: IntArray, size: float) -> IntArray:
    """Turn every triangle (t, 3) of the plane anticlockwise, and drop those with no area.

    Rounding leaves such slivers outside a side whose points lie in a row.
    """
    a, b, c = (points[triangles[:, i]] for i in range(3))
    area = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    turned = np.where(area[:, None] < 0.0, triangles[:, ::-1], triangles)
    return turned[np.abs(area) > FLAT * size * size]


def _split(loops: Sequence[FloatArray], missing: npt.NDArray[np.bool_]) -> list[FloatArray]:
    """Put a point in the middle of every side marked as missing."""
    result, first = [], 0
    for loop in loops:
        sides = np.flatnonzero(missing[first : first + len(loop)])
        middles = 0.5 * (loop + np.roll(loop, -1, axis=0))[sides]
        result.append(np.insert(loop, sides + 1, middles, axis=0))
        first += len(loop)
    return result


def _swept(
    loops: Sequence[FloatArray], cap_points: FloatArray, cap: IntArray, rows: FloatArray
) -> trimesh.Trimesh:
    """Join the two caps by walls with one row of quads, each cut in two, between values of y."""
    import trimesh

    edges = _edges(loops)
    ring, count, last = sum(map(len, loops)), len(cap_points), len(rows) - 1
    # Rows of points: the whole near cap, bare rings between, the whole far cap.
    layers = [cap_points, *[cap_points[:ring]] * (last - 1), cap_points]
    starts = np.cumsum([0] + [len(layer) for layer in layers[:-1]])
    points = np.concatenate(
        [
            np.stack([layer[:, 0], np.full(len(layer), y), layer[:, 1]], axis=1)
            for layer, y in zip(layers, rows, strict=True)
        ]
    )
    # Anticlockwise in (x, z) is clockwise seen from +y, so the near cap already faces -y.
    faces = [cap, cap[:, ::-1] + (len(points) - count)]
    for near, far in pairwise(starts):
        a, b = edges[:, 0], edges[:, 1]
        faces.append(np.stack([a + near, a + far, b + near], axis=1))
        faces.append(np.stack([b + near, a + far, b + far], axis=1))
    return trimesh.Trimesh(vertices=points, faces=np.concatenate(faces), process=False)
