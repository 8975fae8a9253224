"""Skins are cut along sharp edges, so that any viewer draws these sharp and all else smooth.

Stages leave normals to viewers, which average those of the faces around a point. Where faces meet
at more than a crease's angle at rest, each side therefore gets a point of its own; the cut is made
once for a take.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from warp_softbody.arrays import FloatArray
from warp_softbody.stage_exports.conventions import IntArray

CREASE_DEGREES = 40.0
"""Angle between faces at rest from which their edge is sharp."""


class CutSurface(NamedTuple):
    """Mesh node behind each point (k,), ascending, and triangles (f, 3) over points."""

    nodes: IntArray
    faces: IntArray


def cut_along_creases(points: FloatArray, surface: IntArray) -> CutSurface:
    """The surface (f, 3) over points (n, 3) m, with a point for each smooth fan of faces."""
    corners = surface.reshape(-1)
    fans = _fans(points, surface)
    order = np.lexsort((fans, corners))
    keys = np.stack([corners[order], fans[order]], axis=1)
    first = np.concatenate([[True], (np.diff(keys, axis=0) != 0).any(axis=1)])
    numbers = np.empty(len(corners), dtype=np.int32)
    numbers[order] = np.cumsum(first) - 1
    return CutSurface(keys[first, 0].astype(np.int32), numbers.reshape(surface.shape))


def _fans(points: FloatArray, surface: IntArray) -> IntArray:
    """(3 f,) a number for each corner, the same where smooth edges join faces at its point."""
    normals = _unit_normals(points, surface)
    heads, tails = surface.reshape(-1), np.roll(surface, -1, axis=1).reshape(-1)
    edges = np.stack([np.minimum(heads, tails), np.maximum(heads, tails)], axis=1)
    _, labels, counts = np.unique(edges, axis=0, return_inverse=True, return_counts=True)
    order = np.argsort(labels.reshape(-1), kind="stable")
    # an edge between more than two faces is sharp
    pairs = order[(counts[labels.reshape(-1)] == 2)[order]].reshape(-1, 2)
    cosines = np.einsum("ij,ij->i", normals[pairs[:, 0] // 3], normals[pairs[:, 1] // 3])
    pairs = pairs[cosines > np.cos(np.radians(CREASE_DEGREES))]
    ends = _corner_pairs(heads, pairs)
    size = len(heads)
    joined = sparse.coo_array((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(size, size))
    return np.asarray(connected_components(joined, directed=False)[1], dtype=np.int32)


def _corner_pairs(heads: IntArray, pairs: IntArray) -> IntArray:
    """Corners that two faces have at both ends of an edge; an edge begins at its own corner."""
    following = np.arange(len(heads)).reshape(-1, 3)[:, [1, 2, 0]].reshape(-1)
    one, other = pairs[:, 0], pairs[:, 1]
    against = heads[one] != heads[other]
    start = np.where(against, following[other], other)
    end = np.where(against, other, following[other])
    return np.concatenate(
        [np.stack([one, start], axis=1), np.stack([following[one], end], axis=1)]
    ).astype(np.int32)


def _unit_normals(points: FloatArray, faces: IntArray) -> FloatArray:
    a, b, c = (points[faces[:, corner]] for corner in range(3))
    normals = np.cross(b - a, c - a)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.asarray(np.divide(normals, length, out=np.zeros_like(normals), where=length > 0.0))


def rim(faces: IntArray) -> IntArray:
    """Points, ascending, of edges that only one triangle of (f, 3) has."""
    heads, tails = faces.reshape(-1), np.roll(faces, -1, axis=1).reshape(-1)
    edges = np.stack([np.minimum(heads, tails), np.maximum(heads, tails)], axis=1)
    alone, counts = np.unique(edges, axis=0, return_counts=True)
    return np.unique(alone[counts == 1]).astype(np.int32)
