"""A pose is rendered: the floor first, then the bodies where they can be, then finer edges."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import BoolArray, FloatArray
from warp_softbody.stage_exports.camera import Camera
from warp_softbody.stage_exports.pictures.albedo import Albedo
from warp_softbody.stage_exports.pictures.floor import BACKDROP, Floor, FloorLight, FloorRays
from warp_softbody.stage_exports.pictures.skin import LitBody
from warp_softbody.stage_exports.pictures.subject import Pose, Subject
from warp_softbody.stage_exports.pictures.surface import CornerNormals, normalized
from warp_softbody.stage_exports.pictures.terrain import make_floor

Image = npt.NDArray[np.uint8]

# Where colours jump, a pixel is the mean of rays through a rotated grid inside it.
_FINE = np.array([[0.125, 0.625], [0.375, 0.125], [0.625, 0.875], [0.875, 0.375]]) - 0.5
_EDGE_STEP = 0.04
# Pixels around the bodies' outline that are still searched for it: fibres may stand out a little.
_BORDER = 8


class Renderer:
    """Draws poses of one subject through a camera, which may be moved between them."""

    def __init__(self, subject: Subject, camera: Camera, size: tuple[int, int]) -> None:
        """Prepare what all frames share."""
        self._subject = subject
        self.width, self.height = size
        self._normals = CornerNormals(subject.rest, subject.faces)
        self._albedo = Albedo(subject.colors, subject.face_bodies, subject.skins)
        self.floor: Floor | None = None
        if subject.ground is not None:
            self.floor = make_floor(subject.ground, subject.rest, subject.size)
        self._rows, self._columns = np.divmod(np.arange(self.width * self.height), self.width)
        self.look(camera)

    def look(self, camera: Camera) -> None:
        """Draw through this camera from now on; poses that share one see the floor once."""
        self._camera = camera
        self._pixel = 2.0 * np.tan(np.radians(camera.vertical_field) / 2.0) / self.height
        self._directions = self._through(self._rows, self._columns)
        self._rays = self._see_floor(self._directions)

    def draw(self, pose: Pose, *, background: FloatArray = BACKDROP) -> Image:
        """(height, width, 3) picture in sRGB, 8 bits a channel, before a linear RGB."""
        body = LitBody(self._subject, self._albedo, self._normals, pose)
        light = None if self.floor is None else FloorLight(self.floor, body.caster, pose.skin)
        color = _floor_colors(light, self._rays, len(self._directions), background)
        near = self._around(pose)
        limit = np.inf if self._rays is None else self._rays.distance[near]
        part = color[near]
        body.paint(
            part, self._camera.eye, self._directions[near], np.broadcast_to(limit, len(near))
        )
        color[near] = part
        image = tone(color)
        edges = np.flatnonzero(_edges(image.reshape(self.height, self.width, 3)))
        image[edges] = self._fine(body, light, edges, background)
        return (image * 255.0 + 0.5).astype(np.uint8).reshape(self.height, self.width, 3)

    def _fine(
        self,
        body: LitBody,
        light: FloorLight | None,
        pixels: npt.NDArray[np.intp],
        background: FloatArray,
    ) -> FloatArray:
        total = np.zeros((len(pixels), 3))
        for down, right in _FINE:
            rays = self._through(self._rows[pixels] + down, self._columns[pixels] + right)
            floor = self._see_floor(rays)
            color = _floor_colors(light, floor, len(rays), background)
            limit = np.inf if floor is None else floor.distance
            body.paint(color, self._camera.eye, rays, np.broadcast_to(limit, len(rays)))
            total += tone(color)
        return total / len(_FINE)

    def _through(
        self,
        rows: npt.NDArray[np.intp] | FloatArray,
        columns: npt.NDArray[np.intp] | FloatArray,
    ) -> FloatArray:
        """Unit vectors from the eye through pixels, fractions of pixels included."""
        right, up = self._camera.axes
        across = (columns + 0.5 - self.width / 2.0)[:, None] * self._pixel
        above = (self.height / 2.0 - rows - 0.5)[:, None] * self._pixel
        return normalized(self._camera.forward + across * right + above * up)

    def _see_floor(self, directions: FloatArray) -> FloorRays | None:
        if self.floor is None:
            return None
        return self.floor.see(self._camera.eye, directions, self._pixel)

    def places(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """(k, 2) columns and rows at which points (k, 3) m are seen, and their depths (k,) m."""
        right, up = self._camera.axes
        away = points - self._camera.eye
        depth = away @ self._camera.forward
        ahead = np.where(depth > 0.0, depth, np.nan)
        columns = away @ right / ahead / self._pixel + self.width / 2.0
        rows = self.height / 2.0 - away @ up / ahead / self._pixel
        return np.stack([columns, rows], axis=1), depth

    def _around(self, pose: Pose) -> npt.NDArray[np.intp]:
        """Pixels of the rectangle around the bodies; all of them if one reaches behind the eye."""
        shown = np.concatenate([pose.skin, pose.segments.reshape(-1, 3)])
        places, depth = self.places(shown)
        columns, rows = places.T
        if depth.min() <= 1e-3 * self._subject.size:
            return np.arange(len(self._directions))
        inside = (self._columns >= columns.min() - _BORDER) & (
            self._columns <= columns.max() + _BORDER
        )
        inside &= (self._rows >= rows.min() - _BORDER) & (self._rows <= rows.max() + _BORDER)
        return np.flatnonzero(inside)


def _floor_colors(
    light: FloorLight | None, rays: FloorRays | None, count: int, background: FloatArray
) -> FloatArray:
    color = np.tile(background, (count, 1))
    if light is not None and rays is not None:
        color[rays.hit] = light.colors(rays)
    return color


def tone(radiance: FloatArray) -> npt.NDArray[np.float32]:
    """Linear light as sRGB in 0..1, with a soft shoulder instead of burnt-out highlights."""
    linear = np.maximum(radiance, 0.0).astype(np.float32)
    high = linear > 0.6
    linear[high] = 1.0 - 0.4 * np.exp(-(linear[high] - 0.6) / 0.4)
    gamma = 1.055 * np.power(linear, np.float32(1.0 / 2.4)) - 0.055
    return np.where(linear <= 0.0031308, 12.92 * linear, gamma)


def _edges(image: npt.NDArray[np.float32]) -> BoolArray:
    """Pixels that differ visibly from a neighbour to the right or below, and these neighbours."""
    level = image @ np.array([0.35, 0.40, 0.25], dtype=np.float32)
    found = np.zeros(level.shape, dtype=bool)
    across = np.abs(np.diff(level, axis=1)) > _EDGE_STEP
    along = np.abs(np.diff(level, axis=0)) > _EDGE_STEP
    found[:, 1:] |= across
    found[:, :-1] |= across
    found[1:] |= along
    found[:-1] |= along
    return found.reshape(-1)
