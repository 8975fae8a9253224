"""The bodies of a pose are coloured: lit skin, and fibres inside as if the flesh were clear."""

from __future__ import annotations

import numpy as np

from warp_softbody.arrays import BoolArray, FloatArray
from warp_softbody.stage_exports.conventions import IntArray
from warp_softbody.stage_exports.palette import activation_colors
from warp_softbody.stage_exports.pictures import lighting
from warp_softbody.stage_exports.pictures.albedo import Albedo
from warp_softbody.stage_exports.pictures.raycast import Caster, Hits
from warp_softbody.stage_exports.pictures.subject import Pose, Subject
from warp_softbody.stage_exports.pictures.surface import (
    FACES_PER_TUBE,
    CornerNormals,
    face_normals,
    normalized,
    tubes,
)
from warp_softbody.stage_exports.pictures.terrain import bounce_plane

# Parts of a body's diagonal: half a fibre's width, and how deep one sees into the flesh.
_TUBE_RADIUS = 0.0085
_CLEARNESS = 0.15


class LitBody:
    """A pose with its light, ready to be seen from anywhere."""

    def __init__(
        self, subject: Subject, albedo: Albedo, normals: CornerNormals, pose: Pose
    ) -> None:
        """Build the search trees and gather the sky's light."""
        self._subject = subject
        self._albedo = albedo
        self.caster = Caster(pose.skin, subject.faces)
        self._corner_normals = normals.at(pose.skin)
        self._flat_normals = normalized(face_normals(pose.skin, subject.faces))
        self._corner_light = self._sky_at_corners(pose.skin)
        points, faces = tubes(pose.segments, _TUBE_RADIUS * subject.sizes[subject.segment_bodies])
        self._fibers = Caster(points, faces)
        self._fiber_normals = normalized(face_normals(points, faces))
        self._fiber_colors = activation_colors(pose.activations)

    def paint(
        self, color: FloatArray, eye: FloatArray, directions: FloatArray, limit: FloatArray
    ) -> None:
        """Paint over (r, 3) `color` what rays see of the body before the distance `limit`."""
        origins = np.broadcast_to(eye, directions.shape)
        skin = self.caster.first(origins, directions)
        seen = np.isfinite(skin.distance) & (skin.distance <= limit)
        color[seen] = self._skin_colors(_chosen(skin, seen), eye, directions[seen])
        fiber = self._fibers.first(origins, directions)
        seen = np.isfinite(fiber.distance) & (fiber.distance < limit)
        seen[seen] = self._in_own_flesh(_chosen(fiber, seen), _chosen(skin, seen))
        shaded = self._fiber_shades(_chosen(fiber, seen), directions[seen])
        depth = fiber.distance[seen] - skin.distance[seen]
        depth = np.where(np.isfinite(depth), np.maximum(0.0, depth), 0.0)
        sizes = self._subject.sizes[self._owners(fiber.face[seen])]
        cover = np.exp(-depth / (_CLEARNESS * sizes))
        color[seen] += cover[:, None] * (shaded - color[seen])

    def _owners(self, fiber_faces: IntArray) -> IntArray:
        """Which body each face of the tubes belongs to."""
        return self._subject.segment_bodies[fiber_faces // FACES_PER_TUBE]

    def _in_own_flesh(self, fiber: Hits, skin: Hits) -> BoolArray:
        """Whether the skin in front of a fibre, if there is any, is that of its own body."""
        if not len(self._subject.face_bodies):
            return np.ones(len(fiber.face), dtype=bool)
        own = self._owners(fiber.face) == self._subject.face_bodies[skin.face]
        return np.asarray(own | (skin.distance >= fiber.distance))

    def _sky_at_corners(self, skin: FloatArray) -> FloatArray:
        """(f, 3, 3) sky light at the corners: smooth, so that a few rays a corner are enough."""
        size = self._subject.size
        corners = skin[self._subject.faces]
        # A little into the face and off it, so that a neighbour across a crease is not hit at once.
        inner = corners + 0.05 * (corners.mean(axis=1, keepdims=True) - corners)
        origins = inner + 1e-3 * size * self._flat_normals[:, None, :]
        normals = self._corner_normals.reshape(-1, 3)
        ground = self._subject.ground
        bounce = None if ground is None else bounce_plane(ground)
        light = lighting.skylight(
            self.caster, origins.reshape(-1, 3), normals, bounce, 0.5 * size, 32
        )
        return light.reshape(-1, 3, 3)

    def _skin_colors(self, hits: Hits, eye: FloatArray, directions: FloatArray) -> FloatArray:
        normal = normalized(np.einsum("rc,rci->ri", hits.weights, self._corner_normals[hits.face]))
        sky = np.einsum("rc,rci->ri", hits.weights, self._corner_light[hits.face])
        offset = 5e-4 * self._subject.size * self._flat_normals[hits.face]
        origins = eye + hits.distance[:, None] * directions + offset
        sun = lighting.sunlight(self.caster, origins, 6)
        half = normalized(lighting.SUN - directions)
        shine = 0.10 * sun * np.maximum(0.0, np.einsum("ri,ri->r", normal, half)) ** 30
        sun *= np.maximum(0.0, normal @ lighting.SUN)
        rim = 0.15 * (1.0 - np.abs(np.einsum("ri,ri->r", normal, directions))) ** 4
        light = sun[:, None] * lighting.SUN_COLOR + sky
        color = self._albedo.at(hits) * light
        return np.asarray(color + shine[:, None] * lighting.SUN_COLOR + rim[:, None] * sky)

    def _fiber_shades(self, hits: Hits, directions: FloatArray) -> FloatArray:
        """Brighter where a tube faces the eye, so that it looks round."""
        facing = np.abs(np.einsum("ri,ri->r", self._fiber_normals[hits.face], directions))
        colors = self._fiber_colors[hits.face // FACES_PER_TUBE]
        return np.asarray(colors * (0.55 + 0.75 * facing)[:, None])


def _chosen(hits: Hits, which: BoolArray) -> Hits:
    return Hits(hits.distance[which], hits.face[which], hits.weights[which])
