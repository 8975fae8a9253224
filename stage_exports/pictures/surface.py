"""Pictures need shading normals of a triangle surface and tubes around line segments."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy import sparse

from warp_softbody.arrays import FloatArray
from warp_softbody.stage_exports.conventions import IntArray
from warp_softbody.stage_exports.creases import CREASE_DEGREES

_TUBE_SIDES = 6


def normalized(vectors: npt.ArrayLike) -> FloatArray:
    """Unit vectors; a vector of length zero stays zero."""
    array = np.asarray(vectors, dtype=np.float64)
    length = np.linalg.norm(array, axis=-1, keepdims=True)
    return np.asarray(np.divide(array, length, out=np.zeros_like(array), where=length > 0.0))


def face_normals(points: FloatArray, faces: IntArray) -> FloatArray:
    """(f, 3) normals, as long as twice the triangles' areas."""
    a, b, c = (points[faces[:, corner]] for corner in range(3))
    return np.asarray(np.cross(b - a, c - a))


class CornerNormals:
    """Smooth normals with sharp edges, one a triangle corner.

    Which faces share a normal is decided once, at rest: an edge does not flicker in a movie.
    """

    def __init__(self, rest: FloatArray, faces: IntArray) -> None:
        """Join each corner with the faces around its point that are not beyond a crease."""
        self._faces = faces
        corners = faces.reshape(-1)
        order = np.argsort(corners, kind="stable")
        starts = np.searchsorted(corners[order], np.arange(len(rest) + 1))
        counts = np.diff(starts)[corners]
        rows = np.repeat(np.arange(len(corners)), counts)
        within = np.arange(len(rows)) - np.repeat(np.cumsum(counts) - counts, counts)
        columns = order[np.repeat(starts[corners], counts) + within] // 3
        normals = normalized(face_normals(rest, faces))
        cosines = np.einsum("ij,ij->i", normals[rows // 3], normals[columns])
        smooth = cosines > np.cos(np.radians(CREASE_DEGREES))
        self._join = sparse.csr_matrix(
            (np.ones(int(smooth.sum())), (rows[smooth], columns[smooth])),
            shape=(len(corners), len(faces)),
        )

    def at(self, points: FloatArray) -> FloatArray:
        """(f, 3, 3) unit normals of the corners of every face."""
        summed = self._join @ face_normals(points, self._faces)
        return normalized(summed).reshape(-1, 3, 3)


def tubes(segments: FloatArray, radii: FloatArray) -> tuple[FloatArray, IntArray]:
    """Triangles of open prisms around segments (s, 2, 3) of radii (s,), equally many of each."""
    radius = radii[:, None, None]
    axis = normalized(segments[:, 1] - segments[:, 0])
    helper = np.eye(3)[np.argmin(np.abs(axis), axis=1)]
    first = normalized(np.cross(axis, helper))
    second = np.cross(axis, first)
    angles = 2.0 * np.pi * np.arange(_TUBE_SIDES) / _TUBE_SIDES
    ring = np.cos(angles)[:, None, None] * first + np.sin(angles)[:, None, None] * second
    # Rings reach a little beyond the ends, so that a bent fibre shows no gaps.
    ends = segments + radius * 0.5 * np.stack([-axis, axis], axis=1)
    points = ends[:, :, None, :] + (radius * ring.transpose(1, 0, 2))[:, None, :, :]
    near = np.arange(_TUBE_SIDES)
    far = (near + 1) % _TUBE_SIDES
    one = np.stack([near, far, far + _TUBE_SIDES, near, far + _TUBE_SIDES, near + _TUBE_SIDES], 1)
    start = 2 * _TUBE_SIDES * np.arange(len(segments))
    faces = start[:, None] + one.reshape(1, -1)
    return points.reshape(-1, 3), faces.reshape(-1, 3).astype(np.int32)


FACES_PER_TUBE = 2 * _TUBE_SIDES
