"""The cones of the contact modes (``mode_table``) as padded arrays.

Built for all contacts at once, since directional friction changes them in every step.
"""

from __future__ import annotations

import itertools
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from warp_softbody.arrays import BoolArray, FloatArray, cross_rows

FIRST_SLIDE = 2
"""Number of the first sliding mode; lift and stick come before it."""

COLLINEAR = 1e-12
"""Twice the area of a triangle, over the square of the farthest corner's distance, up to which its
middle corner lies on the line between the others."""

SLIM = 1e-3
"""Friction below which rows on the force of a cone are scaled up with its width: over unit rows
forces that pull on the ground by the tolerance over the friction would be inside."""


class ModeCones(NamedTuple):
    """Arrays as in ``ModeTable``; ``equalities`` (K, M, 3, 6) are unit rows zero on the cone."""

    force_basis: FloatArray
    velocity_constraints: FloatArray
    inequalities: FloatArray
    inequality_used: BoolArray
    equalities: FloatArray
    rays: FloatArray


def frictional_cones(radius: FloatArray, directions: bytes) -> ModeCones:
    """The modes of contacts whose friction cones have corners (1, radius d_j), radius (K, m)."""
    plane = np.frombuffer(directions).reshape(-1, 2)
    k, m = radius.shape
    cones = repeated(_constant(directions), k)
    corners = np.empty((k, m, 3))
    corners[:, :, 0] = 1.0
    np.multiply(radius[:, :, None], plane, out=corners[:, :, 1:])
    following = (np.arange(m) + 1) % m
    others = corners[:, following]
    rays, normals = _unit(corners), cross_rows(corners, others)
    slide, edge = slice(FIRST_SLIDE, FIRST_SLIDE + m), slice(FIRST_SLIDE + m, None)
    cones.force_basis[:, slide, :, 0] = cones.force_basis[:, edge, :, 0] = corners
    cones.force_basis[:, edge, :, 1] = others
    # The ray turned by a quarter in its vertical plane.
    cones.equalities[:, slide, 0, 0] = -radius * rays[:, :, 0]
    cones.equalities[:, slide, 0, 1:3] = plane * rays[:, :, :1]
    cones.equalities[:, edge, 0, :3] = _unit(normals)
    # The share of either corner in a force between the two, zero at the other corner.
    cones.inequalities[:, edge, 0, :3] = _unit(cross_rows(others, normals))
    cones.inequalities[:, edge, 1, :3] = _unit(cross_rows(normals, corners))
    cones.rays[:, 1, :m, :3] = cones.rays[:, slide, 0, :3] = cones.rays[:, edge, 0, :3] = rays
    cones.rays[:, edge, 1, :3] = rays[:, following]
    _fill_facets(cones, corners)
    slim = radius.min(axis=1) < SLIM
    if slim.any():
        width = radius.max(axis=1)[slim, None, None, None]
        cones.inequalities[slim, 1:2, :, :3] /= width
        cones.inequalities[slim, edge, :2, :3] /= width
    return cones


def frictionless_cones(count: int, directions: bytes) -> ModeCones:
    """The modes of contacts without friction: lift, and slide 0 in place of all others."""
    cones = repeated(_constant(directions), count)
    axes = np.eye(3)
    for part in cones:
        part[:, 1:] = 0
    cones.force_basis[:, 1:, :, 0] = cones.velocity_constraints[:, 1:, 0] = axes[0]
    cones.inequalities[:, 1:, 0, :3] = axes[0]
    cones.inequality_used[:, 1:, 0] = True
    cones.equalities[:, 1:, :2, :3], cones.equalities[:, 1:, 2, 3:] = axes[1:], axes[0]
    cones.rays[:, 1:, 0, :3], cones.rays[:, 1:, 1:5, 3:] = axes[0], _plane_rays()
    return cones


