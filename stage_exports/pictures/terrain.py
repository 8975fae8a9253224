"""Uneven ground in a picture gets the floor's grid and shadow, laid over its triangles."""

from __future__ import annotations

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.stage_exports.pictures import lighting
from warp_softbody.stage_exports.pictures.floor import Floor, FloorRays
from warp_softbody.stage_exports.pictures.raycast import Caster
from warp_softbody.stage_exports.pictures.surface import face_normals, normalized
from warp_softbody.stage_exports.usd.grounds import surface_of
from warp_softbody.world.friction_map import map_of
from warp_softbody.world.ground import Ground, Plane


def make_floor(ground: Ground, rest: FloatArray, size: float) -> Floor:
    """What a picture shows of a ground under bodies with rest points (k, 3), the largest `size`."""
    if isinstance(ground, Plane):
        return Floor(ground, rest, size)
    return Terrain(ground, rest, size)


def bounce_plane(ground: Ground) -> Plane:
    """The plane that throws light back at a body: the ground, or one at its mean height."""
    if isinstance(ground, Plane):
        return ground
    vertices, _ = surface_of(ground)
    placed = map_of(ground)
    offset = float((vertices @ np.array(ground.normal)).mean())
    return Plane(normal=ground.normal, offset=offset, friction=ground.friction, friction_map=placed)


class Terrain(Floor):
    """Triangles with the floor's grid as seen from above."""

    def __init__(self, ground: Ground, rest: FloatArray, size: float) -> None:
        """Build the search tree; `rest` and `size` as for a floor."""
        super().__init__(bounce_plane(ground), rest, size)
        vertices, faces = surface_of(ground)
        self._caster = Caster(vertices, faces)
        self._face_normals = normalized(face_normals(vertices, faces))
        self._top = float((vertices @ self.normal).max()) + self.size

    def see(self, eye: FloatArray, directions: FloatArray, pixel: float) -> FloorRays:
        """What rays from the eye meet; `pixel` is a pixel's angle."""
        hits = self._caster.first(np.broadcast_to(eye, directions.shape), directions)
        hit = np.isfinite(hits.distance)
        flat = (eye + hits.distance[hit, None] * directions[hit]) @ self.axes.T
        normals = self._face_normals[hits.face[hit]]
        slant = np.maximum(1e-3, -np.einsum("ri,ri->r", directions[hit], normals))
        footprint = (hits.distance[hit] * pixel / slant)[:, None]
        shade = self.albedo(flat, np.broadcast_to(footprint, flat.shape))
        # the shadow map knows the light on level ground; a slope sees more or less of the sun
        level = max(1e-3, float(lighting.SUN @ self.normal))
        turned = np.clip(normals @ lighting.SUN / level, 0.0, 1.5)
        albedo = shade * (0.5 + 0.5 * turned)
        return FloorRays(
            hits.distance,
            hit,
            flat.astype(np.float32),
            albedo[:, None].astype(np.float32),
            np.zeros((int(hit.sum()), 3), dtype=np.float32),
        )

    def lifted(self, flat: FloatArray) -> FloatArray:
        """Points just above the ground over places (k, 2) in the floor's own axes."""
        above = flat @ self.axes + self._top * self.normal
        down = np.broadcast_to(-self.normal, above.shape)
        distance = self._caster.first(above, down).distance
        distance = np.where(np.isfinite(distance), distance, self._top - self.offset)
        return np.asarray(above - (distance - 1e-3 * self.size)[:, None] * self.normal)
