"""Colours of skins: one a body, or those of their materials and textures."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.body.skin import Skin
from warp_softbody.errors import InputError
from warp_softbody.stage_exports.conventions import IntArray
from warp_softbody.stage_exports.pictures.libraries import imageio
from warp_softbody.stage_exports.pictures.raycast import Hits


class Albedo:
    """What part of the light the faces of a subject throw back, linear RGB."""

    def __init__(
        self, colors: FloatArray, face_bodies: IntArray, skins: Sequence[Skin | None]
    ) -> None:
        """Take the colours (b, 3) of bodies whose faces (f,) follow one another.

        Raises:
            InputError: a texture cannot be read.
        """
        self._colors = colors[face_bodies].copy()
        self._pictures: list[FloatArray] = []
        self._picture = np.full(len(face_bodies), -1, dtype=np.int32)
        self._places = np.zeros((len(face_bodies), 3, 2))
        for body, skin in enumerate(skins):
            if skin is not None:
                self._add(skin, np.flatnonzero(face_bodies == body))

    def _add(self, skin: Skin, faces: Any) -> None:
        if skin.textured:
            self._places[faces] = skin.texture_points[skin.texture_faces]
        for number, material in enumerate(skin.materials):
            own = faces[skin.face_materials == number]
            self._colors[own] = material.color
            if material.texture and skin.textured and len(own):
                self._picture[own] = len(self._pictures)
                self._pictures.append(_decoded(material.name, material.texture))

    def at(self, hits: Hits) -> FloatArray:
        """(r, 3) where rays hit."""
        colors = self._colors[hits.face]
        picture = self._picture[hits.face]
        for number, image in enumerate(self._pictures):
            own = picture == number
            places = np.einsum("rc,rcx->rx", hits.weights[own], self._places[hits.face[own]])
            colors[own] = _sampled(image, places)
        return np.asarray(colors)


def _sampled(image: FloatArray, places: FloatArray) -> FloatArray:
    """Bilinear, repeated beyond 0..1; the first row of an image is its top."""
    height, width, _ = image.shape
    across = places[:, 0] % 1.0 * width - 0.5
    down = (1.0 - places[:, 1]) % 1.0 * height - 0.5
    left, top = np.floor(across).astype(np.int64), np.floor(down).astype(np.int64)
    right, below = (across - left)[:, None], (down - top)[:, None]

    def texel(x: Any, y: Any) -> FloatArray:
        return np.asarray(image[y % height, x % width])

    upper = texel(left, top) * (1.0 - right) + texel(left + 1, top) * right
    lower = texel(left, top + 1) * (1.0 - right) + texel(left + 1, top + 1) * right
    return np.asarray(upper * (1.0 - below) + lower * below)


def _decoded(name: str, data: bytes) -> FloatArray:
    """(h, w, 3) linear RGB of a picture file."""
    reader = imageio()
    try:
        image = np.asarray(reader.imread(io.BytesIO(data)))
    except Exception as error:
        # whatever a library says of a damaged file
        cause = " ".join(str(error).split())[:120]
        raise InputError(f"the texture of material {name!r} cannot be read: {cause}") from error
    if image.ndim == 2:
        image = np.repeat(image[..., None], 3, axis=2)
    levels = image[..., :3].astype(np.float64) / float(np.iinfo(image.dtype).max)
    return np.where(levels <= 0.04045, levels / 12.92, ((levels + 0.055) / 1.055) ** 2.4)
