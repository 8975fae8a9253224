"""What a page has to know of a scene once: surfaces, fibres, ground and the names of numbers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.stage_exports.creases import cut_along_creases
from warp_softbody.stage_exports.layout import segment_ends
from warp_softbody.world.friction_map import map_of
from warp_softbody.world.ground import Ground, Plane
from warp_softbody.world.height_field import HeightField
from warp_softbody.world.scene import Scene
from warp_softbody.world.triangle_ground import TriangleGround

IntArray = npt.NDArray[np.int32]
DIGITS = 5
"""Decimals, m, of what stands still."""


@dataclass(frozen=True, kw_only=True)
class ShownBody:
    """A body as the page shows it.

    Attributes:
        name: of the body.
        color: linear RGB.
        corners: (c,) row of the shown points at each corner of its skin; a point on a sharp edge
            has a corner on each side.
        faces: (f, 3) triangles over its corners, outward.
    """

    name: str
    color: tuple[float, float, float]
    corners: IntArray
    faces: IntArray

    def as_json(self) -> dict[str, Any]:
        """As the page reads it."""
        return {
            "name": self.name,
            "color": list(self.color),
            "corners": self.corners.tolist(),
            "faces": self.faces.ravel().tolist(),
        }


@dataclass(frozen=True, kw_only=True)
class SceneOutline:
    """What never changes while a scene is shown.

    Attributes:
        name: of the scene.
        fps: updates per simulated second.
        bodies: the character first.
        points: (k, 3) m, of all surfaces in the start pose.
        segments: (s, 2) rows of the fibre points that each muscle segment joins.
        fiber_points: how many there are.
        ground: what it moves on, or None.
        numbers: names of the numbers of an update, in their order.
        weight: N, of the character; None where it is not known.
    """

    name: str
    fps: float
    bodies: tuple[ShownBody, ...]
    points: FloatArray
    segments: IntArray
    fiber_points: int
    ground: Ground | None
    numbers: tuple[str, ...]
    weight: float | None

    def as_json(self) -> dict[str, Any]:
        """As the page reads it."""
        return {
            "name": self.name,
            "fps": self.fps,
            "bodies": [body.as_json() for body in self.bodies],
            "points": len(self.points),
            "fiberPoints": self.fiber_points,
            "segments": self.segments.ravel().tolist(),
            "low": self.points.min(axis=0).tolist(),
            "high": self.points.max(axis=0).tolist(),
            "ground": ground_as_json(self.ground),
            "numbers": list(self.numbers),
            "weight": self.weight,
        }


def ground_as_json(ground: Ground | None) -> dict[str, Any] | None:
    """A plane by normal and offset, another ground by its triangles; where its friction differs."""
    if ground is None:
        return None
    told: dict[str, Any] = {"normal": list(ground.normal)}
    if isinstance(ground, HeightField | TriangleGround):
        vertices, faces = ground.triangles()
        told["vertices"] = np.round(vertices, DIGITS).ravel().tolist()
        told["faces"] = faces.ravel().tolist()
    else:
        told["offset"] = ground.offset if isinstance(ground, Plane) else 0.0
    placed = map_of(ground)
    if placed is not None:
        told["friction"] = {
            "factors": np.round(placed.factors, DIGITS).ravel().tolist(),
            "columns": placed.factors.shape[1],
            "spacing": list(placed.spacing),
            "origin": list(placed.origin),
        }
    return told


def shown_nodes(scene: Scene) -> IntArray:
    """(k,) nodes of all surfaces, ascending: what a page is sent the positions of."""
    return np.unique(np.asarray(scene.whole.mesh.surface)).astype(np.int32)


def shown_bodies(scene: Scene) -> tuple[ShownBody, ...]:
    """The bodies of a scene over the rows of its shown nodes."""
    nodes = shown_nodes(scene)
    bodies = []
    for character, part in zip(scene.characters, scene.parts, strict=True):
        mesh = character.mesh
        skin = cut_along_creases(np.asarray(mesh.points), np.asarray(mesh.surface))
        rows = np.searchsorted(nodes, np.asarray(skin.nodes) + part.nodes.start)
        bodies.append(
            ShownBody(
                name=character.name,
                color=character.color,
                corners=rows.astype(np.int32),
                faces=np.asarray(skin.faces),
            )
        )
    return tuple(bodies)


def scene_segments(scene: Scene) -> tuple[IntArray, int]:
    """Rows of a frame's fibre points that each segment joins, and how many points there are."""
    counts = [len(fiber.vertices) for fiber in scene.whole.fibers]
    return segment_ends(counts), sum(counts)
