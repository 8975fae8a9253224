"""The ground in a picture has a fine grid, the bodies' soft shadow and a fade into the backdrop."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from warp_softbody.arrays import BoolArray, FloatArray
from warp_softbody.stage_exports import palette
from warp_softbody.stage_exports.pictures import lighting
from warp_softbody.stage_exports.pictures.raycast import Caster
from warp_softbody.stage_exports.pictures.ruler import FloorRuler
from warp_softbody.stage_exports.pictures.surface import normalized
from warp_softbody.stage_exports.round_lengths import round_length
from warp_softbody.world.ground import Plane

BACKDROP = np.array([0.46, 0.51, 0.58])

_TEXELS = 176
_LINE_SHADE = 0.78
# Thin lines at every step, thicker ones at every fifth; half widths as parts of the diagonal.
_LINES = ((1, 0.002), (5, 0.005))


class FloorRays(NamedTuple):
    """What rays meet of a floor, whatever stands on it; a still camera asks once.

    Attributes:
        distance: (r,) m; infinite for rays that miss.
        hit: (r,) whether the ray meets the floor.
        flat: (h, 2) m, where the hitting rays do, in the floor's own axes.
        albedo: (h, 1) brightness of the ground there, grid included, less what the fade takes.
        backdrop: (h, 3) what the fade adds.
    """

    distance: FloatArray
    hit: BoolArray
    flat: FloatArray
    albedo: FloatArray
    backdrop: FloatArray


class Floor:
    """A plane with a grid that fades into the backdrop away from where the bodies start."""

    def __init__(self, plane: Plane, rest: FloatArray, size: float) -> None:
        """Lay the grid along x and y, or what comes closest on a slope.

        Args:
            plane: where it lies.
            rest: (k, 3) m, points of all bodies.
            size: diagonal of the largest body, m.
        """
        self.normal = np.array(plane.normal)
        self.offset = plane.offset
        self._placed = plane.friction_map
        self.size = size
        helper = np.array([0.0, 1.0, 0.0])
        if abs(self.normal[1]) > 0.9:
            helper = np.array([0.0, 0.0, 1.0])
        first = normalized(np.cross(helper, self.normal))
        self.axes = np.stack([first, np.cross(self.normal, first)])
        self._reach = float(np.linalg.norm(np.ptp(rest, axis=0)))
        self._middle = (rest @ self.axes.T).mean(axis=0)
        self._spacing = grid_spacing(self.size)
        self.ruler: FloorRuler | None = None

    def see(self, eye: FloatArray, directions: FloatArray, pixel: float) -> FloorRays:
        """What rays from the eye meet; `pixel` is a pixel's angle."""
        height = float(eye @ self.normal) - self.offset
        down = -(directions @ self.normal)
        hit = (down > 1e-6) & (height > 0.0)
        distance = np.divide(height, down, out=np.full(len(down), np.inf), where=hit)
        flat = (eye + distance[hit, None] * directions[hit]) @ self.axes.T
        away = np.linalg.norm(flat - self._middle, axis=1) / self._reach
        fade = np.clip((away - 1.5) / 5.0, 0.0, 1.0)[:, None]
        fade = fade * fade * (3.0 - 2.0 * fade)
        # Seen at a slant, a pixel covers more ground along the view than across it.
        along = (directions[hit] @ self.axes.T) ** 2 / down[hit, None] ** 2
        footprint = distance[hit, None] * pixel * np.sqrt(1.0 + along)
        albedo = self.albedo(flat, footprint)[:, None] * (1.0 - fade)
        return FloorRays(
            distance,
            hit,
            flat.astype(np.float32),
            albedo.astype(np.float32),
            (BACKDROP * fade).astype(np.float32),
        )

    def lifted(self, flat: FloatArray) -> FloatArray:
        """Points just above the floor over places (k, 2) in its own axes."""
        return np.asarray(flat @ self.axes + (self.offset + 1e-4 * self.size) * self.normal)

    def albedo(self, flat: FloatArray, footprint: FloatArray) -> FloatArray:
        """(r,) brightness of grid and ruler, antialiased by the ground that a pixel covers."""
        shade = np.ones(len(flat))
        if self._placed is not None:
            places = flat @ self.axes + self.offset * self.normal
            shade *= palette.friction_shade(self._placed.at(places))
        for step, width in _LINES:
            spacing, half = step * self._spacing, width * self.size
            offset = np.abs((flat / spacing + 0.5) % 1.0 - 0.5) * spacing
            cover = np.clip((half - offset) / footprint + 0.5, 0.0, 1.0)
            cover *= np.minimum(1.0, 2.0 * half / footprint)
            cover *= np.clip(spacing / (5.0 * footprint) - 0.2, 0.0, 1.0)
            shade *= np.prod(1.0 - (1.0 - _LINE_SHADE) * cover, axis=1)
        if self.ruler is not None:
            cover, bright = self.ruler.shade(flat, footprint)
            shade += cover * (bright - shade)
        return shade


