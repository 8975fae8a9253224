"""Rays against triangles: the one file that knows Embree, the optional extra `view`.

Embree runs on the processor from a wheel of its own, so pictures need neither a display nor a
graphics driver, and look the same on every machine.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import BoolArray, FloatArray
from warp_softbody.errors import MissingExtraError
from warp_softbody.stage_exports.conventions import IntArray


class Hits(NamedTuple):
    """Where rays meet a surface first.

    Attributes:
        distance: (r,) m along unit directions; infinite for a miss.
        face: (r,) triangle, -1 for a miss.
        weights: (r, 3) of the triangle's corners.
    """

    distance: FloatArray
    face: IntArray
    weights: FloatArray


class Caster:
    """A triangle surface that answers rays; without triangles every ray misses."""

    def __init__(self, points: FloatArray, faces: IntArray) -> None:
        """Build the search tree."""
        self._scene: Any = None
        if len(faces):
            scene_module, mesh_module = _embree()
            self._scene = scene_module.EmbreeScene()
            vertices = np.ascontiguousarray(points, dtype=np.float32)
            mesh_module.TriangleMesh(self._scene, vertices, np.ascontiguousarray(faces, np.int32))

    def first(self, origins: FloatArray, directions: FloatArray) -> Hits:
        """First hit of each ray."""
        count = len(origins)
        if self._scene is None or not count:
            missed = np.full(count, -1, dtype=np.int32)
            return Hits(np.full(count, np.inf), missed, np.zeros((count, 3)))
        found = self._scene.run(_single(origins), _single(directions), output=1)
        face = np.asarray(found["primID"], dtype=np.int32)
        distance = np.where(face < 0, np.inf, found["tfar"])
        u, v = np.asarray(found["u"]), np.asarray(found["v"])
        return Hits(distance, face, np.stack([1.0 - u - v, u, v], axis=1))

    def blocks(self, origins: FloatArray, directions: FloatArray) -> BoolArray:
        """Whether anything stands in each ray's way."""
        if self._scene is None or not len(origins):
            return np.zeros(len(origins), dtype=bool)
        found = self._scene.run(_single(origins), _single(directions), query="OCCLUDED")
        return np.asarray(found) >= 0


def _single(vectors: FloatArray) -> npt.NDArray[np.float32]:
    return np.ascontiguousarray(vectors, dtype=np.float32)


def _embree() -> tuple[Any, Any]:
    try:
        from embreex import mesh_construction, rtcore_scene
    except ImportError as error:
        raise MissingExtraError(
            "pictures need Embree, which is not installed: pip install 'warp-softbody[view]'"
        ) from error
    return rtcore_scene, mesh_construction
