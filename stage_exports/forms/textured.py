"""A skin whose points have one place in a texture each, as glTF wants it."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.body.skin import SkinMaterial
from warp_softbody.stage_exports.conventions import IntArray
from warp_softbody.stage_exports.usd.reader import Take


class Textured(NamedTuple):
    """Points of a skin, some of them several times.

    Attributes:
        points: (p,) which of the skin's points each is.
        places: (p, 2) in the texture, v downwards; None without one.
        parts: faces (f, 3) over p, with their material; None for the body's own colour.
    """

    points: IntArray
    places: FloatArray | None
    parts: list[tuple[IntArray, SkinMaterial | None]]

    @classmethod
    def of(cls, take: Take) -> Textured:
        """Those of a body."""
        skin, faces = take.skin, take.skin_faces
        every: Any = np.arange(len(take.skin_rest), dtype=np.int32)
        places = None
        if skin is None:
            return cls(every, None, [(faces, None)])
        if skin.textured:
            corners = np.stack([faces.reshape(-1), skin.texture_faces.reshape(-1)], axis=1)
            pairs, number = np.unique(corners, axis=0, return_inverse=True)
            every, faces = pairs[:, 0], number.reshape(-1, 3).astype(np.int32)
            places = skin.texture_points[pairs[:, 1]] * (1.0, -1.0) + (0.0, 1.0)
        owners = skin.face_materials
        parts: list[tuple[IntArray, SkinMaterial | None]] = [
            (faces[owners == number], material)
            for number, material in enumerate(skin.materials)
            if (owners == number).any()
        ]
        return cls(every, places, parts)