class FloorLight:
    """The light that one pose lets through to the floor, measured on a square around the bodies."""

    def __init__(self, floor: Floor, body: Caster, skin: FloatArray) -> None:
        """Cast the shadow."""
        flat = skin @ floor.axes.T
        self._middle = (flat.min(axis=0) + flat.max(axis=0)) / 2.0
        half = 0.5 * float(np.ptp(flat, axis=0).max()) + 1.2 * floor.size
        # the shadow of what is high above the floor falls far away
        height = skin @ floor.normal - floor.offset
        steep = max(0.2, float(lighting.SUN @ floor.normal))
        cast = flat - np.outer(height, floor.axes @ lighting.SUN) / steep
        self._half = max(half, float(np.abs(cast - self._middle).max()) + 0.2 * floor.size)
        ticks = ((np.arange(_TEXELS) + 0.5) / _TEXELS - 0.5) * 2.0 * self._half
        square = np.stack(np.meshgrid(ticks, ticks, indexing="ij"), axis=-1).reshape(-1, 2)
        light = _light(body, floor.lifted(self._middle + square), floor).reshape(
            _TEXELS, _TEXELS, 3
        )
        self._map = ndimage.gaussian_filter(light, (0.8, 0.8, 0.0), mode="nearest")

    def colors(self, rays: FloorRays) -> npt.NDArray[np.float32]:
        """(h, 3) radiance of the floor where rays hit it."""
        steps = (rays.flat - self._middle) / (2.0 * self._half) + 0.5
        steps = np.clip(steps * _TEXELS - 0.5, 0.0, _TEXELS - 1.001).astype(np.float32)
        low = steps.astype(np.int32)
        part = steps - low
        texels = (self._map * palette.GROUND).astype(np.float32).reshape(-1, 3)
        start = low[:, 0] * _TEXELS + low[:, 1]
        right, up = part[:, 1:], part[:, :1]
        lower = texels[start] * (1 - right) + texels[start + 1] * right
        upper = texels[start + _TEXELS] * (1 - right) + texels[start + _TEXELS + 1] * right
        light = lower + up * (upper - lower)
        return np.asarray(rays.albedo * light + rays.backdrop, dtype=np.float32)


def _light(body: Caster, points: FloatArray, floor: Floor) -> FloatArray:
    normals = np.broadcast_to(floor.normal, points.shape)
    facing = max(0.0, float(lighting.SUN @ floor.normal))
    sun = lighting.sunlight(body, points, 10) * facing
    sky = lighting.skylight(body, points, normals, None, floor.size, 20)
    return np.asarray(sun[:, None] * lighting.SUN_COLOR + sky)


def grid_spacing(size: float) -> float:
    """A round length (1, 2 or 5 times a power of ten) near an eighth of the body."""
    return round_length(size / 8.0)