def repeated(cones: ModeCones, count: int) -> ModeCones:
    """The same modes for ``count`` contacts, with a first axis for these."""
    copies: list[Any] = [np.repeat(part[None], count, axis=0) for part in cones]
    return ModeCones(*copies)


@lru_cache(maxsize=8)
def _constant(directions: bytes) -> ModeCones:
    """What does not depend on friction, without a first axis for the contacts."""
    plane = np.frombuffer(directions).reshape(-1, 2)
    m, axes = len(plane), np.eye(3)
    count, row_count, ray_count = 2 + 2 * m, max(m, 3), max(m, 5)
    basis, constraints = np.zeros((count, 3, 3)), np.zeros((count, 3, 3))
    rows, used = np.zeros((count, row_count, 6)), np.zeros((count, row_count), bool)
    equalities, rays = np.zeros((count, 3, 6)), np.zeros((count, ray_count, 6))
    rows[0, 0, 3:], used[0, 0] = axes[0], True
    equalities[0, :, :3], equalities[1, :, 3:] = axes, axes
    rays[0, 0, 3:], rays[0, 1:5, 3:] = axes[0], _plane_rays()
    basis[1] = constraints[1] = axes
    away = [_tangent(-(plane[j] + plane[(j + 1) % m])) for j in range(m)]
    for j in range(m):
        slide, edge = FIRST_SLIDE + j, FIRST_SLIDE + m + j
        constraints[slide, 0] = constraints[edge, 0] = axes[0]
        constraints[edge, 1] = _tangent(plane[j] - plane[(j + 1) % m])
        rows[slide, 0, :3], used[slide, :3] = axes[0], True
        rows[slide, 1:3, 3:] = [_tangent(plane[i % m] - plane[j]) for i in (j - 1, j + 1)]
        rows[edge, 2, 3:], used[edge, :3] = away[j], True
        equalities[slide, 1, 1:3] = [-plane[j][1], plane[j][0]]
        equalities[slide, 2, 3:] = axes[0]
        equalities[edge, 1:, 3:] = constraints[edge, :2]
        rays[slide, 1:3, 3:] = [away[j - 1], away[j]]
        rays[edge, 2, 3:] = away[j]
    return ModeCones(basis, constraints, rows, used, equalities, rays)


def _fill_facets(cones: ModeCones, corners: FloatArray) -> None:
    """Inward unit normals of the facets of each cone of corners (K, m, 3) as rows of stick.

    With unequal radii some corners lie inside the hull of the others: fewer facets than corners.
    """
    facets = [_hull(points) for points in corners[:, :, 1:].tolist()]
    ends = np.array([pair for pairs in facets for pair in pairs])
    owner = np.repeat(np.arange(len(facets)), [len(pairs) for pairs in facets])
    place = np.concatenate([np.arange(len(pairs)) for pairs in facets])
    normals = _unit(cross_rows(corners[owner, ends[:, 0]], corners[owner, ends[:, 1]]))
    normals *= np.sign(normals[:, :1])
    cones.inequalities[owner, 1, place, :3] = normals
    cones.inequality_used[owner, 1, place] = True


def _hull(points: list[list[float]]) -> list[tuple[int, int]]:
    """Ends of the edges of the hull of points (m, 2) that go round the origin in order.

    By Graham's scan from the farthest point; one that lies on an edge is left out.
    """
    sizes = [x * x + y * y for x, y in points]
    start, flat = sizes.index(max(sizes)), COLLINEAR * max(sizes)
    hull = [start]
    for step in range(1, len(points) + 1):
        following = (start + step) % len(points)
        x, y = points[following]
        while len(hull) > 1:
            (ax, ay), (bx, by) = points[hull[-2]], points[hull[-1]]
            if (bx - ax) * (y - ay) - (by - ay) * (x - ax) > flat:
                break
            hull.pop()
        hull.append(following)
    return sorted((min(a, b), max(a, b)) for a, b in itertools.pairwise(hull))


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
