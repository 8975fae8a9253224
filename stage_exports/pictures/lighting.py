"""One sun and an even sky light a picture; how much of each reaches a point is computed here."""

from __future__ import annotations

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.stage_exports.pictures.raycast import Caster
from warp_softbody.stage_exports.pictures.surface import normalized
from warp_softbody.world.ground import Plane

SUN = normalized((-0.50, -0.55, 1.0))
SUN_COLOR = np.array([1.30, 1.24, 1.14])
SKY_COLOR = np.array([0.42, 0.46, 0.52])
BOUNCE_COLOR = np.array([0.30, 0.30, 0.30])

# Half the opening angle of the sun, as a tangent: the softness of a shadow's rim.
_SUN_RADIUS = 0.06


def sun_directions(count: int) -> FloatArray:
    """(count, 3) unit vectors spread evenly over the sun's disc."""
    spread = _SUN_RADIUS * _disc(count)
    side = normalized(np.cross(SUN, (0.0, 0.0, 1.0)))
    other = np.cross(SUN, side)
    return normalized(SUN + spread[:, :1] * side + spread[:, 1:] * other)


def sunlight(body: Caster, origins: FloatArray, count: int) -> FloatArray:
    """(r,) visible part of the sun's disc, 0..1."""
    visible = np.zeros(len(origins))
    for direction in sun_directions(count):
        rays = np.broadcast_to(direction, origins.shape)
        visible += ~body.blocks(origins, rays)
    return visible / count


def skylight(
    body: Caster,
    origins: FloatArray,
    normals: FloatArray,
    ground: Plane | None,
    reach: float,
    count: int,
) -> FloatArray:
    """(r, 3) light of sky and ground on surfaces, both dimmed by the body.

    Light that the ground throws back fades where the ray meets the ground closer than `reach`:
    there the body itself keeps the ground dark.
    """
    light = np.zeros((len(origins), 3))
    for sample in hemisphere(count):
        directions = _turned(sample, normals)
        free = ~body.blocks(origins, directions)
        light += free[:, None] * _radiance(origins, directions, ground, reach)
    return light / count


def hemisphere(count: int) -> FloatArray:
    """(count, 3) unit vectors around z, as dense as the cosine with z."""
    flat = _disc(count)
    height = np.sqrt(np.maximum(0.0, 1.0 - np.sum(flat**2, axis=1)))
    return np.column_stack([flat, height])


def _disc(count: int) -> FloatArray:
    """Sunflower seeds: even over the unit disc, without chance."""
    index = np.arange(count) + 0.5
    radius, angle = np.sqrt(index / count), np.pi * (1.0 + np.sqrt(5.0)) * index
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])


def _turned(sample: FloatArray, normals: FloatArray) -> FloatArray:
    """One direction given around z, turned to be around each normal (Duff et al. 2017)."""
    x, y, z = normals[:, 0], normals[:, 1], normals[:, 2]
    sign = np.where(z < 0.0, -1.0, 1.0)
    a = -1.0 / (sign + z)
    b = x * y * a
    first = np.stack([1.0 + sign * x * x * a, sign * b, -sign * x], axis=1)
    second = np.stack([b, sign + y * y * a, -y], axis=1)
    return np.asarray(sample[0] * first + sample[1] * second + sample[2] * normals)


def _radiance(
    origins: FloatArray, directions: FloatArray, ground: Plane | None, reach: float
) -> FloatArray:
    if ground is None:
        blend = 0.5 + 0.5 * directions[:, 2:]
        return np.asarray(BOUNCE_COLOR + blend * (SKY_COLOR - BOUNCE_COLOR))
    normal = np.array(ground.normal)
    down = -(directions @ normal)
    height = np.maximum(0.0, origins @ normal - ground.offset)
    distance = np.divide(height, down, out=np.full_like(height, np.inf), where=down > 1e-6)
    lit = np.clip(distance / reach, 0.0, 1.0)[:, None] * BOUNCE_COLOR
    return np.where(down[:, None] > 1e-6, lit, SKY_COLOR)
