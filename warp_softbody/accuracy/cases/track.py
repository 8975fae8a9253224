"""What a run leaves for its chart: frames of all nodes, and the places of some material points."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.body.point_location import locate
from warp_softbody.world.scene import Scene

MOST_POINTS = 200
NEAREST = 64
"""Tets that are tried for each point."""


@dataclass(frozen=True, kw_only=True)
class Soundness:
    """What has to stay small in every motion, seen at 60 frames a second.

    Attributes:
        volume: largest change of the volume of all bodies, as a share of it.
        reversals: share of the nodes' accelerations that turn against those of the frame before.
    """

    volume: float
    reversals: float


@dataclass(frozen=True, kw_only=True)
class Track:
    """A body, or several, over time.

    Attributes:
        scene: what was run.
        times: (f,) s.
        points: (f, n, 3) m, all nodes.
        masses: (n,) kg.
        soundness: what was seen of it between the frames.
    """

    scene: Scene
    times: FloatArray
    points: FloatArray
    masses: FloatArray
    soundness: Soundness = field(default_factory=lambda: Soundness(volume=0.0, reversals=0.0))

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
            mesh = body.mesh
            location = locate(mesh.points, mesh.tets, points, nearest=NEAREST)
            nodes.append(mesh.tets[location.tets] + part.nodes.start)
            weights.append(location.weights)
        self._nodes = np.concatenate(nodes)
        self._weights = np.concatenate(weights)

    def __call__(self, positions: FloatArray) -> FloatArray:
        """Places (k, 3) m of the points for the positions of all nodes."""
        return np.asarray(np.einsum("kc,kca->ka", self._weights, positions[self._nodes]))
