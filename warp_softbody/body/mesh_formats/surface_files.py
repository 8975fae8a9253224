"""Surface files are read by strict readers, which open no other file."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from warp_softbody.body.mesh_formats.contents import ReadingFailed
from warp_softbody.body.mesh_formats.obj import read_obj
from warp_softbody.body.mesh_formats.off import read_off
from warp_softbody.body.mesh_formats.ply import read_ply
from warp_softbody.body.mesh_formats.polygons import Polygons, Triangles
from warp_softbody.body.mesh_formats.stl import read_stl

READERS: dict[str, Callable[[Path], Polygons]] = {
    ".stl": read_stl,
    ".obj": read_obj,
    ".ply": read_ply,
    ".off": read_off,
}
"""By extension, lower case with the dot."""


def read_surface(path: Path) -> Triangles:
    """Points and triangles of a surface file; polygons are cut from their first corner.

    Raises:
        ReadingFailed: it is no file of its format, or holds more or less than it declares.
        OSError: it cannot be opened.
    """
    try:
        points, polygons = READERS[path.suffix.lower()](path)
        array = np.array(points, dtype=np.float64).reshape(-1, 3)
        return Triangles(array, _triangles(polygons, len(array)))
    except (ValueError, IndexError, OverflowError, MemoryError, RecursionError) as error:
        raise ReadingFailed(" ".join(str(error).split())[:200] or type(error).__name__) from error


def _triangles(
    polygons: npt.NDArray[np.int64] | Sequence[Sequence[int]], count: int
) -> npt.NDArray[np.int64]:
    """Corners (f, 3) of polygons over ``count`` points."""
    if isinstance(polygons, np.ndarray) and polygons.ndim == 2 and polygons.shape[1] >= 3:
        fans = [polygons[:, [0, k, k + 1]] for k in range(1, polygons.shape[1] - 1)]
        polygons = np.stack(fans, axis=1)
    else:
        short = next((k for k, corners in enumerate(polygons) if len(corners) < 3), None)
        if short is not None:
            raise ReadingFailed(f"face {short} has {len(polygons[short])} corners")
        polygons = [
            (corners[0], corners[k], corners[k + 1])
            for corners in polygons
            for k in range(1, len(corners) - 1)
        ]
    triangles = np.array(polygons, dtype=np.int64).reshape(-1, 3)
    wrong = triangles[(triangles < 0) | (triangles >= count)]
    if wrong.size:
        raise ReadingFailed(f"a face has point {wrong[0]}, but there are points 0 to {count - 1}")
    return triangles
