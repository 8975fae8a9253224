"""Bodies that coincide at the start are refused, because no direction separates them."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.errors import InputError
from warp_softbody.world.scene import Scene

SAME = 0.06
"""Part of an edge's length by which the boxes around two bodies may differ and count as the same;
a little more than a node may be off a surface and on it (kernels/contact/pair_detection.py)."""

SAMPLES = 64
"""Tets whose centres are tried."""


def refuse_coincident(scene: Scene) -> None:
    """Refuse bodies that are in each other with their surfaces on one another.

    Raises:
        InputError: with the names and how deep they are in each other.
    """
    boxes = [(c.mesh.points.min(axis=0), c.mesh.points.max(axis=0)) for c in scene.characters]
    for (a, one), (b, two) in combinations(enumerate(scene.characters), 2):
        (low, high), (other_low, other_high) = boxes[a], boxes[b]
        slack = SAME * max(_edge(one), _edge(two))
        same = np.abs(low - other_low) < slack, np.abs(high - other_high) < slack
        if np.all(same) and _share_inside(one, two) > 0.5:
            depth = float((np.minimum(high, other_high) - np.maximum(low, other_low)).min())
            raise InputError(
                f"bodies {one.name!r} and {two.name!r} fill the same place, {depth:.3g} m deep in "
                "each other, and no way leads apart; place one of them elsewhere"
            )


def _edge(body: Character) -> float:
    corners = body.mesh.points[body.mesh.surface]
    return float(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).mean())


def _share_inside(one: Character, two: Character) -> float:
    """Share of the centres of some tets of one body that are inside of another."""
    tets = one.mesh.tets[:: max(1, len(one.mesh.tets) // SAMPLES)]
    centres = one.mesh.points[tets].mean(axis=1)
    return float(np.mean([_winding(p, two.mesh.points[two.mesh.surface]) > 0.5 for p in centres]))


def _winding(point: FloatArray, corners: FloatArray) -> float:
    """How often a closed surface of triangles winds about a point (van Oosterom, Strackee 1983)."""
    a, b, c = (corners[:, k] - point for k in range(3))
    lengths = [np.linalg.norm(side, axis=1) for side in (a, b, c)]
    volume = np.einsum("ij,ij->i", a, np.cross(b, c))
    across = lengths[0] * lengths[1] * lengths[2]
    across += np.einsum("ij,ij->i", a, b) * lengths[2]
    across += np.einsum("ij,ij->i", b, c) * lengths[0]
    across += np.einsum("ij,ij->i", c, a) * lengths[1]
    return float(2.0 * np.arctan2(volume, across).sum() / (4.0 * np.pi))
