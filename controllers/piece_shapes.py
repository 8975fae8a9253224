"""The pieces of several contacts as padded arrays; what each means is said in ``pieces``.

Built for all contacts at once, since directional friction changes them in every step.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from warp_softbody.controllers.qpcc import FloatArray

BoolArray = npt.NDArray[np.bool_]

FIRST_SLIDE = 2
"""Lift and stick come first."""


class Shapes(NamedTuple):
    """As in ``PieceTable``; ``equality`` (K, M, 3, 6) holds the rows that vanish on a piece."""

    basis: FloatArray
    still: FloatArray
    rows: FloatArray
    used: BoolArray
    equality: FloatArray
    rays: FloatArray


def frictional_shapes(radius: FloatArray, directions: bytes) -> Shapes:
    """All pieces of contacts whose friction cones have corners (1, radius d_j), radius (K, m)."""
    plane = np.frombuffer(directions).reshape(-1, 2)
    k, m = radius.shape
    shapes = repeated(_constant(directions), k)
    following = np.roll(np.arange(m), -1)
    corners = np.concatenate([np.ones((k, m, 1)), radius[:, :, None] * plane], axis=2)
    others = corners[:, following]
    edges = np.stack([_unit(corners), _unit(others)], axis=2)
    slide, edge = slice(FIRST_SLIDE, FIRST_SLIDE + m), slice(FIRST_SLIDE + m, None)
    shapes.basis[:, slide, :, 0] = shapes.basis[:, edge, :, 0] = corners
    shapes.basis[:, edge, :, 1] = others
    shapes.equality[:, slide, 0, :3] = _unit(
        np.concatenate([-radius[:, :, None], np.broadcast_to(plane, (k, m, 2))], axis=2)
    )
    shapes.equality[:, edge, 0, :3] = _unit(np.cross(corners, others))
    inverse = np.linalg.pinv(np.stack([corners, others], axis=3))
    shapes.rows[:, edge, :2, :3] = _unit(inverse)
    shapes.rays[:, 1, :m, :3] = shapes.rays[:, slide, 0, :3] = edges[:, :, 0]
    shapes.rays[:, edge, :2, :3] = edges
    _fill_facets(shapes, corners)
    return shapes


def frictionless_shapes(count: int, directions: bytes) -> Shapes:
    """The pieces of contacts without friction: lift, and slide 0 in place of all others."""
    shapes = repeated(_constant(directions), count)
    axes = np.eye(3)
    for part in shapes:
        part[:, 1:] = 0
    shapes.basis[:, 1:, :, 0] = shapes.still[:, 1:, 0] = axes[0]
    shapes.rows[:, 1:, 0, :3] = axes[0]
    shapes.used[:, 1:, 0] = True
    shapes.equality[:, 1:, :2, :3], shapes.equality[:, 1:, 2, 3:] = axes[1:], axes[0]
    shapes.rays[:, 1:, 0, :3], shapes.rays[:, 1:, 1:5, 3:] = axes[0], _plane_rays()
    return shapes


def repeated(shapes: Shapes, count: int) -> Shapes:
    """The same pieces for ``count`` contacts, with a first axis for these."""
    copies: list[Any] = [np.repeat(part[None], count, axis=0) for part in shapes]
    return Shapes(*copies)


@lru_cache(maxsize=8)
def _constant(directions: bytes) -> Shapes:
    plane = np.frombuffer(directions).reshape(-1, 2)
    m, axes = len(plane), np.eye(3)
    count, row_count, ray_count = 2 + 2 * m, max(m, 3), max(m, 5)
    basis, still = np.zeros((count, 3, 3)), np.zeros((count, 3, 3))
    rows, used = np.zeros((count, row_count, 6)), np.zeros((count, row_count), bool)
    equality, rays = np.zeros((count, 3, 6)), np.zeros((count, ray_count, 6))
    rows[0, 0, 3:], used[0, 0] = axes[0], True
    equality[0, :, :3], equality[1, :, 3:] = axes, axes
    rays[0, 0, 3:], rays[0, 1:5, 3:] = axes[0], _plane_rays()
    basis[1] = still[1] = axes
    away = [_tangent(-(plane[j] + plane[(j + 1) % m])) for j in range(m)]
    for j in range(m):
        slide, edge = FIRST_SLIDE + j, FIRST_SLIDE + m + j
        still[slide, 0] = still[edge, 0] = axes[0]
        still[edge, 1] = _tangent(plane[j] - plane[(j + 1) % m])
        rows[slide, 0, :3], used[slide, :3] = axes[0], True
        rows[slide, 1:3, 3:] = [_tangent(plane[i % m] - plane[j]) for i in (j - 1, j + 1)]
        rows[edge, 2, 3:], used[edge, :3] = away[j], True
        equality[slide, 1, 1:3] = [-plane[j][1], plane[j][0]]
        equality[slide, 2, 3:] = axes[0]
        equality[edge, 1:, 3:] = still[edge, :2]
        rays[slide, 1:3, 3:] = [away[j - 1], away[j]]
        rays[edge, 2, 3:] = away[j]
    return Shapes(basis, still, rows, used, equality, rays)


def _fill_facets(shapes: Shapes, corners: FloatArray) -> None:
    """Inward unit normals of the facets of each cone of corners (K, m, 3) as rows of stick.

    With unequal radii some corners lie inside the hull of the others: fewer facets than corners.
    """
    k, m = corners.shape[:2]
    first, second = np.triu_indices(m, 1)
    normals = np.cross(corners[:, first], corners[:, second])
    size = np.sqrt(_square(normals))
    usable = (size >= 1e-12) & (np.abs(normals[..., 0]) >= 1e-12 * size)
    normals *= (np.sign(normals[..., 0]) / np.where(usable, size, 1.0))[..., None]
    usable &= (normals @ corners.transpose(0, 2, 1)).min(axis=2) >= -1e-10
    for contact in range(k):
        found = normals[contact, usable[contact]]
        # Corners in one plane span it more than once.
        close = np.abs(found[:, None] - found).max(axis=2) <= 1e-9
        found = found[~np.tril(close, -1).any(axis=1)]
        shapes.rows[contact, 1, : len(found), :3] = found
        shapes.used[contact, 1, : len(found)] = True


def _plane_rays() -> FloatArray:
    axes = np.eye(3)
    return np.stack([axes[1], axes[2], -axes[1], -axes[2]])


def _square(vectors: FloatArray) -> FloatArray:
    squares: FloatArray = (vectors[..., None, :] @ vectors[..., :, None])[..., 0, 0]
    return squares


def _unit(vectors: FloatArray) -> FloatArray:
    units: FloatArray = vectors / np.sqrt(_square(vectors))[..., None]
    return units


def _tangent(vector: FloatArray) -> FloatArray:
    return np.concatenate([np.zeros(1), _unit(vector)])
