"""What a run leaves for its chart: frames of all nodes, and the places of some material points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from warp_softbody.arrays import FloatArray
from warp_softbody.world.scene import Scene

IntArray = npt.NDArray[np.int32]

MOST_POINTS = 200
NEAREST = 64


@dataclass(frozen=True, kw_only=True)
class Track:
    """A body, or several, over time.

    Attributes:
        scene: what was run.
        times: (f,) s.
        points: (f, n, 3) m, all nodes.
        masses: (n,) kg.
    """

    scene: Scene
    times: FloatArray
    points: FloatArray
    masses: FloatArray

    @property
    def centers(self) -> FloatArray:
        """Centre of mass of all bodies, (f, 3) m."""
        return np.asarray(self.masses @ self.points / self.masses.sum())


def material_points(scene: Scene) -> list[FloatArray]:
    """Nodes of each body's mesh, at rest, evenly taken so that all are at most MOST_POINTS."""
    count = sum(len(body.mesh.points) for body in scene.characters)
    stride = -(-count // MOST_POINTS)
    return [body.mesh.points[::stride] for body in scene.characters]


def body_size(scene: Scene) -> float:
    """Longest side of the box around the character at rest, m."""
    return float(np.ptp(scene.character.mesh.bounds, axis=0).max())


class MaterialPointTracker:
    """Where material points are, by their weights in the tets of a mesh that holds them.

    On a refined mesh a node of the coarse one has a weight of one; a point that lies a little
    outside a coarser mesh is carried on linearly.
    """

    def __init__(self, scene: Scene, places: list[FloatArray]) -> None:
        """Find the tet of every place; ``places`` are of each body, at rest."""
        nodes, weights = [], []
        for body, part, points in zip(scene.characters, scene.parts, places, strict=True):
            tets, shares = _located(body.mesh.points, body.mesh.tets, points)
            nodes.append(tets + part.nodes.start)
            weights.append(shares)
        self._nodes = np.concatenate(nodes)
        self._weights = np.concatenate(weights)

    def __call__(self, positions: FloatArray) -> FloatArray:
        """Places (k, 3) m of the points for the positions of all nodes."""
        return np.asarray(np.einsum("kc,kca->ka", self._weights, positions[self._nodes]))


def _located(points: FloatArray, tets: IntArray, places: FloatArray) -> tuple[IntArray, FloatArray]:
    """Corners (k, 4) of the tets that hold the places, and the corners' weights (k, 4)."""
    centers = points[tets].mean(axis=1)
    count = min(NEAREST, len(tets))
    _, near = cKDTree(centers).query(places, k=count)
    near = near.reshape(len(places), count)
    corners = points[tets[near]]
    sides = np.moveaxis(corners[:, :, 1:] - corners[:, :, :1], -1, -2)
    inner = np.linalg.solve(sides, (places[:, None] - corners[:, :, 0])[..., None])[..., 0]
    weights = np.concatenate([1.0 - inner.sum(axis=-1, keepdims=True), inner], axis=-1)
    best = weights.min(axis=-1).argmax(axis=1)
    rows = np.arange(len(places))
    return tets[near[rows, best]], weights[rows, best]
